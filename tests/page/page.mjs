// The operator's window in a real browser: node page.mjs PROGRAM BUILD_FOLDER [PATTERN]
import assert from 'node:assert/strict';
import {mkdirSync, readdirSync, statSync} from 'node:fs';
import {join} from 'node:path';
import {after, test} from 'node:test';
import {gzipSync} from 'node:zlib';
import {readFileSync} from 'node:fs';
import {browser, build, closeAll, coloursOf, ferrule, folder, open, view, violations} from './browser.mjs';

/** @typedef {import('playwright-core').Page} Page */

const pattern = new RegExp(process.argv[4] ?? '');
const pictures = join(build, 'page-pictures');
mkdirSync(pictures, {recursive: true});
const episodes = join(folder, 'episodes');
ferrule('record', '--scene', 'demo', '--skill', '0.8', '--episodes', '2', '--seed', '1', '--out', episodes);

/** @param {string} name @param {() => Promise<void>} body */
const check = (name, body) => pattern.test(name) && test(name, {timeout: 240_000}, async () => {
  try {
    await body();
  } finally {
    await closeAll();  // one that failed does not slow the next
  }
});
after(() => browser.close());

/** A row of the picture, by the names of columns. @param {Page} page @param {string[]} names */
const row = (page, ...names) => page.evaluate((wanted) => {
  const {live, replay} = globalThis.ferrule;
  const read = live ? live.newest.read(0) : replay.shown.table.read(replay.row);
  return Object.fromEntries(wanted.map((name) => [name, read(name)]));
}, names);

/** @param {number} ms */
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/**
 * Inserts a fibre by looking at the picture's numbers: aligns it, then pushes. `steer` is told the
 * ways wanted (y, z, x; -1, 0, 1) and whether they are to be small; `stop` ends the try.
 * @param {Page} page @param {(way: {x: number, y: number, z: number}, fine: boolean) => Promise<void>} steer
 */
async function insert(page, steer, stop = () => page.keyboard.press('Enter')) {
  for (const begin = Date.now(); Date.now() - begin < 100_000;) {
    if (!await page.evaluate(() => globalThis.ferrule.session.running)) break;
    if (await page.locator('#phase').getAttribute('data-phase') === 'seated') break;
    const r = await row(page, 'tip_y_um', 'tip_z_um', 'velocity_y_um_s', 'velocity_z_um_s', 'depth_um');
    // Where it will be when the hand is heard; within a micrometre the cone does the rest.
    const y = r.tip_y_um + 0.15 * r.velocity_y_um_s, z = r.tip_z_um + 0.15 * r.velocity_z_um_s;
    const miss = Math.max(Math.abs(y), Math.abs(z)), aligned = miss < 1.2 || r.depth_um > 0;
    const toward = (/** @type {number} */ off) => aligned || Math.abs(off) < 0.8 ? 0 : -Math.sign(off);
    await steer({x: aligned ? -1 : 0, y: toward(y), z: toward(z)}, miss < 4 && !aligned);
    await pause(15);
  }
  await steer({x: 0, y: 0, z: 0}, false);
  await stop();
}

/** The only episode in `out` is an insertion, whole, and verifies. @param {string} out */
function expectInserted(out) {
  const files = readdirSync(out).filter((name) => name.endsWith('.h5'));
  assert.equal(files.length, 1);
  const file = join(out, files[0]);
  const said = JSON.parse(ferrule('replay', file, '--verify', '--json'));
  assert.equal(said.outcome, 'inserted');
  assert.equal(said.identical, true);
  assert.equal(said.rows, Math.round(said.recorded_s * 1000) + 1, 'a row for every millisecond');
}

/** @param {Page} page */
async function ready(page) {
  await page.waitForFunction(() => globalThis.ferrule?.live?.newest?.rows > 0);
}

check('the bundle is small', async () => {
  const page = readFileSync(join(build, 'view/page.html'));
  assert.ok(gzipSync(page).length < 1_000_000);
  assert.ok(page.length < 3_000_000);
});

check('live: draws, moves with the simulation, inserts by arrow keys alone, loses nothing in a reload', async () => {
  const out = join(folder, 'keys');
  const server = await view('--scene', 'demo', '--seed', '5', '--out', out);
  const {page, amiss} = await open(server.address);
  await ready(page);
  for (const canvas of ['#solid', '#side', '#axis']) assert.ok(await coloursOf(page, canvas) > 20, `${canvas} is uniform`);
  const held = new Set();
  const hold = async (/** @type {string} */ key, /** @type {boolean} */ on) => {
    if (held.has(key) === on) return;
    if (on) held.add(key);
    else held.delete(key);
    await (on ? page.keyboard.down(key) : page.keyboard.up(key));
  };
  const steer = async (/** @type {{x: number, y: number, z: number}} */ way, /** @type {boolean} */ fine) => {
    // Arrows mean another thing with Shift: one at a time.
    const push = way.x !== 0;
    if (push) for (const key of ['ArrowLeft', 'ArrowRight', 'ArrowDown']) await hold(key, false);
    if (!push && held.has('Shift')) await hold('ArrowUp', false);
    await hold('Shift', push);
    await hold('f', fine && !push);
    await hold('ArrowUp', push || way.y > 0);
    await hold('ArrowDown', !push && way.y < 0);
    await hold('ArrowLeft', !push && way.z > 0);
    await hold('ArrowRight', !push && way.z < 0);
  };
  const before = await page.locator('#side').screenshot();
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  const start = await row(page, 'tip_y_um');
  await hold('ArrowUp', true);
  await page.waitForFunction((y) => globalThis.ferrule.live.newest.read(0)('tip_y_um') > y + 2, start.tip_y_um);
  await hold('ArrowUp', false);
  assert.ok(!before.equals(await page.locator('#side').screenshot()), 'the fibre on the screen moved');
  await page.reload();
  held.clear();
  await ready(page);
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  await insert(page, steer);
  await page.waitForSelector('#ended:not([hidden])');
  console.log(`# after it: ${await page.locator('#ended').innerText()}`.replaceAll('\n', '; '));
  console.log(`# ${await page.evaluate(() => `hand to picture ${globalThis.ferrule.live.medianLatency().toFixed(0)} ms (median)`)}`);
  assert.deepEqual(await violations(page), []);
  await page.screenshot({path: join(pictures, 'live-after.png')});
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
  expectInserted(out);
});

const kGamepad = `
  const pad = {connected: true, id: 'test', index: 0, mapping: 'standard', timestamp: 0, axes: [0, 0, 0, 0],
    buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0}))};
  globalThis.testPad = pad;
  navigator.getGamepads = () => [pad];`;

check('live: inserts by a gamepad alone', async () => {
  const out = join(folder, 'gamepad');
  const server = await view('--scene', 'demo', '--seed', '6', '--out', out);
  const {page, amiss} = await open(server.address, {script: kGamepad});
  await ready(page);
  const press = () => page.evaluate(async () => {
    globalThis.testPad.buttons[0].pressed = true;
    await new Promise((done) => setTimeout(done, 300));
    globalThis.testPad.buttons[0].pressed = false;
  });
  await press();
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  await insert(page, (way, fine) => page.evaluate(([x, y, z, share]) => {
    const pad = globalThis.testPad;
    pad.axes[0] = -z * share;
    pad.axes[1] = -y * share;
    pad.buttons[7].value = x < 0 ? 0.8 : 0;
    pad.buttons[6].value = x > 0 ? 0.8 : 0;
  }, [way.x, way.y, way.z, fine ? 0.25 : way.x ? 0.2 : 0.8]), press);
  await page.waitForSelector('#ended:not([hidden])');
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
  expectInserted(out);
});

check('replay: scrubs, jumps to events, lays one episode over another', async () => {
  const server = await view(episodes);
  const {page, amiss} = await open(server.address);
  await page.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
  await page.locator('#scrub').fill('3');
  assert.ok(Math.abs((await row(page, 't_s')).t_s - 3) < 0.002);
  const early = await page.locator('#side').screenshot();
  await page.locator('#scrub').fill('12');
  await pause(200);
  assert.ok(!early.equals(await page.locator('#side').screenshot()));
  // The numbers beside it are those of the row.
  const depth = (await row(page, 'depth_um')).depth_um;
  assert.equal(await page.locator('#value-depth').innerText(), depth.toFixed(2));
  await page.locator('#tab-events').click();
  const texts = await page.locator('#events button').allInnerTexts();
  assert.ok(texts.some((text) => text.includes('touches the cone')), texts.join());
  await page.locator('#scrub').fill('0');
  await page.locator('#event-after').click();
  assert.equal((await page.locator('#clock').innerText()).split(' /')[0], texts[0].split(' s')[0]);
  const one = await page.locator('#axis').screenshot();
  await page.locator('#over').selectOption({index: 2});
  await page.waitForFunction(() => globalThis.ferrule.replay.over?.loaded);
  await pause(300);
  assert.ok(!one.equals(await page.locator('#axis').screenshot()), 'the other is seen');
  await page.locator('#speed').selectOption('10');
  await page.locator('#play').click();
  await page.waitForSelector('#outcome:not([hidden])');
  assert.match(await page.locator('#outcome').innerText(), /inserted/);
  assert.deepEqual(await violations(page), []);
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
});

check('a failed trial that is clicked in the map plays and ends with its outcome', async () => {
  const report = join(folder, 'report.html');
  ferrule('evaluate', '--baseline', 'constant-velocity', '--scene', 'bench', '--trials', '40', '--report', report);
  const {page, amiss} = await open('file://' + report);
  const frame = await (await page.waitForSelector('iframe.replay')).contentFrame();
  await frame.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
  const trial = await frame.evaluate(() => globalThis.ferrule.replay.recorded.maps[0].points.find((p) => p.run !== undefined).trial);
  await frame.locator('#speed').selectOption('10');
  await frame.evaluate((k) => document.querySelector(`#map circle[data-trial="${k}"]`).scrollIntoView(), trial);
  await frame.locator(`#map circle[data-trial="${trial}"]`).dispatchEvent('click');
  const outcome = await frame.evaluate((k) => globalThis.ferrule.replay.recorded.maps[0].points[k].outcome, trial);
  await frame.waitForSelector('#outcome:not([hidden])');
  const said = await frame.locator('#outcome').innerText();
  assert.ok(said.startsWith(`ended: ${outcome.replaceAll('_', ' ')}. `), said);
  assert.equal(await frame.evaluate(() => globalThis.ferrule.replay.shown.outcome), outcome);
  assert.deepEqual(await violations(page), []);
  await page.setViewportSize({width: 1500, height: 1100});
  await pause(1500);
  await page.screenshot({path: join(pictures, 'report.png')});
  await page.close();
  assert.deepEqual(amiss, []);
});

check('a trial made again ends as the campaign had it, and both are seen', async () => {
  const server = await view('--trial', '3', '--scene', 'bench', '--seed', '7', '--against', 'constant-velocity');
  const {page, amiss} = await open(server.address);
  await page.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
  const table = join(folder, 'trials.csv');
  ferrule('evaluate', '--baseline', 'constant-velocity', '--scene', 'bench', '--seed', '7', '--trials', '4', '--trials-out', table);
  const lines = readFileSync(table, 'utf8').split('\n').filter((line) => line && !line.startsWith('#'));
  const column = lines[0].split(',').indexOf('outcome');
  assert.equal(await page.evaluate(() => globalThis.ferrule.replay.shown.outcome), lines[4].split(',')[column]);
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
});

check('an exported file replays from disk, and a name in it stays text', async () => {
  const name = '<img src=x onerror=alert(1)>.h5', file = join(folder, 'exported.html');
  const {copyFileSync} = await import('node:fs');
  copyFileSync(join(episodes, readdirSync(episodes).filter((f) => f.endsWith('.h5'))[0]), join(folder, name));
  ferrule('view', join(folder, name), '--export', file);
  assert.ok(statSync(file).size < 6_000_000);
  const {page, amiss} = await open('file://' + file);
  await page.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
  assert.equal(await page.locator('img').count(), 0);
  assert.ok((await page.locator('#run').innerText()).includes(name));
  await page.locator('#scrub').fill('9');
  await pause(200);
  for (const canvas of ['#solid', '#side', '#axis']) assert.ok(await coloursOf(page, canvas) > 20, `${canvas} is uniform`);
  await page.close();
  assert.deepEqual(amiss, []);
});

check('pictures at both sizes in both themes', async () => {
  const file = join(folder, 'pictures.html');
  ferrule('view', episodes, '--export', file);
  for (const theme of /** @type {const} */ (['light', 'dark']))
    for (const [width, height] of [[1280, 720], [3840, 2160]]) {
      const {page, amiss} = await open('file://' + file, {width, height, theme});
      await page.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
      await page.locator('#scrub').fill('12.4');
      await page.locator('#scrub').blur();
      await pause(600);
      const cut = await page.evaluate(() => [...document.querySelectorAll('header *, footer *, #numbers *, .gauge-row *')]
          .filter((e) => e instanceof HTMLElement && e.checkVisibility() && (e.getBoundingClientRect().right > innerWidth + 1 || e.getBoundingClientRect().bottom > innerHeight + 1)).map((e) => e.outerHTML.slice(0, 80)));
      assert.deepEqual(cut, [], 'nothing is cut off');
      assert.deepEqual(await violations(page), []);
      await page.screenshot({path: join(pictures, `replay-${width}-${theme}.png`)});
      await page.close();
      assert.deepEqual(amiss, []);
    }
});

// The page that has the simulator in it, from disk: node playground.mjs PROGRAM BUILD_FOLDER. In Chromium, and with
// FERRULE_LONG=1 in Firefox, where that is installed.
import assert from 'node:assert/strict';
import {readFileSync, statSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, test} from 'node:test';
import {pathToFileURL} from 'node:url';
import {browser, build, closeAll, ferrule, firefox, folder, open, violations} from './browser.mjs';

/** @typedef {import('playwright-core').Page} Page */

const file = join(build, 'ferrule-playground.html');

after(() => browser.close());

test('it is one file of at most 3 MB', () => assert.ok(statSync(file).size <= 3e6));

/** A row of the picture. @param {Page} page @param {string[]} names */
const row = (page, ...names) => page.evaluate((wanted) => {
  const read = globalThis.ferrule.live.newest.read(0);
  return Object.fromEntries(wanted.map((name) => [name, read(name)]));
}, names);

/** Goes in whatever it touches, as long as it is not pushed too hard. @param {Page} page */
async function insert(page) {
  /** @type {Set<string>} */
  let held = new Set();
  const hold = async (/** @type {string[]} */ keys) => {
    for (const key of held) if (!keys.includes(key)) await page.keyboard.up(key);
    for (const key of keys) if (!held.has(key)) await page.keyboard.down(key);
    held = new Set(keys);
  };
  for (const begin = Date.now(); Date.now() - begin < 60_000 && await page.evaluate(() => globalThis.ferrule.session.running);) {
    const r = await row(page, 'tip_y_um', 'tip_z_um', 'velocity_y_um_s', 'velocity_z_um_s', 'force_uN', 'limit_uN');
    const y = r.tip_y_um + 0.15 * r.velocity_y_um_s, z = r.tip_z_um + 0.15 * r.velocity_z_um_s;
    const keys = [];
    if (r.force_uN < 0.5 * r.limit_uN) keys.push('w');
    if (Math.abs(y) > 1.5) keys.push(y > 0 ? 'ArrowDown' : 'ArrowUp');
    if (Math.abs(z) > 1.5) keys.push(z > 0 ? 'ArrowRight' : 'ArrowLeft');
    await hold(keys);
    await page.waitForTimeout(15);
  }
  await hold([]);
}

/** The scene is there, and nothing runs. @param {Page} page @param {string} scene */
async function choose(page, scene) {
  await page.selectOption('#scene-choice', scene);
  await page.waitForFunction((name) => globalThis.ferrule.scene?.name === name, scene);
}

/** The last try, as the page saves it. @param {Page} page */
async function saved(page) {
  const text = page.evaluate(() => new Promise((done) => {
    const take = URL.createObjectURL;
    URL.createObjectURL = (/** @type {Blob} */ blob) => {
      URL.createObjectURL = take;
      done(blob.text());
      return take(blob);
    };
  }));
  await page.click('#save:enabled');
  return text;
}

/** What is saved becomes an episode with every bit; its outcome. @param {string} name @param {string} text */
function imported(name, text) {
  const log = join(folder, `${name}.json`), out = join(folder, name);
  writeFileSync(log, text);
  const [made] = JSON.parse(ferrule('import', log, '--out', out, '--json')).imported;
  const said = JSON.parse(ferrule('replay', made.file, '--verify', '--json'));
  assert.equal(said.identical, true);
  assert.equal(said.rows, made.rows);
  const counts = JSON.parse(text).counts.map((/** @type {number[]} */ run) => run[0]);
  assert.equal(said.rows, counts.reduce((/** @type {number} */ a, /** @type {number} */ b) => a + b));
  return made.outcome;
}

/** One try each, however it ends where this is slow; one is inserted. @param {string} name @param {Page} page @param {string[]} scenes */
async function tryAll(name, page, scenes) {
  const outcomes = [];
  for (const scene of scenes) {
    await choose(page, scene);
    await page.click('#start');
    await page.waitForFunction(() => globalThis.ferrule.session.running);
    await insert(page);
    await page.waitForSelector('#ended:not([hidden])');
    const ended = await page.locator('#ended').innerText();
    assert.match(ended, /score [0-9.]+ of 100/);
    outcomes.push(imported(`${name}-${scene}`, String(await saved(page))));
    assert.ok(ended.startsWith(outcomes[outcomes.length - 1].replaceAll('_', ' ')), ended);
  }
  assert.ok(outcomes.includes('inserted'), outcomes.join(', '));
}

test('a person inserts in it, and each try that is saved becomes an episode with every bit', {timeout: 400_000}, async () => {
  const {page, amiss} = await open(String(pathToFileURL(file)));
  await page.waitForFunction(() => globalThis.ferrule?.live?.newest?.rows > 0);
  await tryAll('chromium', page, ['easy', 'laser', 'film']);
  assert.deepEqual(amiss, []);
  assert.deepEqual(await violations(page), []);
  await closeAll();
});

test('shipped controllers that know the scaling of a scene insert in it, in time', {timeout: 240_000}, async () => {
  const {page, amiss} = await open(String(pathToFileURL(file)));
  await page.waitForFunction(() => globalThis.ferrule?.live?.newest?.rows > 0);
  const controllers = () => page.locator('#controller-choice option').evaluateAll((all) => all.map((one) => one.getAttribute('value')));
  assert.deepEqual(await controllers(), ['tuned_by_hand']);
  await choose(page, 'bench');
  assert.deepEqual(await controllers(), ['search', 'tuned_by_hand']);
  for (const controller of ['search', 'tuned_by_hand']) {
    await page.click('#tab-session');
    await page.selectOption('#controller-choice', controller);
    await page.click('#insert:enabled');
    await page.waitForFunction(() => globalThis.ferrule.session.running);
    const first = await row(page, 't_s'), begin = Date.now();
    await page.waitForTimeout(4000);
    const rate = (await row(page, 't_s')).t_s - first.t_s;
    console.log(`# ${controller}: ${(rate / (Date.now() - begin) * 1e6).toFixed(0)} steps a second, ${await page.evaluate(() => globalThis.ferrule.frames.rate.toFixed(0))} pictures a second`);
    await page.waitForFunction(() => !globalThis.ferrule.session.running, null, {timeout: 60_000});
    assert.match(await page.locator('#ended').innerText(), /^the controller: inserted/);
  }
  await page.screenshot({path: join(build, 'page-pictures/playground.png')});
  // As fast as it goes: a tenth of a second at once.
  await page.click('#insert:enabled');
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  const steps = await page.workers()[0].evaluate(() => {
    const begin = performance.now();
    for (let n = 0; n < 50; ++n) globalThis.simulator.ccall('advance', null, ['number'], [0.1]);
    return 5000 / (performance.now() - begin) * 1e3;
  });
  console.log(`# as fast as it goes: ${steps.toFixed(0)} steps a second`);
  await page.click('#discard');
  assert.deepEqual(amiss, []);
  await closeAll();
});

test('its text says where nothing else may come from', () => {
  const policy = /Content-Security-Policy" content="([^"]*)"/.exec(readFileSync(file, 'utf8'))?.[1] ?? '';
  assert.match(policy, /default-src 'none'/);
  assert.match(policy, /connect-src data:;/);
});

const other = process.env.FERRULE_LONG ? await firefox() : null;
test('the same in Firefox', {timeout: 240_000, skip: other ? false : 'not --long, or firefox-esr is not installed'}, async () => {
  const page = await other.newPage({viewport: {width: 1280, height: 720}});
  await page.goto(String(pathToFileURL(file)));
  await page.waitForFunction(() => globalThis.ferrule?.live?.newest?.rows > 0);
  await tryAll('firefox', page, ['easy', 'bench']);
  await other.close();
});

// The operator's window in a real browser: node page.mjs PROGRAM BUILD_FOLDER [PATTERN]
import assert from 'node:assert/strict';
import {copyFileSync, mkdirSync, readdirSync, statSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, test} from 'node:test';
import {gzipSync} from 'node:zlib';
import {readFileSync} from 'node:fs';
import {browser, build, closeAll, coloursOf, ferrule, folder, open, view, violations} from './browser.mjs';

/** @typedef {import('playwright-core').Page} Page */

const pattern = new RegExp(process.argv[4] ?? '');
const long = Boolean(process.env.FERRULE_LONG ?? process.argv[4]);  // a check that is asked for by name runs, too
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

/** Until what the page has is on the screen. @param {Page} page */
const painted = (page) => page.evaluate(() => new Promise((done) => { requestAnimationFrame(() => requestAnimationFrame(done)); }));

/** 3-D comes after the first picture. @param {import('playwright-core').Frame | Page} page */
const solid = (page) => page.waitForFunction(() => globalThis.ferrule.drawn.solid > 0);

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
  await solid(page);
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
  await painted(page);
  assert.ok(!before.equals(await page.locator('#side').screenshot()), 'the fibre on the screen moved');
  await page.reload();
  held.clear();
  await ready(page);
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  await page.waitForFunction(() => globalThis.ferrule.live.batches > 5);
  const {rows, first, last} = await page.evaluate(() => {
    const {history} = globalThis.ferrule.live, [first, last] = history.span();
    return {rows: history.rows, first, last};
  });
  assert.equal(first, 0);
  assert.equal(rows, Math.round(1000 * last) + 1, 'the page has every row again');
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

check('live: a drag and the wheel move the fibre, and what is let go stands still', async () => {
  const server = await view('--scene', 'demo', '--seed', '7', '--out', join(folder, 'mouse'));
  const {page, amiss} = await open(server.address);
  await ready(page);
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  const moved = (/** @type {string} */ name, /** @type {number} */ from, /** @type {number} */ way) =>
      page.waitForFunction(([column, at, sign]) => sign * (globalThis.ferrule.live.newest.read(0)(column) - at) > 1, [name, from, way]);
  let at = await row(page, 'holder_x_um', 'holder_y_um', 'holder_z_um');
  const box = await page.locator('#axis').boundingBox(), x = box.x + box.width / 2, y = box.y + box.height / 2;
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - 60, y - 60, {steps: 3});
  await moved('holder_y_um', at.holder_y_um, 1);
  await moved('holder_z_um', at.holder_z_um, 1);
  await page.mouse.up();
  at = await row(page, 'holder_x_um');
  for (let i = 0; i < 8; ++i) {
    await page.mouse.wheel(0, -120);
    await pause(50);
  }
  await moved('holder_x_um', at.holder_x_um, -1);
  await pause(500);
  at = await row(page, 'holder_x_um', 'holder_y_um', 'holder_z_um');
  await pause(300);
  assert.deepEqual(await row(page, 'holder_x_um', 'holder_y_um', 'holder_z_um'), at);
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
});

const kStraight = ['--set', 'start.lateral_sd_um=0', '--set', 'start.lateral_mean_um=[0,0]', '--set', 'start.tilt_sd_mrad=0'];

check('live: a key that is held moves on while the page is busy, and a page that hangs lets go', async () => {
  const server = await view('--scene', 'demo', ...kStraight, '--set', 'start.distance_um=390', '--out', join(folder, 'busy'));
  const {page, amiss} = await open(server.address);
  await ready(page);
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  await page.keyboard.down('w');
  /** How long the hand stood still while the page did nothing for `ms` [s]. @param {number} ms */
  const still = async (ms) => {
    await pause(1500);  // at full speed
    const begin = await page.evaluate((busy) => {
      const t = globalThis.ferrule.live.newest.read(0)('t_s');
      for (const since = performance.now(); performance.now() - since < busy;);
      return t;
    }, ms);
    await page.waitForFunction((t) => globalThis.ferrule.live.history.span()[1] > t, begin + ms / 1e3 + 0.3);
    return page.evaluate(([from, to]) => {
      const {history} = globalThis.ferrule.live;
      let rows = 0;
      for (let row = history.rowAt(from); history.at(row, 't_s') < to; ++row) rows += Number(history.at(row, 'velocity_x_um_s') === 0);
      return rows / 1e3;
    }, [begin, begin + ms / 1e3]);
  };
  // The best of three: whoever else works on this machine may keep the page's worker from it.
  const busy = Math.min(await still(400), await still(400), await still(400)), hung = await still(2000);
  assert.ok(busy < 0.1 && hung > 1, `${busy} ${hung}`);
  await page.waitForFunction(() => globalThis.ferrule.live.newest.read(0)('velocity_x_um_s') < 0);  // it is held still
  // A page that is closed says nothing more.
  await page.close();
  const other = await open(server.address);
  await ready(other.page);
  await pause(500);
  assert.equal((await row(other.page, 'velocity_x_um_s')).velocity_x_um_s, 0);
  await other.page.close();
  await server.end();
  assert.deepEqual(amiss, []);
});

check('live: without the program the controls are off, and the page says what became of the try', async () => {
  const out = join(folder, 'gone');
  for (const [by, said] of /** @type {const} */ ([
    ['SIGINT', `The program has ended. Your last try is saved as ${out}/episode_0001.h5.`],
    ['SIGKILL', `The program does not answer. If it was killed, your try is not lost: ferrule recover ${out} brings it back. Your tries are saved in ${out}.`],
  ])) {
    const server = await view('--scene', 'demo', '--out', out);
    const {page} = await open(server.address);
    await ready(page);
    await page.waitForFunction((n) => globalThis.ferrule.session.episodes.length === n, by === 'SIGINT' ? 0 : 1);
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => globalThis.ferrule.session.running && globalThis.ferrule.live.batches > 5);
    await page.keyboard.down('w');
    await server.end(by);
    await page.waitForSelector('#gone:not([hidden])');
    assert.equal(await page.locator('#gone').innerText(), said);
    for (const control of ['start', 'discard', 'fit', 'insert', 'trainee', 'rating'])
      assert.ok(await page.locator(`#${control}`).evaluate((e) => /** @type {HTMLButtonElement} */ (e).disabled), control);
    assert.equal(await page.evaluate(() => globalThis.ferrule.hand.keys.size), 0);
    await page.keyboard.up('w');
    await page.keyboard.down('ArrowUp');
    await page.keyboard.press('Enter');
    assert.deepEqual(await page.evaluate(() => globalThis.ferrule.hand.velocity()), [0, 0, 0]);
    assert.deepEqual(await violations(page), []);
    await page.screenshot({path: join(pictures, `gone-${by}.png`)});
    await page.close();
  }
  ferrule('recover', out);
  assert.deepEqual(readdirSync(out).sort(), ['episode_0001.h5', 'episode_0002.h5']);
});

check('live: a cue says which way to correct, and nothing is shown as a negative clearance', async () => {
  const aside = ['--scene', 'easy', ...kStraight, '--set', 'start.lateral_mean_um=[-30,20]', '--set', 'start.distance_um=60'];
  const green = (/** @type {Page} */ page) => page.evaluate(() => {
    const canvas = document.querySelector('#axis'), context = canvas.getContext('2d');
    const {data} = context.getImageData(0, 0, canvas.width, canvas.height);
    let pixels = 0;
    for (let i = 0; i < data.length; i += 4) pixels += Number(data[i] === 0 && data[i + 1] === 0x78 && data[i + 2] === 0x5a);
    return pixels;
  });
  const server = await view(...aside, '--out', join(folder, 'cued'));
  const {page, amiss} = await open(server.address);
  await ready(page);
  await page.waitForFunction(() => /\d/.test(document.querySelector('#way-text').textContent));
  // Up and to the right, as it is seen along the axis: from y -30, z 20 um, less what the fibre hangs.
  assert.match(await page.locator('#way-text').innerText(), /^\u2197 3[56]\.\d\d \u00b5m$/);
  assert.ok(await green(page) > 200);
  assert.equal(await page.locator('#numbers').innerText().then((text) => text.includes('beside the bore by')), true);
  await page.screenshot({path: join(pictures, 'cue.png')});
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  // Whatever a picture says of it.
  await page.evaluate(() => {
    globalThis.labels = new Set();
    const look = () => {
      globalThis.labels.add(document.querySelectorAll('#numbers .number')[1].textContent);
      requestAnimationFrame(look);
    };
    look();
  });
  const away = async () => {
    const {way_y_um: y, way_z_um: z} = await row(page, 'way_y_um', 'way_z_um');
    return [y, z];
  };
  // Who goes where it says comes to the axis.
  while (/\d/.test(await page.locator('#way-text').innerText())) {
    const [y, z] = await away(), which = Math.abs(y) > Math.abs(z) ? 0 : 1, off = which ? z : y;
    const key = which ? (z > 0 ? 'ArrowLeft' : 'ArrowRight') : (y > 0 ? 'ArrowUp' : 'ArrowDown');
    await page.keyboard.down(key);
    if (Math.abs(off) < 4) await pause(60);  // a tap
    else while (Math.sign(off) * (await away())[which] > 3);
    await page.keyboard.up(key);
    await pause(150);
  }
  await page.keyboard.down('w');
  await page.waitForFunction(() => globalThis.ferrule.live.newest.read(0)('depth_um') > 3);
  await page.keyboard.down('ArrowUp');  // against the wall
  await page.waitForFunction(() => !globalThis.ferrule.session.running);
  await page.keyboard.up('ArrowUp');
  await page.keyboard.up('w');
  const shown = (await page.evaluate(() => [...globalThis.labels])).join(' ');
  for (const label of ['beside the bore by', 'clearance', 'contact, pressed in by']) assert.ok(shown.includes(label), shown);
  assert.ok(!/[\u2212-]\d/.test(shown), shown);
  await page.close();
  await server.end();
  const other = await view(...aside, '--set', 'cue=false', '--out', join(folder, 'uncued'));
  const plain = await open(other.address);
  await ready(plain.page);
  assert.equal(await plain.page.locator('#way').isVisible(), false);
  assert.ok(await green(plain.page) < 20);
  await plain.page.close();
  await other.end();
  assert.deepEqual([...amiss, ...plain.amiss], []);
});

check('live: another trainee between tries, and all of them side by side', async () => {
  const out = join(folder, 'persons');
  const short = ['--scene', 'demo', ...kStraight, '--set', 'start.lateral_sd_um=0.2', '--set', 'start.distance_um=15', '--set', 'success.depth_um=12', '--out', out];
  ferrule('record', '--device', 'fake:spacemouse', '--trainee', 'Ben', '--episodes', '3', ...short);
  const server = await view('--trainee', 'Ada', ...short);
  const {page, amiss} = await open(server.address);
  await ready(page);
  const go = async (/** @type {number} */ files) => {
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => globalThis.ferrule.session.running);
    await page.keyboard.down('w');
    await page.waitForFunction((n) => globalThis.ferrule.session.episodes.length === n, files);
    await page.keyboard.up('w');
    await page.waitForFunction(() => !globalThis.ferrule.session.running && !globalThis.ferrule.session.rests);
  };
  await page.waitForFunction(() => globalThis.ferrule.session.episodes.length === 3);
  await go(4);
  await page.locator('#trainee').fill('Cid');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelector('#who').textContent === 'Cid');
  assert.deepEqual(await page.locator('#trainees option').evaluateAll((all) => all.map((o) => /** @type {HTMLOptionElement} */ (o).value)), ['Ben', 'Ada']);
  await go(5);
  await page.locator('#tab-persons').click();
  const table = await page.locator('#standings tr').evaluateAll((all) => all.map((line) => [...line.children].map((cell) => cell.textContent)));
  // As score has it.
  const {episodes: scored} = JSON.parse(ferrule('score', out, '--json'));
  const middle = (/** @type {number[]} */ numbers) => numbers.sort((a, b) => a - b)[numbers.length >> 1];
  assert.deepEqual(table.map(([name]) => name), ['Ben', 'Ada', 'Cid']);
  for (const [name, inserted, time, force, score, trend] of table) {
    const own = scored.filter((/** @type {any} */ e) => e.operator === name);
    assert.equal(own.length, name === 'Ben' ? 3 : 1);
    assert.equal(inserted, `${own.length}/${own.length}`);
    assert.equal(time, middle(own.map((/** @type {any} */ e) => e.time_s)).toFixed(1));
    assert.equal(force, middle(own.map((/** @type {any} */ e) => e.peak_force_uN)).toFixed(1));
    assert.equal(score, middle(own.map((/** @type {any} */ e) => e.score)).toFixed(1));
    const rise = own.length < 3 ? '\u2013' : (own[2].score - own[0].score) / 2;
    assert.ok(rise === trend || Math.abs(Number(rise) - Number(trend.replace('\u2212', '-'))) <= 0.051, `${rise} ${trend}`);
  }
  assert.ok(await page.locator('#curves svg').isVisible());
  assert.deepEqual(await violations(page), []);
  await page.screenshot({path: join(pictures, 'persons.png')});
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
});

check('live: each try has its own curves', async () => {
  const server = await view('--scene', 'demo', ...kStraight, '--set', 'start.distance_um=15', '--set', 'success.depth_um=12', '--out', join(folder, 'tries'));
  const {page, amiss} = await open(server.address);
  await ready(page);
  const drawn = () => page.locator('#strip-velocity').screenshot();
  for (let number = 1; number <= 4; ++number) {
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => globalThis.ferrule.session.running);
    // A longer one first: none of its rows stay in the next ones.
    await pause(number === 1 ? 1500 : 150 * (number % 3));
    await page.keyboard.down('w');
    await page.waitForFunction((n) => globalThis.ferrule.session.episodes.length === n, number);
    await page.keyboard.up('w');
    await page.waitForFunction(() => !globalThis.ferrule.session.running && !globalThis.ferrule.session.rests);
    const file = await page.evaluate(() => globalThis.ferrule.session.saved);
    const {rows} = JSON.parse(ferrule('replay', join(folder, 'tries', file), '--verify', '--json'));
    await page.waitForFunction((n) => globalThis.ferrule.live.history.rows >= n && globalThis.ferrule.batch === globalThis.ferrule.live.batches, rows);
    await painted(page);
    const kept = await page.evaluate(() => {
      const {history} = globalThis.ferrule.live, times = history.column('t_s', 0, 1);
      return {rows: history.rows, first: times[0], rises: times.every((t, i) => i === 0 || t > times[i - 1])};
    });
    assert.deepEqual(kept, {rows, first: 0, rises: true}, `try ${number}`);
    const still = await drawn();
    await pause(300);
    assert.ok(still.equals(await drawn()), 'they stay until the next one');
  }
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
});

const kGamepad = `
  const pad = {connected: true, id: 'test', index: 0, mapping: 'standard', timestamp: 0, axes: [0, 0, 0, 0],
    buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0}))};
  globalThis.testPad = pad;
  navigator.getGamepads = () => [pad];`;

check('live: a fit from many tries is asked for in a small message, or the page says that it cannot be', async () => {
  const server = await view('--scene', 'demo', '--out', join(folder, 'many'));
  const {page, amiss} = await open(server.address);
  await ready(page);
  await page.evaluate(() => {
    const {live} = globalThis.ferrule, post = live.link.postMessage.bind(live.link);
    globalThis.sent = [];
    live.link.postMessage = (/** @type {any} */ data) => {
      if (data.text) globalThis.sent.push(data.text);
      post(data);
    };
  });
  /** What is sent where so many tries are listed, some of them left out. @param {number} count @param {(i: number) => boolean} leaves */
  const asked = (count, leaves) => page.evaluate((list) => {
    const {session} = globalThis.ferrule;
    globalThis.sent.length = 0;
    document.querySelector('#said').textContent = '';
    session.left = new Set(list.filter((e) => e.out).map((e) => e.file));
    session.show(list);
    document.querySelector('#tab-session').click();
    document.querySelector('#fit').click();
    return globalThis.sent.map((text) => ({...JSON.parse(text), bytes: text.length}));
  }, Array.from({length: count}, (_, i) => ({file: `episode_${String(i + 1).padStart(4, '0')}.h5`, outcome: 'inserted', same_scene: i !== 1, score: 50, out: leaves(i)})));
  const online = () => page.evaluate(() => globalThis.ferrule.session.online);
  assert.deepEqual(await asked(240, () => false), [{type: 'fit', bytes: 14}]);
  // What the program answers: the page's list is not its own.
  await page.waitForFunction(() => document.querySelector('#said').textContent.includes('no episodes of this scene'));
  assert.deepEqual((await asked(240, (i) => i === 3 || i === 5))[0].but, ['episode_0004.h5', 'episode_0006.h5']);
  assert.deepEqual((await asked(240, (i) => i > 2))[0].episodes, ['episode_0001.h5', 'episode_0003.h5']);
  await page.waitForFunction(() => document.querySelector('#said').textContent.includes('not on the list'));
  assert.equal((await asked(300, (i) => i % 2 === 0))[0].episodes.length, 149);
  assert.deepEqual(await asked(1000, (i) => i % 2 === 1), []);
  assert.match(await page.locator('#said').innerText(), /^too much at once for the program/);
  await pause(500);
  assert.equal(await online(), true);
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
});

// A keyboard that says that it is a gamepad, one with triggers that rest at -1, one that nobody touches, and the person's.
const kGamepads = `
  const made = (index, id, mapping, axes) => ({connected: true, id, index, mapping, timestamp: 0, axes,
    buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0}))});
  const pads = [made(0, 'keyboard', '', [-1, -1, 0, -1]), made(1, 'old pad', '', [0, 0, -1, 0, 0, -1, 0, 0]),
    made(2, 'on the table', 'standard', [0.9, -1, 0, 1]), null, made(4, 'in the hand', 'standard', [0, 0, 0, 0])];
  pads[2].buttons[7] = {pressed: true, touched: true, value: 1};
  pads[2].buttons[9] = {pressed: true, touched: true, value: 1};
  globalThis.testPads = pads;
  navigator.getGamepads = () => pads.filter((pad) => pad === null || pad.connected);`;

check('live: the gamepad that was moved first drives, if its layout is known', async () => {
  const server = await view('--scene', 'demo', ...kStraight, '--out', join(folder, 'gamepads'));
  const {page, amiss} = await open(server.address, {script: kGamepads});
  await ready(page);
  const set = (/** @type {(pads: any[]) => void} */ change) => page.evaluate(`(${change})(globalThis.testPads)`);
  const velocity = async () => {
    await pause(100);
    return page.evaluate(() => globalThis.ferrule.hand.velocity());
  };
  const running = () => page.evaluate(() => globalThis.ferrule.session.running);
  assert.deepEqual(await velocity(), [0, 0, 0]);
  assert.equal(await page.locator('#said').innerText(), '');
  // Start of a layout that is not known: elsewhere the right trigger, which pushes in.
  await set((pads) => { pads[1].buttons[7] = {pressed: true, touched: true, value: 1}; pads[1].axes[0] = -1; });
  assert.deepEqual(await velocity(), [0, 0, 0]);
  assert.match(await page.locator('#said').innerText(), /^The gamepad "old pad" is not used/);
  await set((pads) => { pads[1].buttons[7] = {pressed: false, touched: false, value: 0}; });
  // The person's comes after all of them.
  await set((pads) => { pads[4].axes[0] = -1; });
  assert.deepEqual(await velocity(), [0, 0, 1]);
  await set((pads) => { pads[4].axes[0] = 0; pads[4].buttons[7] = {pressed: true, touched: true, value: 1}; });
  assert.deepEqual(await velocity(), [-1, 0, 0]);
  await set((pads) => { pads[4].buttons[7] = {pressed: false, touched: false, value: 0}; });
  assert.deepEqual(await velocity(), [0, 0, 0]);
  // Another one has to wait until it is gone; and what it held all the time does not count.
  await set((pads) => { pads[2].axes[0] = -0.9; });
  assert.deepEqual(await velocity(), [0, 0, 0]);
  await set((pads) => { pads[4].connected = false; });
  assert.deepEqual(await velocity(), [0, 0, 0]);
  assert.equal(await running(), false);
  await set((pads) => { pads[2].buttons[9] = {pressed: false, touched: false, value: 0}; pads[2].axes[0] = 0; });
  assert.deepEqual(await velocity(), [0, 0, 0]);
  await set((pads) => { pads[2].buttons[9] = {pressed: true, touched: true, value: 1}; pads[2].axes[0] = -1; });
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  assert.deepEqual(await velocity(), [0, 0, 1]);
  await page.close();
  await server.end();
  assert.deepEqual(amiss, []);
});

// Sticks on odd axes, up is positive, one does not rest at 0; triggers rest at -1, which the browser does not know before
// something is moved; a hat; and a keyboard that says that it is a gamepad.
const kOldPad = `
  const made = (index, id, axes) => ({connected: true, id, index, mapping: '', timestamp: 0, axes,
    buttons: Array.from({length: 12}, () => ({pressed: false, touched: false, value: 0}))});
  const pads = [made(0, 'keyboard', []), made(1, 'old; pad=(1)', [0, 0, 0, 0.03, 0.02, 0, 1.2857])];
  globalThis.testPads = pads;
  navigator.getGamepads = () => pads;`;

check('live: a gamepad of unknown layout is asked for its sticks and buttons, and drives then and later', async () => {
  const servers = [await view('--scene', 'demo', ...kStraight, '--out', join(folder, 'assigned')), await view('--scene', 'demo', '--out', join(folder, 'later'))];
  const {page, amiss} = await open(servers[0].address, {script: kOldPad});
  await ready(page);
  /** @param {string} input @param {number} x @param {number} [pad] */
  const set = (input, x, pad = 1) => page.evaluate(([name, value, index]) => {
    const {axes, buttons} = globalThis.testPads[index], i = Number(name.slice(1));
    if (index === 1 && axes[2] === 0) axes[2] = axes[5] = -1;
    if (name[0] === 'a') axes[i] = value;
    else buttons[i] = {pressed: value > 0.1, touched: value > 0.1, value};
    return new Promise((done) => { setTimeout(done, 40); });  // the page has looked
  }, /** @type {const} */ ([input, x, pad]));
  const velocity = async () => {
    await pause(100);
    return page.evaluate(() => globalThis.ferrule.hand.velocity().map((x) => Math.round(100 * x) / 100 + 0));
  };
  const step = (/** @type {number} */ n) => page.waitForFunction((text) => document.querySelector('#assign-step').textContent.startsWith(text), `${n} of 5`);
  const said = (/** @type {RegExp} */ text, where = '#said') => page.waitForFunction(([selector, wanted]) => new RegExp(wanted).test(document.querySelector(selector).textContent), [where, text.source]);
  /** Moves it a little, all the way, and lets go. @param {string} input @param {number} x @param {number} rest @param {number} [pad] */
  const move = async (input, x, rest, pad = 1) => {
    for (const part of [0.3, 1, 0.4, 0]) {
      await set(input, rest + part * (x - rest), pad);
      if (part === 1) await pause(400);  // held for a while
    }
  };
  assert.equal(await page.locator('#assign-open').isVisible(), false);
  await move('a3', 1, 0.03);
  await said(/^The gamepad "old; pad=\(1\)" is not used/);
  assert.deepEqual(await velocity(), [0, 0, 0]);
  // By keys alone; Escape leaves it as it was.
  await page.locator('#assign-open').focus();
  await page.keyboard.press('Enter');
  await step(1);
  assert.deepEqual(await violations(page), []);
  await page.screenshot({path: join(pictures, 'assign.png')});
  await page.keyboard.press('Escape');
  await move('a3', 1, 0.03);
  assert.deepEqual(await velocity(), [0, 0, 0]);
  await page.keyboard.press('Enter');
  await step(1);
  await move('b4', 1, 0, 0);
  await said(/^That was a button/, '#assign-note');
  await move('a3', 1, 0.03);
  await step(2);
  await move('a3', -1, 0.03);
  await said(/^That does something else/, '#assign-note');
  await move('a6', -1, 1.2857);
  await move('a4', 0.9, 0.02);
  await step(3);
  await move('b4', 1, 0, 0);
  await move('a5', 1, -1);
  await step(4);
  await move('a2', 1, -1);
  await step(5);
  await move('b3', 1, 0);
  await said(/^The gamepad .* drives/);
  assert.equal(await page.locator('#assign').isVisible(), false);
  /** Every stick and trigger does what it was assigned to. */
  const drives = async () => {
    assert.deepEqual(await velocity(), [0, 0, 0]);
    for (const [input, x, rest, expected] of /** @type {const} */ ([
      ['a3', 1, 0.03, [0, 0, -1]], ['a3', -1, 0.03, [0, 0, 1]], ['a4', 0.9, 0.02, [0, 1, 0]], ['a4', -0.9, 0.02, [0, -1, 0]],
      ['a5', 1, -1, [-1, 0, 0]], ['a2', 1, -1, [1, 0, 0]], ['a5', -0.9, -1, [0, 0, 0]]])) {
      await set(input, x);
      assert.deepEqual(await velocity(), expected, input);
      await set(input, rest);
    }
    assert.deepEqual(await velocity(), [0, 0, 0]);
    await set('b3', 1);
    await page.waitForFunction(() => globalThis.ferrule.session.running);
    await set('b3', 0);
  };
  await drives();
  // In the next window, which has another port, too, where a trigger that nobody touched reads half of its way.
  await page.goto(servers[1].address);
  await ready(page);
  await page.evaluate(() => { globalThis.testPads[1].axes[2] = -1; });
  await move('a3', 1, 0.03);
  assert.deepEqual(await velocity(), [0, 0, 0]);
  await set('a5', -1);
  await drives();
  assert.ok(await page.locator('#assign-open').isVisible());
  await page.close();
  for (const server of servers) await server.end();
  assert.deepEqual(amiss, []);
});

check('live: inserts by a gamepad alone', async () => {
  const out = join(folder, 'gamepad');
  const server = await view('--scene', 'demo', '--seed', '6', '--out', out);
  const {page, amiss} = await open(server.address, {script: kGamepad});
  await ready(page);
  const press = () => page.evaluate(async () => {
    globalThis.testPad.buttons[0] = {pressed: true, touched: true, value: 1};
    await new Promise((done) => setTimeout(done, 300));
    globalThis.testPad.buttons[0] = {pressed: false, touched: false, value: 0};
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
  await painted(page);
  const early = await page.locator('#side').screenshot();
  await page.locator('#scrub').fill('12');
  await painted(page);
  assert.ok(!early.equals(await page.locator('#side').screenshot()));
  // The numbers beside it are those of the row.
  const depth = (await row(page, 'depth_um')).depth_um;
  assert.equal(await page.locator('#value-depth').innerText(), depth.toFixed(2));
  await page.locator('#tab-events').click();
  const texts = await page.locator('#events button').allInnerTexts();
  assert.ok(texts.some((text) => text.includes('touches the cone')), texts.join());
  await page.locator('#scrub').fill('0');
  await page.locator('#event-after').click();
  await painted(page);
  assert.equal((await page.locator('#clock').innerText()).split(' /')[0], texts[0].split(' s')[0]);
  const one = await page.locator('#axis').screenshot();
  await page.locator('#over').selectOption({index: 2});
  await page.waitForFunction(() => globalThis.ferrule.replay.over?.loaded);
  await painted(page);
  assert.ok(!one.equals(await page.locator('#axis').screenshot()), 'the other is seen');
  // A force's arrow goes and comes; a view alone; a part of time enlarged, and all of it again.
  const arrows = await page.locator('#axis').screenshot();
  await page.locator('#tab-terms').click();
  for (const box of await page.locator('#terms input').all()) await box.uncheck();
  await painted(page);
  assert.ok(!arrows.equals(await page.locator('#axis').screenshot()), 'arrows went');
  await page.locator('[data-view=strips]').click();
  await painted(page);
  assert.equal(await page.locator('#axis').isVisible(), false);
  const box = await page.locator('#strip-force').boundingBox(), middle = box.y + box.height / 2;
  await page.mouse.move(box.x + 0.4 * box.width, middle);
  assert.match(await page.locator('#strip-force .under').innerText(), / s: .* \u00b5N/);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.6 * box.width, middle, {steps: 4});
  await page.mouse.up();
  const shown = () => page.evaluate(() => globalThis.ferrule.strips.plots.map((p) => p.scales.x.max - p.scales.x.min));
  const whole = await page.evaluate(() => globalThis.ferrule.replay.shown.table.span()[1]);
  assert.ok((await shown()).every((span) => span < 0.5 * whole), String(await shown()));
  await page.keyboard.press('Escape');
  assert.ok(await page.locator('#axis').isVisible());
  // The address opens the same picture.
  await page.locator('#scrub').fill('7.25');
  await page.waitForFunction(() => location.hash.includes('t=7.25'));
  const again = await open(page.url());
  await again.page.waitForFunction(() => globalThis.ferrule?.replay?.over?.loaded && globalThis.ferrule.replay.t > 7);
  assert.equal((await again.page.locator('#clock').innerText()).split(' /')[0], '7.250');
  await again.page.close();
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
  const failed = await frame.evaluate(() => globalThis.ferrule.replay.recorded.maps[0].points.filter((p) => p.outcome !== 'inserted'));
  assert.ok(failed.length > 20 && failed.every((p) => p.run !== undefined), 'every failure is there');
  const {trial} = failed[failed.length - 1];
  await frame.locator('#speed').selectOption('10');
  await page.setViewportSize({width: 1500, height: 1100});
  // In its middle, where the reach of another may be on top.
  const mark = frame.locator(`#map path[data-trial="${trial}"]`);
  await mark.scrollIntoViewIfNeeded();
  const middle = await mark.boundingBox();
  await page.mouse.click(middle.x + middle.width / 2, middle.y + middle.height / 2);
  await frame.waitForFunction((k) => globalThis.ferrule.replay.shown.name.endsWith(`trial ${k}`), trial);
  const outcome = await frame.evaluate((k) => globalThis.ferrule.replay.recorded.maps[0].points[k].outcome, trial);
  await frame.waitForSelector('#outcome:not([hidden])');
  const said = await frame.locator('#outcome').innerText();
  assert.ok(said.startsWith(`ended: ${outcome.replaceAll('_', ' ')}. `), said);
  assert.equal(await frame.evaluate(() => globalThis.ferrule.replay.shown.outcome), outcome);
  assert.deepEqual(await violations(page), []);
  await solid(frame);
  await page.screenshot({path: join(pictures, 'report.png')});
  await page.close();
  assert.deepEqual(amiss, []);
});

if (long) check('reports fit a narrow screen', async () => {
  const demo = join(folder, 'demo'), trials = join(folder, 'narrow.html');
  ferrule('demo', '--out', demo);
  ferrule('evaluate', join(demo, 'controller.json'), '--trials', '20', '--report', trials);
  for (const file of [join(demo, 'report.html'), trials])
    for (const width of [390, 1280]) {
      const {page, amiss} = await open('file://' + file, {width, height: 800});
      const frame = await (await page.waitForSelector('iframe.replay')).contentFrame();
      await frame.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
      for (const each of [page, frame]) {
        const wide = await each.evaluate(() => [...document.querySelectorAll('body *')].filter((e) => e.checkVisibility() &&
            (e.getBoundingClientRect().right > innerWidth + 1 || (e.tagName === 'PRE' && e.scrollWidth > e.clientWidth))).map((e) => e.outerHTML.slice(0, 80)));
        assert.deepEqual(wide, []);
        assert.ok(await each.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
      }
      // Words in tables are whole where there is room.
      const name = page.locator('td:first-child', {hasText: 'electrostatic'}).first();
      assert.ok((await name.boundingBox()).height < 40);
      await page.screenshot({path: join(pictures, `${file === trials ? 'trials' : 'demo'}-${width}.png`), fullPage: true});
      await page.close();
      assert.deepEqual(amiss, []);
    }
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
  copyFileSync(join(episodes, readdirSync(episodes).filter((f) => f.endsWith('.h5'))[0]), join(folder, name));
  ferrule('view', join(folder, name), '--export', file);
  assert.ok(statSync(file).size < 6_000_000);
  const {page, amiss} = await open('file://' + file);
  await page.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
  assert.equal(await page.locator('img').count(), 0);
  assert.ok((await page.locator('#run').innerText()).includes(name));
  await page.locator('#scrub').fill('9');
  await solid(page);
  await painted(page);
  for (const canvas of ['#solid', '#side', '#axis']) assert.ok(await coloursOf(page, canvas) > 20, `${canvas} is uniform`);
  await page.close();
  assert.deepEqual(amiss, []);
});

check('pages and reports have their own style, and none that a text could bring in', async () => {
  const sweep = join(folder, 'sweep.json'), report = join(folder, 'answers.html'), exported = join(folder, 'styled.html');
  writeFileSync(sweep, ferrule('sweep', 'constant-velocity', 'limits.force_uN=45,80', '--scene', 'bench', '--trials', '20', '--json'));
  ferrule('report', sweep, '--out', report);
  ferrule('view', join(episodes, 'episode_0001.h5'), '--export', exported);
  const server = await view('--scene', 'demo', '--out', join(folder, 'styled'));
  for (const address of [server.address, 'file://' + exported, 'file://' + report]) {
    const {page, amiss} = await open(address);
    assert.deepEqual(amiss, []);
    const colour = await page.evaluate(() => {
      document.body.insertAdjacentHTML('beforeend', '<style>#brought { color: red; }</style><p id="brought" style="color: red">text</p>');
      return getComputedStyle(document.querySelector('#brought')).color;
    });
    assert.notEqual(colour, 'rgb(255, 0, 0)');
    assert.equal(amiss.filter((text) => text.includes('violates the following Content Security Policy')).length, amiss.length);
    if (address.endsWith(report)) {
      assert.ok(await page.locator('.bar').evaluateAll((bars) => bars.length > 0 && bars.every((bar) => bar.getBoundingClientRect().width > 100 &&
          getComputedStyle(bar.querySelector('rect')).fill === 'rgb(86, 180, 233)')));
      assert.ok(await page.locator('img').evaluateAll((all) => all.every((image) => /** @type {HTMLImageElement} */ (image).naturalWidth > 0)));
    }
    await page.close();
  }
  await server.end();
});

check('a folder opens with what can be read, and says what cannot', async () => {
  const mixed = join(folder, 'mixed');
  mkdirSync(mixed);
  writeFileSync(join(mixed, 'a <b>broken.h5'), 'nothing');
  copyFileSync(join(episodes, 'episode_0001.h5'), join(mixed, 'b.h5'));
  const server = await view(mixed);
  const {page} = await open(server.address);
  await page.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
  const broken = await page.evaluate(() => globalThis.ferrule.replay.runs.findIndex((run) => run.name.startsWith('a ')));
  for (const choice of ['#run', '#over']) {
    await page.locator('#said').evaluate((said) => { said.textContent = ''; });
    await page.locator(choice).selectOption(String(broken));
    await page.waitForFunction(() => document.querySelector('#said').textContent.includes('<b>broken.h5 could not be read'));
    assert.match(await page.locator(`${choice} option:checked`).innerText(), choice === '#run' ? /^b.h5/ : /nothing/);
  }
  assert.equal(await page.locator('b').count(), 0);
  await page.close();
  await server.end();
});

if (long) check('pictures at both sizes in both themes', async () => {
  const file = join(folder, 'pictures.html');
  ferrule('view', episodes, '--export', file);
  for (const theme of /** @type {const} */ (['light', 'dark']))
    for (const [width, height] of [[1280, 720], [3840, 2160]]) {
      const {page, amiss} = await open('file://' + file, {width, height, theme});
      await page.waitForFunction(() => globalThis.ferrule?.replay?.shown?.loaded);
      await page.locator('#scrub').fill('12.4');
      await page.locator('#scrub').blur();
      await solid(page);
      await painted(page);
      const cut = await page.evaluate(() => [...document.querySelectorAll('header *, footer *, #numbers *, .gauge-row *')]
          .filter((e) => e instanceof HTMLElement && e.checkVisibility() && (e.getBoundingClientRect().right > innerWidth + 1 || e.getBoundingClientRect().bottom > innerHeight + 1)).map((e) => e.outerHTML.slice(0, 80)));
      assert.deepEqual(cut, [], 'nothing is cut off');
      assert.deepEqual(await violations(page), []);
      await page.screenshot({path: join(pictures, `replay-${width}-${theme}.png`)});
      await page.close();
      assert.deepEqual(amiss, []);
    }
  const server = await view('--scene', 'hard', '--trainee', 'Ada', '--out', join(folder, 'pictured'));
  for (const theme of /** @type {const} */ (['light', 'dark']))
    for (const [width, height] of [[1280, 720], [3840, 2160]]) {
      const {page, amiss} = await open(server.address, {width, height, theme});
      await page.waitForFunction(() => globalThis.ferrule?.drawn?.solid > 0);
      await page.keyboard.press('Enter');
      await page.waitForFunction(() => globalThis.ferrule.session.running);
      await page.keyboard.down('w');
      await page.waitForFunction(() => globalThis.ferrule.live.newest.read(0)('force_uN') > 10 || !globalThis.ferrule.session.running);
      await page.screenshot({path: join(pictures, `live-${width}-${theme}.png`)});
      await page.waitForSelector('#ended:not([hidden])');
      await page.keyboard.up('w');
      await page.screenshot({path: join(pictures, `ended-${width}-${theme}.png`)});
      assert.deepEqual(await violations(page), []);
      await page.close();
      assert.deepEqual(amiss, []);
    }
  await server.end();
});

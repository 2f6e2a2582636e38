// How fast the window is, measured in one run: node figures.mjs PROGRAM BUILD_FOLDER [ROUNDS]
// First frame, states a second, hand to picture, and the loop's period alone, with a page open and
// under a flood, in turns within one insertion.
import {connect} from 'node:net';
import {cpus, loadavg} from 'node:os';
import {join} from 'node:path';
import {browser, closeAll, folder, open, view} from './browser.mjs';

/** @typedef {import('playwright-core').Page} Page */

const rounds = Number(process.argv[4] ?? 3);
const kSpell = 8;  // seconds of each way in each round: the program keeps the last 10 s of rows

/** @param {number} s */
const pause = (s) => new Promise((done) => setTimeout(done, 1000 * s));

/** @param {number[]} values @param {number} share */
const quantile = (values, share) => values.sort((a, b) => a - b)[Math.floor(share * (values.length - 1))];

/** @param {number[]} values */
const median = (values) => quantile(values, 0.5);

// From the address on stdout to the first picture, of a browser that runs already.
async function firstFrames() {
  const seen = [], of3d = [], loaded = [];
  for (let i = 0; i < Math.max(3, rounds); ++i) {
    const server = await view('--out', join(folder, `first-${i}`));
    const begin = Date.now();
    const {page} = await open(server.address);
    await page.waitForFunction(() => globalThis.ferrule?.drawn.solid > 0);
    const {origin, drawn} = await page.evaluate(() => ({origin: performance.timeOrigin, drawn: globalThis.ferrule.drawn}));
    loaded.push(drawn.first);
    seen.push(origin + drawn.first - begin);
    of3d.push(origin + drawn.solid - begin);
    await page.close();
    await server.end();
  }
  const ms = (/** @type {number[]} */ values) => `${median(values).toFixed(0)} ms (${values.map((v) => v.toFixed(0)).join(', ')})`;
  console.log(`first frame after the address: ${ms(seen)}, of that in the page ${ms(loaded)}; with 3-D ${ms(of3d)}`);
}

/** A client that says nothing but what it should not, as fast as it is read; ends it. @param {string} address */
function flood(address) {
  const {host, hostname, port, pathname, origin} = new URL(address);
  let over = false;
  const frame = (/** @type {Buffer} */ text) => Buffer.concat([Buffer.from([0x81, 0xfe, text.length >> 8, text.length & 255, 0, 0, 0, 0]), text]);
  const hand = frame(Buffer.from('{"type":"hand","v":[0,0,0],"buttons":0,"seq":1}'.padEnd(200)));
  const payloads = [Buffer.concat(Array(300).fill(hand)), frame(Buffer.alloc(4000, '[')), frame(Buffer.alloc(6000, 'x')), Buffer.alloc(65536, 255)];
  const start = (/** @type {Buffer} */ payload) => {
    if (over) return;
    const socket = connect(Number(port), hostname, () => socket.write(`GET ${pathname}live HTTP/1.1\r\nHost: ${host}\r\nOrigin: ${origin}\r\nUpgrade: websocket\r\n` +
        'Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n'));
    sockets.add(socket);
    const more = () => { while (!over && socket.writable && socket.write(payload)); };
    socket.once('data', more);
    socket.on('drain', more);
    socket.on('error', () => undefined);
    socket.on('close', () => {
      sockets.delete(socket);
      setTimeout(start, 10, payload);
    });
  };
  /** @type {Set<import('node:net').Socket>} */
  const sockets = new Set();
  payloads.forEach(start);
  return () => {
    over = true;
    for (const socket of sockets) socket.destroy();
  };
}

/** Periods of the loop since a time of the insertion, and how far that is. @param {Page} page @param {number} since [s] */
const periods = (page, since) => page.evaluate((from) => {
  const {history} = globalThis.ferrule.live;
  const first = history.rowAt(from) + 1;
  return {periods: [...history.column('period_us', first, 1)], t: history.span()[1]};
}, since);

/** @param {Page} page */
const ready = (page) => page.waitForFunction(() => globalThis.ferrule?.live?.newest?.rows > 0);

/** The hand moves to and fro, as one that searches does. @param {Page} page @param {number} s */
async function search(page, s) {
  for (const begin = Date.now(); Date.now() - begin < 1000 * s;)
    for (const key of ['ArrowUp', 'ArrowDown']) {
      await page.keyboard.down(key);
      await pause(0.2);
      await page.keyboard.up(key);
    }
}

/** Opens the page, and gives the periods of the last seconds before. @param {string} address */
async function opened(address) {
  const begin = Date.now();
  const {page} = await open(address);
  await ready(page);
  const {periods: of} = await periods(page, 0), took = Date.now() - begin + 100;
  return {page, of: of.slice(-1000 * (kSpell - 1) - took, -took)};
}

async function inOneInsertion() {
  const server = await view('--out', join(folder, 'one'), '--set', `limits.time_s=${60 + 10 * kSpell * rounds}`);
  let {page} = await open(server.address);
  await ready(page);
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.ferrule.session.running);
  /** @type {Record<string, number[]>} */
  const loop = {alone: [], 'with a page': [], 'under a flood': []};
  const shown = {latency: /** @type {number[]} */ ([]), states: /** @type {number[]} */ ([]), pictures: /** @type {number[]} */ ([])};
  for (let round = 0; round < rounds; ++round) {
    await page.close();
    await pause(kSpell);
    let {page: next, of} = await opened(server.address);
    page = next;
    loop.alone.push(...of);
    let t;
    await pause(1.5);
    ({t} = await periods(page, 0));
    await pause(kSpell - 1);  // the hand rests in all three
    ({periods: of, t} = await periods(page, t));
    loop['with a page'].push(...of);
    await search(page, 1);
    await page.evaluate(() => { globalThis.ferrule.live.latencies.length = 0; });
    await search(page, 4);
    shown.latency.push(...await page.evaluate(() => globalThis.ferrule.live.latencies));
    const {states, rate} = await page.evaluate(() => globalThis.ferrule.frames);
    shown.states.push(states);
    shown.pictures.push(rate);
    ({t} = await periods(page, 0));
    await page.close();
    const end = flood(server.address);
    await pause(kSpell);
    end();
    ({page, of} = await opened(server.address));
    loop['under a flood'].push(...of);
  }
  await server.end();
  console.log(`states a second: ${median(shown.states).toFixed(1)}, pictures a second: ${median(shown.pictures).toFixed(1)}`);
  console.log(`hand to picture: ${median(shown.latency).toFixed(1)} ms (median of ${shown.latency.length}), 95 % within ${quantile(shown.latency, 0.95).toFixed(1)} ms`);
  const alone = quantile(loop.alone, 0.999);
  for (const [how, of] of Object.entries(loop))
    console.log(`loop ${how}: p50 ${quantile(of, 0.5).toFixed(1)}, p99 ${quantile(of, 0.99).toFixed(1)}, p99.9 ${quantile(of, 0.999).toFixed(1)} us, ` +
        `${(quantile(of, 0.999) / alone).toFixed(3)} of that alone (${of.length} rows)`);
}

console.log(`${cpus().length} processors, load ${loadavg()[0].toFixed(1)}, 1280x720, rendered by software`);
await firstFrames();
await inOneInsertion();
await browser.close();
await closeAll();

// A real browser and the program, for the tests of the page.
import {spawn, spawnSync} from 'node:child_process';
import {existsSync, mkdtempSync, rmSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join, resolve} from 'node:path';

export const [program, build] = process.argv.slice(2, 4).map((path) => resolve(path));
const installed = createRequire(join(build, 'view/page/'));
const {chromium, firefox: gecko} = installed('playwright-core');
export const axe = installed.resolve('axe-core/axe.min.js');

export const folder = mkdtempSync(join(tmpdir(), 'ferrule-page-'));
process.on('exit', () => rmSync(folder, {recursive: true, force: true}));

/** Runs the program to its end. @param {string[]} words */
export function ferrule(...words) {
  const run = spawnSync(program, words, {encoding: 'utf8', maxBuffer: 1 << 28});
  if (run.status !== 0) throw new Error(`${words.join(' ')}: ${run.stderr}`);
  return run.stdout;
}

/** @type {import('node:child_process').ChildProcess[]} */
const children = [];

/** Starts `ferrule view`; gives its address and a way to end it. @param {string[]} words */
export async function view(...words) {
  const child = spawn(program, ['view', '--no-open', ...words], {stdio: ['ignore', 'pipe', 'inherit']});
  children.push(child);
  const ended = new Promise((done) => child.on('exit', done));
  const address = await new Promise((done, fail) => {
    let text = '';
    child.stdout.on('data', (data) => {
      text += data;
      const found = /http:\/\/\S+/.exec(text);
      if (found) done(found[0]);
    });
    child.on('exit', (code) => fail(new Error(`view ended with ${code}`)));
  });
  return {
    address,
    /** @param {'SIGINT' | 'SIGKILL'} [by] */
    async end(by = 'SIGINT') {
      child.kill(by);
      await ended;
    },
  };
}

export const browser = await chromium.launch({
  executablePath: process.env.FERRULE_CHROMIUM || '/usr/bin/chromium',
  args: ['--headless=new', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
    '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});

/** Firefox as Debian has it; null where it is not installed. @returns {Promise<import('playwright-core').Browser | null>} */
export async function firefox() {
  const executablePath = process.env.FERRULE_FIREFOX || '/usr/bin/firefox-esr';
  return existsSync(executablePath) ? gecko.launch({executablePath, channel: 'moz-firefox'}) : null;
}

/** A page, and what its console said amiss. @param {string} address @param {{width?: number, height?: number, theme?: 'light' | 'dark', script?: string}} [how] */
export async function open(address, {width = 1280, height = 720, theme = 'light', script} = {}) {
  const page = await browser.newPage({viewport: {width, height}, colorScheme: theme});
  /** @type {string[]} */
  const amiss = [];
  page.on('console', (message) => {
    // Chromium says of software rendering that it is slow, which is so.
    if (['error', 'warning'].includes(message.type()) && !/GPU stall due to ReadPixels|software WebGL/i.test(message.text()))
      amiss.push(`${message.type()}: ${message.text()}`);
  });
  page.on('pageerror', (error) => amiss.push(String(error)));
  page.on('requestfailed', (request) => amiss.push(`failed: ${request.url()}`));
  if (script) await page.addInitScript(script);
  await page.goto(address);
  return {page, amiss};
}

/** Every page and program that a test left open. */
export async function closeAll() {
  for (const context of browser.contexts()) await context.close();
  for (const child of children.splice(0)) child.kill('SIGKILL');
}

/** Different colours in a picture of an element. @param {import('playwright-core').Page} page @param {string} selector */
export async function coloursOf(page, selector) {
  const png = (await page.locator(selector).screenshot()).toString('base64');
  return page.evaluate(async (data) => {
    const image = new Image();
    image.src = 'data:image/png;base64,' + data;
    await image.decode();
    const canvas = document.createElement('canvas');
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext('2d', {willReadFrequently: true});
    context.drawImage(image, 0, 0);
    const pixels = context.getImageData(0, 0, image.width, image.height).data;
    const found = new Set();
    for (let i = 0; i < pixels.length; i += 4) found.add(pixels[i] << 16 | pixels[i + 1] << 8 | pixels[i + 2]);
    return found.size;
  }, png);
}

/** What axe-core finds serious. @param {import('playwright-core').Page} page */
export async function violations(page) {
  // By its own text: the page's policy lets no other script in.
  const {readFileSync} = await import('node:fs');
  await page.evaluate(readFileSync(axe, 'utf8'));
  const found = await page.evaluate(() => globalThis.axe.run(document, {resultTypes: ['violations']}));
  return found.violations.filter((v) => v.impact === 'serious' || v.impact === 'critical')
      .map((v) => `${v.id}: ${v.nodes.map((n) => n.html.slice(0, 120)).join(' | ')}`);
}

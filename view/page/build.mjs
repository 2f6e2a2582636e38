// Bundles the page into one HTML file: node build.mjs OUT.html [PLAYGROUND.js], with the simulator in it (view/playground/)
// where that is given.
import {createHash} from 'node:crypto';
import {readFileSync, renameSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const [out, playground] = process.argv.slice(2);
if (!out) throw new Error('usage: node build.mjs OUT.html [PLAYGROUND.js]');

/** @param {string} entry */
async function bundled(entry) {
  const result = await build({
    entryPoints: [join(here, 'src', entry)],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: 'es2022',
    charset: 'ascii',
    legalComments: 'none',
    logLevel: 'warning',
  });
  return result.outputFiles[0].text;
}

// Within <script> and <style> nothing ends them but their end tags.
const inScript = (/** @type {string} */ text) => text.replace(/<(?=\/script|!--|script)/gi, '\\x3C');
const script = inScript(await bundled('main.js'));
const link = inScript(playground ? readFileSync(playground, 'utf8') + await bundled('playground.js') : await bundled('link.js'));
const style = (await bundled('style.css')).replace(/<\/style/gi, '<\\/style');
// Its own script and style run, and nothing that a text could bring in; with `/*script*/` and
// `/*style*/` exactly between their tags.
const source = (/** @type {string} */ text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const policy = [
  "default-src 'none'", `script-src ${source(script)}${playground ? " 'wasm-unsafe-eval'" : ''}`, `style-src ${source(style)}`, 'img-src data: blob:',
  'font-src data:', 'worker-src blob:', playground ? "connect-src data:" : "connect-src 'self' ws://127.0.0.1:* ws://localhost:*", "base-uri 'none'",
  "form-action 'none'",
].join('; ');
const page = readFileSync(join(here, 'src/index.html'), 'utf8')
    .replace('/*policy*/', () => policy)
    .replace('/*style*/', () => style)
    .replace('/*link*/', () => link)
    .replace('id="recorded">', () => playground ? 'id="recorded">{"mode":"playground"}' : 'id="recorded">')
    .replace('/*script*/', () => script);
writeFileSync(out + '.part', page);
renameSync(out + '.part', out);

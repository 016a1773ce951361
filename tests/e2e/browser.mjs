/** Headless Chromium, pages from this machine, and pictures as masks. */
import { createServer } from 'node:http';
import { readFile, stat } from 'node:fs/promises';
import { dirname, extname, join, normalize } from 'node:path';
import { chromium } from 'playwright-core';
import { command } from './hoodoo.mjs';

const here = import.meta.dirname;
const types = {
  '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css', '.json': 'application/json',
  '.wasm': 'application/wasm', '.glb': 'model/gltf-binary', '.svg': 'image/svg+xml', '.png': 'image/png', '.jpg': 'image/jpeg',
};
/** Software rendering, whatever graphics the machine has. */
const flags = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

export function launch() {
  const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
  return chromium.launch({ executablePath, headless: true, args: ['--no-sandbox', '--disable-dev-shm-usage', ...flags] });
}

/**
 * Serves folders on a free port of the loopback address: /viewer/ as built beside the command, /pages/,
 * /node_modules/, and what `folders` adds as {'/name/': folder}. Gives {url, close()}.
 */
export async function serveFolders(folders) {
  const mounts = {
    '/viewer/': join(dirname(command), 'viewer'), '/pages/': join(here, 'pages'), '/node_modules/': join(here, 'node_modules'), ...folders,
  };
  const find = async (url) => {
    const path = decodeURIComponent(new URL(url, 'http://localhost').pathname);
    const mount = Object.keys(mounts).find((name) => path.startsWith(name));
    const file = mount && join(mounts[mount], normalize(`/${path.slice(mount.length)}`));
    return file && ((await stat(file)).isDirectory() ? join(file, 'index.html') : file);
  };
  const server = createServer(async (request, response) => {
    try {
      const file = await find(request.url);
      const bytes = await readFile(file);
      response.writeHead(200, { 'content-type': types[extname(file)] ?? 'application/octet-stream', 'content-length': bytes.length });
      response.end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((done) => { server.listen(0, '127.0.0.1', done); });
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    close: () => new Promise((done) => { server.closeAllConnections(); server.close(done); }),
  };
}

/**
 * A page of `size` [width, height] whose `problems` collect errors of the page, answers that are none, and requests
 * to anywhere but `origin`. `more` is what else its context is made with.
 */
export async function openPage(browser, origin, size = [640, 360], more = {}) {
  const context = await browser.newContext({ viewport: { width: size[0], height: size[1] }, ...more });
  const page = await context.newPage();
  const problems = [];
  page.on('console', (message) => { if (message.type() === 'error') problems.push(`console: ${message.text()}`); });
  page.on('pageerror', (error) => problems.push(`page: ${error}`));
  page.on('crash', () => problems.push('the page crashed'));
  page.on('response', (answer) => { if (answer.status() >= 400) problems.push(`${answer.status()} ${answer.url()}`); });
  page.on('request', (request) => {
    if (!request.url().startsWith(`${origin}/`) && !/^(blob|data):/.test(request.url())) problems.push(`off the origin: ${request.url()}`);
  });
  page.setDefaultTimeout(240_000);
  return Object.assign(page, { problems, end: () => context.close() });
}

/** Waits until the viewer has drawn what was last done to it, and nothing is left to load. */
export async function settle(page) {
  // A change shows in the next frame; until then the count of idle ones goes on.
  await page.evaluate(() => { if (globalThis.hoodoo) globalThis.hoodoo.idle = 0; });
  await page.waitForFunction(() => globalThis.hoodoo?.idle > 10 && globalThis.hoodoo.terrain.current);
}

/** Which pixels of the page's canvas are not magenta: {width, height, bits: Uint8Array of 0 and 1}, top row first. */
export async function readMask(page) {
  const { width, height, text } = await page.evaluate(() => {
    const canvas = document.querySelector('canvas');
    const gl = canvas.getContext('webgl2');
    const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const pixels = new Uint8Array(w * h * 4);
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let digits = '';
    for (let y = h - 1; y >= 0; --y) {
      for (let x = 0; x < w; ++x) {
        const i = 4 * (y * w + x);
        digits += pixels[i] === 255 && pixels[i + 1] === 0 && pixels[i + 2] === 255 ? '0' : '1';
      }
    }
    return { width: w, height: h, text: digits };
  });
  return { width, height, bits: Uint8Array.from(text, Number) };
}

const count = (bits) => bits.reduce((sum, bit) => sum + bit, 0);

/** Covered pixels of `mask`, and the part of them by which `other` differs. */
export function compare(mask, other) {
  const differing = mask.bits.reduce((sum, bit, i) => sum + (bit ^ other.bits[i]), 0);
  return { covered: count(mask.bits), differing, share: differing / Math.max(1, count(mask.bits)) };
}

/** `mask` without what lies within `radius` pixels (in both directions) of a pixel outside it. */
export function shrink({ width, height, bits }, radius) {
  const pass = (from, step, length, lines, lineStep) => {
    const to = new Uint8Array(from.length);
    for (let line = 0; line < lines; ++line) {
      for (let i = 0; i < length; ++i) {
        let all = 1;
        for (let k = Math.max(0, i - radius); k <= Math.min(length - 1, i + radius); ++k) all &= from[line * lineStep + k * step];
        to[line * lineStep + i * step] = all;
      }
    }
    return to;
  };
  const rows = pass(bits, 1, width, height, width);
  return { width, height, bits: pass(rows, width, height, width, 1) };
}

const sampling = 1;   // pixels by which two drawings of one silhouette may differ

/**
 * Background of `mask`, a drawing of tiles of several levels, that should not be there. `solids` are the silhouettes of the
 * whole surface of each level on screen, the leaves' first.
 *
 * `deep`: pixels farther than `margin` pixels inside what the leaves cover, so that a coarser silhouette may move by its
 * error on screen, but not by more. Nearer to it nothing follows from the leaves alone: where a narrow gap of sky is seen
 * through, a coarser tile may widen it anywhere, and cut it off from what the leaves leave free.
 * `cracks`: pixels, at any depth, that every level on screen covers, and their neighbours too. No one surface has its edge
 * there: the ray slips between tiles of different levels. Two things it cannot tell: a near edge of one level that crosses
 * a far edge of another gives a false alarm, and a crack where one of the levels has no surface passes for that level's edge.
 * Pixels on the picture's rim are not judged, since what lies beside them is not in it.
 */
export function holes(mask, solids, margin) {
  const { width, height } = mask;
  const count = (covered) => covered.reduce((sum, bit, i) => sum + (bit && !mask.bits[i]), 0);
  const all = solids.map((solid) => shrink(solid, sampling).bits);
  const onRim = (i) => i < width || i >= width * (height - 1) || i % width === 0 || i % width === width - 1;
  const everywhere = all[0].map((bit, i) => (bit && !onRim(i) && all.every((bits) => bits[i]) ? 1 : 0));
  return { deep: count(shrink(solids[0], margin).bits), cracks: count(everywhere) };
}

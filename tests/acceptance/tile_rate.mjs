/**
 * How fast tiles come, in one run: from `hoodoo serve`, through nginx before it (deploy/nginx/hoodoo.conf without TLS and without
 * its limits for each address), and from nginx that serves the same files and nothing else. Prints a Markdown table of medians of three rounds; ends
 * with 1 when hoodoo has less than half of nginx's rate or nginx before hoodoo less than 0.9. Needs `wrk`. Run by hand:
 *
 *     node tile_rate.mjs [--seconds N] [--connections N]
 */
import { execFile } from 'node:child_process';
import { mkdir, readdir, readFile, stat, writeFile } from 'node:fs/promises';
import { join, relative } from 'node:path';
import { parseArgs, promisify } from 'node:util';
import { example, hoodoo, makeFolder, removeFolder } from '../e2e/hoodoo.mjs';
import { Nginx } from '../e2e/nginx.mjs';
import { Server, freePort } from '../e2e/server.mjs';

const { values: options } = parseArgs({ options: { seconds: { type: 'string', default: '4' }, connections: { type: 'string', default: '8' } } });
const run = promisify(execFile), rounds = 3;

const work = await makeFolder(), root = join(work, 'root'), data = join(work, 'data');
await mkdir(root);
await hoodoo(['synthesize', join(root, 'dem.tif')]);
const scene = JSON.parse(await readFile(join(example, 'scene.json'), 'utf8'));
const [port, plain, bare] = [await freePort(), await freePort(), await freePort()];
const server = await Server.start({ data, roots: [root], args: ['--public-url', `http://127.0.0.1:${plain}`] });
const id = await server.submit({ ...scene, bake: { ...scene.bake, spacing: 0.5 } });
await server.follow(id);
const out = join(data, 'jobs', id, 'out');
// wrk's own TLS would be most of what is measured: the same site once more without it.
const nginx = await Nginx.start({
  folder: join(work, 'nginx'), port, upstream: new URL(server.url).port, data, limits: false,
  more: `server { listen 127.0.0.1:${bare}; root ${out}; sendfile on; types {} default_type model/gltf-binary; }`,
  plain,
});

/** Requests a second for all tiles below `path`, one after the other on each connection. */
async function rate(name, url, tiles) {
  const script = join(work, `${name}.lua`);
  await writeFile(script, `local tiles = {${tiles.map((tile) => `"${tile}"`)}}
local i = 0
function request() i = i % #tiles + 1 return wrk.format("GET", tiles[i], { Host = "127.0.0.1:${plain}" }) end`);
  const { stdout } = await run('wrk', ['-t1', `-c${options.connections}`, `-d${options.seconds}s`, '-s', script, url]);
  if (/Non-2xx|Socket errors/.test(stdout)) throw new Error(stdout);
  return Number(/Requests\/sec:\s+([\d.]+)/.exec(stdout)[1]);
}

try {
  const items = (await readdir(join(out, 'tiles'), { recursive: true, withFileTypes: true }))
    .filter(({ name }) => name.endsWith('.glb')).map((item) => join(item.path, item.name));
  const names = items.map((file) => relative(out, file)), sizes = await Promise.all(items.map((file) => stat(file)));
  const mean = sizes.reduce((sum, { size }) => sum + size, 0) / sizes.length;
  const below = names.map((name) => `/jobs/${id}/tiles/${name}`);
  const measured = { nginx: [], hoodoo: [], through: [] };
  for (let round = 0; round < rounds; ++round) {
    measured.nginx.push(await rate('nginx', `http://127.0.0.1:${bare}`, names.map((name) => `/${name}`)));
    measured.hoodoo.push(await rate('hoodoo', server.url, below));
    measured.through.push(await rate('through', `http://127.0.0.1:${plain}`, below));
  }
  const median = (list) => [...list].sort((a, b) => a - b)[Math.floor(list.length / 2)];
  const [alone, direct, through] = Object.values(measured).map(median);
  console.log(`${names.length} tiles of ${(mean / 1024).toFixed(0)} KiB on average, ${options.connections} connections\n\n| who | tiles a second | of nginx alone | goal |\n|---|---|---|---|`);
  console.log(`| nginx alone | ${alone.toFixed(0)} | 1 | |\n| hoodoo | ${direct.toFixed(0)} | ${(direct / alone).toFixed(2)} | 0.5 |`);
  console.log(`| hoodoo behind nginx | ${through.toFixed(0)} | ${(through / alone).toFixed(2)} | 0.9 |`);
  process.exitCode = direct >= 0.5 * alone && through >= 0.9 * alone ? 0 : 1;
} finally {
  await nginx.stop();
  await server.stop('SIGKILL');
  await removeFolder(work);
}

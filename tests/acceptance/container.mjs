/**
 * The image of deploy/container, run as its own user in a chroot: it bakes the example over HTTP, by way of nginx with
 * deploy/nginx/hoodoo.conf. Run by hand, as root, after deploy/container/build.sh:
 *
 *     node container.mjs
 *
 * Exit 0 where the tileset that nginx gives is the one that the command of this machine bakes.
 */
import assert from 'node:assert/strict';
import { execFile, spawn } from 'node:child_process';
import { chown, copyFile, mkdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { promisify } from 'node:util';
import { example, hoodoo, withFolder } from '../e2e/hoodoo.mjs';
import { Nginx } from '../e2e/nginx.mjs';
import { freePort } from '../e2e/server.mjs';

const run = promisify(execFile), user = 10001;
const buildah = async (...args) => (await run('buildah', ['--storage-driver', 'vfs', ...args])).stdout.trim();

/** Posts the scene to `nginx`, waits for the job, and gives the paths and bytes of the files of its tileset. */
async function bakeThrough(nginx, key, scene) {
  const headers = { authorization: `Bearer ${key}`, 'content-type': 'application/json' };
  const posted = await nginx.ask('/processes/bake-terrain/execution', { method: 'POST', headers, body: JSON.stringify({ inputs: { scene } }) });
  assert.equal(posted.status, 201, posted.body.toString());
  const { pathname } = new URL(posted.headers.location);
  for (;; await sleep(300)) {
    const { status, message } = JSON.parse((await nginx.ask(pathname, { headers })).body);
    if (status === 'successful') break;
    assert.ok(['accepted', 'running'].includes(status), message);
  }
  const files = new Map();
  const fetch = async (name) => {
    const { status, body } = await nginx.ask(`${pathname}/tiles/${name}`, { headers });
    assert.equal(status, 200, name);
    files.set(name, body);
    return body;
  };
  const visit = async (tile) => {
    for (const { uri } of [tile.content, ...(tile.contents ?? [])].filter(Boolean)) await fetch(uri);
    for (const child of tile.children ?? []) await visit(child);
  };
  await visit(JSON.parse(await fetch('tileset.json')).root);
  return files;
}

await withFolder(async (work) => {
  const [data, keys, dems] = ['data', 'keys', 'dems'].map((name) => join(work, name));
  for (const folder of [data, keys, dems]) await mkdir(folder);
  for (const folder of [data, keys]) await chown(folder, user, user);
  assert.equal((await hoodoo(['synthesize', join(example, 'dem.tif')])).code, 0);
  await copyFile(join(example, 'dem.tif'), join(dems, 'dem.tif'));
  const scene = JSON.parse(await readFile(join(example, 'scene.json'), 'utf8'));

  const [port, own] = [await freePort(), await freePort()];
  const container = await buildah('from', 'localhost/hoodoo');
  const volumes = ['-v', `${data}:/var/lib/hoodoo`, '-v', `${keys}:/etc/hoodoo`, '-v', `${dems}:/srv/dems:ro`];
  const inside = (...args) => ['--storage-driver', 'vfs', 'run', '--isolation', 'chroot', ...volumes, container, '--', ...args];
  let server, nginx;
  try {
    const key = (await run('buildah', inside('hoodoo', 'key', '/etc/hoodoo/keys.json', 'tester', '--scopes', 'read,submit'))).stdout.trim();
    const who = (await run('buildah', inside('id', '-u'))).stdout.trim();
    assert.equal(who, `${user}`, 'the user inside');
    server = spawn('buildah', inside('hoodoo', 'serve', '--listen', `127.0.0.1:${port}`, '--data', '/var/lib/hoodoo', '--keys', '/etc/hoodoo/keys.json',
                                     '--root', '/srv/dems', '--public-url', `https://127.0.0.1:${own}`), { stdio: ['ignore', 'inherit', 'inherit'] });
    nginx = await Nginx.start({ folder: join(work, 'nginx'), port: own, upstream: port, data });
    for (let tries = 0; (await nginx.ask('/healthz')).status !== 200; ++tries) {
      assert.ok(tries < 100, 'the server in the container does not answer');
      await sleep(100);
    }
    const got = await bakeThrough(nginx, key, scene);
    const here = join(work, 'here');
    const baked = await hoodoo(['bake', join(example, 'scene.json'), '-o', here]);
    assert.equal(baked.code, 0, baked.stderr);
    for (const [name, bytes] of got) assert.ok(bytes.equals(await readFile(join(here, name))), `${name} differs`);
    console.log(`${got.size} files through nginx from user ${who} of the container: the same bytes as baked here`);
  } finally {
    await nginx?.stop();
    await run('pkill', ['-TERM', '-f', `^\\S*hoodoo serve --listen 127.0.0.1:${port}`]).catch(() => {});
    if (server && server.exitCode === null) await new Promise((done) => server.once('exit', done));
    await buildah('rm', container);
  }
});

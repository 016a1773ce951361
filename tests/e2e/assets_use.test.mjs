/** Who may send elevations and read them, what is made of them, and disks without room. */
import assert from 'node:assert/strict';
import { randomBytes } from 'node:crypto';
import { mkdir, readFile, rm, statfs } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { exampleScene, makeFolder, makeKey, makeRoot, removeFolder, run } from './hoodoo.mjs';
import { ask, create, kept, mebibyte, nameOf, offsetOf, patch, put, tus } from './sending.mjs';
import { Server } from './server.mjs';

let work, root, server, dem;
const start = (name, ...args) => Server.start({ data: join(work, name), args });

before(async () => {
  work = await makeFolder();
  root = await makeRoot(work);
  dem = await readFile(join(root, 'dem.tif'));
  server = await start('data', '--asset-space', '64');
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

test('With keys, assets are read with one and sent with another', async () => {
  const keys = {};
  for (const [name, scopes] of [['artist', 'submit'], ['other', 'submit'], ['monitor', 'read']]) {
    keys[name] = { authorization: `Bearer ${await makeKey(join(work, 'keys.json'), name, '--scopes', scopes)}` };
  }
  const to = await start('keys', '--keys', join(work, 'keys.json')), path = `/assets/${nameOf(dem)}`;
  try {
    const sent = async (who) => (await put(to, dem, { expect: '100-continue', ...keys[who] })).status;
    assert.deepEqual([await sent('nobody'), await sent('monitor'), await sent('artist')], [401, 403, 201]);
    const got = async (who) => (await to.fetch(path, { headers: keys[who] ?? {} })).status;
    assert.deepEqual([await got('nobody'), await got('artist'), await got('monitor')], [401, 403, 200]);
    assert.match((await to.fetch(path, { headers: keys.monitor })).headers.get('cache-control'), /^private/);
    const made = async (who) => (await ask(to, 'POST', '/uploads', { ...tus, 'upload-length': 3, 'content-length': 0, ...keys[who] })).status;
    assert.deepEqual([await made('nobody'), await made('monitor')], [401, 403]);
    const upload = await create(to, Buffer.from('abc'), keys.artist);
    assert.equal((await patch(to, upload, 0, Buffer.from('abc'))).status, 401);
    assert.equal((await patch(to, upload, 0, Buffer.from('abc'), keys.other)).status, 403);
    assert.equal((await ask(to, 'DELETE', upload, { ...tus, ...keys.other })).status, 403);
    assert.equal((await patch(to, upload, 0, Buffer.from('abc'), keys.artist)).status, 204);
  } finally {
    await to.stop('SIGKILL');
  }
});

test('A scene is baked from an asset that was sent, and an elevation model analyzed', async () => {
  const scene = await exampleScene();
  const name = nameOf(dem);
  const named = { ...scene, bake: { ...scene.bake, spacing: 8 }, terrains: scene.terrains.map((one) => ({ ...one, dem: name })) };
  assert.equal((await put(server, dem)).status < 300, true);
  const id = await server.submit(named);
  assert.equal((await server.follow(id)).at(-1).status, 'successful');
  assert.equal((await server.fetch(`/jobs/${id}/tiles/tileset.json`)).status, 200);
  const analyze = (input) => server.fetch('/processes/analyze-dem/execution', {
    method: 'POST', headers: { 'content-type': 'application/json' },
    body: JSON.stringify({ inputs: { dem: input }, outputs: { slope: {} } }),
  });
  for (const input of [name, { href: `${server.url}/assets/${name}` }]) {
    const answer = await analyze(input);
    assert.equal(answer.status, 201, await answer.clone().text());
    assert.equal((await server.follow((await answer.json()).jobID)).at(-1).status, 'successful');
  }
  const missing = nameOf('missing');
  assert.equal((await analyze({ href: `${server.url}/assets/${missing}` })).status, 400);
  const refused = await server.post({ ...named, terrains: [{ dem: missing }] });
  assert.equal(refused.status, 422);
  assert.equal((await refused.json()).errors[0].pointer, '/terrains/0/dem');
});

test('What is under way is no file that a job may name', async () => {
  const bytes = Buffer.from(dem), path = await create(server, bytes);
  assert.equal((await patch(server, path, 0, bytes.subarray(0, 1000))).status, 204);
  const id = path.split('/').at(-1);
  for (const name of [`${id}.data`, `../uploads/${id}.data`, `${id}.json`, '../jobs.db']) {
    assert.equal((await server.post({ hoodoo: 1, terrains: [{ dem: name }] })).status, 422, name);
    assert.equal((await server.raw(`/assets/${name}`)).status, 404);
  }
  assert.equal((await ask(server, 'DELETE', path, tus)).status, 204);
});

/** Calls `use(server, disk)` with a server whose data are on a disk of 96 MiB; skips where nothing may be mounted. */
async function withDisk(t, args, use) {
  const disk = join(work, 'disk');
  await mkdir(disk, { recursive: true });
  const mounted = await run('mount', ['-t', 'tmpfs', '-o', `size=${96 * mebibyte}`, 'none', disk]).catch(({ message }) => ({ stderr: message }));
  if (mounted.code !== 0) return t.skip(`nothing may be mounted here: ${mounted.stderr.trim()}`);
  let to;
  try {
    to = await Server.start({ data: disk, roots: [root], args });
    return await use(to, disk);
  } finally {
    await to?.stop('SIGKILL');
    await run('umount', [disk]);
  }
}

test('A disk without room is 507, before the body is sent, and while it is', (t) => withDisk(t, [], async (to, disk) => {
  const bytes = randomBytes(40 * mebibyte), small = randomBytes(8 * mebibyte);
  for (const expect of [{}, { expect: '100-continue' }]) {
    const full = await put(to, bytes, expect);
    assert.deepEqual([full.status, full.continued], [507, false], full.text);
  }
  assert.equal((await put(to, small)).status, 201);
  assert.equal((await ask(to, 'POST', '/uploads', { ...tus, 'upload-length': bytes.length, 'content-length': 0 })).status, 507);
  // One that began while there was room, on a disk that fills meanwhile.
  const later = randomBytes(16 * mebibyte), path = await create(to, later), half = 4 * mebibyte;
  assert.equal((await patch(to, path, 0, later.subarray(0, half))).status, 204);
  await run('fallocate', ['-l', String(78 * mebibyte), join(disk, 'other')]);
  const failed = await patch(to, path, half, later.subarray(half));
  assert.equal(failed.status, 507, failed.text);
  assert.match(failed.text, /No space left/);
  assert.equal(await offsetOf(to, path), half);
  await rm(join(disk, 'other'));
  assert.equal((await patch(to, path, half, later.subarray(half))).status, 204);
  assert.deepEqual((await kept(disk)).assets.sort(), [nameOf(small), nameOf(later)].sort());
}));

test('A job whose disk fills says so, the server goes on, and bakes again when there is room', (t) => withDisk(t, ['--free-space', '0'], async (to, disk) => {
  const scene = await exampleScene(), of = (spacing) => ({ ...scene, bake: { ...scene.bake, spacing } });
  const id = await to.submit(of(4));
  await run('dd', ['if=/dev/zero', `of=${join(disk, 'other')}`, 'bs=64k']);   // to the last byte, the server's own records included
  assert.equal((await to.follow(id)).at(-1).status, 'failed');
  const results = await to.fetch(`/jobs/${id}/results`), problem = await results.json();
  assert.deepEqual([results.status, problem.status], [507, 507]);
  assert.match(problem.errors[0].detail, /No space left on device/);
  assert.match(problem.errors[0].pointer, new RegExp(`^jobs/${id}/`), 'no folder of the machine is told');
  assert.equal((await statfs(disk)).bavail, 0, 'it is still full');
  for (const path of ['/healthz', '/jobs', `/jobs/${id}`]) assert.equal((await to.fetch(path)).status, 200, path);
  assert.equal((await to.post(of(8))).status, 507);
  await rm(join(disk, 'other'));
  assert.equal((await to.follow(await to.submit(of(8)))).at(-1).status, 'successful');
  assert.equal((await to.json(`/jobs/${id}`)).status, 'failed');
}));

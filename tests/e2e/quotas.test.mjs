/** What a key may use at most, and what becomes of assets that nobody needs. */
import assert from 'node:assert/strict';
import { createHash, randomBytes } from 'node:crypto';
import { readFile, readdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { Contract } from './contract.mjs';
import { exampleScene, hoodoo, makeFolder, makeKey, makeRoot, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

let work, root, scene, dem;
const keys = {};
const limits = {
  few: ['--most-jobs', '2'], small: ['--most-space', '1'], tiles: ['--most-tiles', '3'], near: ['--most-extent', '100'],
  free: [], ops: ['--scopes', 'admin'],
};

before(async () => {
  work = await makeFolder();
  root = await makeRoot(work);
  dem = await readFile(join(root, 'dem.tif'));
  scene = await exampleScene();
  for (const [name, options] of Object.entries(limits)) {
    keys[name] = await makeKey(join(work, 'keys.json'), name, ...options);
  }
});
after(() => removeFolder(work));

const as = (name) => ({ authorization: `Bearer ${keys[name]}` });
async function start(name, ...args) {
  const server = await Server.start({ data: join(work, name), roots: [root], args: ['--keys', join(work, 'keys.json'), ...args] });
  server.ask = new Contract(await server.json('/api')).of(server);
  return server;
}
const execute = (server, who, process, inputs) => server.ask(`/processes/${process}/execution`, {
  method: 'POST', body: JSON.stringify({ inputs }),
  headers: { 'content-type': 'application/json', prefer: 'respond-async', ...as(who) },
});
async function posted(...request) {
  const response = await execute(...request);
  assert.equal(response.status, 201, await response.clone().text());
  return (await response.json()).jobID;
}
const nameOf = (bytes) => `sha256-${createHash('sha256').update(bytes).digest('hex')}`;
const put = (server, who, bytes) => server.ask(`/assets/${nameOf(bytes)}`, { method: 'PUT', body: bytes, headers: as(who) });
const remove = async (server, who, name) => (await server.ask(`/assets/${name}`, { method: 'DELETE', headers: who ? as(who) : {} })).status;
const onDisk = async (name) => (await readdir(join(work, name, 'assets'))).length;

test('A key has so many jobs that wait or run, and no more', async () => {
  const server = await start('jobs');
  try {
    const slow = { echo: 1, pause: 10 };
    const first = await posted(server, 'few', 'echo', slow);
    await posted(server, 'few', 'echo', slow);
    await server.follow(first, ({ status }) => status === 'running');
    const refused = await execute(server, 'few', 'echo', slow);
    assert.equal(refused.status, 429);
    assert.equal(refused.headers.get('retry-after'), '60');
    assert.match((await refused.json()).detail, /You have 2 jobs under way, and may have 2\./);
    await posted(server, 'free', 'echo', slow);
    assert.equal((await server.fetch(`/jobs/${first}`, { method: 'DELETE', headers: as('few') })).status, 200);
    await posted(server, 'few', 'echo', slow);
  } finally {
    await server.stop('SIGKILL');
  }
});

test('A key has so much space for its assets and results', async () => {
  const server = await start('space');
  try {
    const large = await put(server, 'small', randomBytes(2 << 20));
    assert.equal(large.status, 413);
    assert.match((await large.json()).errors[0].detail, /^2097152 more bytes are wanted; 0 bytes are used, the limit of the key is 1048576 bytes$/);
    const mine = randomBytes(700_000);
    assert.equal((await put(server, 'small', mine)).status, 201);
    assert.equal((await put(server, 'small', randomBytes(700_000))).status, 403);
    const upload = await server.ask('/uploads', {
      method: 'POST', headers: { 'tus-resumable': '1.0.0', 'upload-length': '700000', ...as('small') },
    });
    assert.equal(upload.status, 403);
    assert.equal((await put(server, 'free', randomBytes(2 << 20))).status, 201, 'the limit is of one key');
    const job = await posted(server, 'small', 'bake-terrain', { scene });
    assert.equal((await server.follow(job)).at(-1).status, 'successful');
    let full;
    for (const end = Date.now() + 60_000; Date.now() < end; await sleep(100)) {   // it is counted once it has ended
      full = await execute(server, 'small', 'echo', { echo: 1 });
      if (full.status === 403) break;
    }
    assert.equal(full.status, 403);
    const [, used] = /^(\d+) bytes are used, the limit of the key is 1048576 bytes$/.exec((await full.json()).errors[0].detail);
    assert.ok(Number(used) > 1 << 20, used);
    assert.equal((await server.fetch(`/jobs/${job}`, { method: 'DELETE', headers: as('small') })).status, 200);
    assert.equal(await remove(server, 'small', nameOf(mine)), 204);
    await posted(server, 'small', 'echo', { echo: 1 });
  } finally {
    await server.stop('SIGKILL');
  }
});

test("An edit is of a scene of the same key; an administrator's of any; any bake may be a base", async () => {
  const server = await start('edits');
  try {
    const base = await posted(server, 'free', 'bake-terrain', { scene });
    assert.equal((await server.follow(base)).at(-1).status, 'successful');
    const edit = [{ op: 'test', path: '/hoodoo', value: 1 }];
    for (const change of [edit, [], [{ op: 'test', path: '/hoodoo', value: 2 }]]) {
      const refused = await execute(server, 'few', 'bake-terrain', { base, edit: change });
      assert.equal(refused.status, 400);
      const { errors } = await refused.json();
      assert.deepEqual(errors.map(({ pointer }) => pointer), ['/inputs/base'], 'and nothing of the scene');
    }
    await posted(server, 'few', 'bake-terrain', { base, scene });
    await posted(server, 'ops', 'bake-terrain', { base, edit });
    await posted(server, 'free', 'bake-terrain', { base, edit });
  } finally {
    await server.stop('SIGKILL');
  }
});

test('Uploads that begin at once take no more space than one after another', async () => {
  const server = await start('at-once');
  try {
    const begun = await Promise.all(Array.from({ length: 20 }, () => server.fetch('/uploads', {
      method: 'POST', headers: { 'tus-resumable': '1.0.0', 'upload-length': String(600 << 10), ...as('small') },
    })));
    const made = begun.filter(({ status }) => status === 201);
    assert.ok(made.length <= 1, `${made.length} of 1 MiB`);
    assert.ok(begun.every(({ status }) => status === 201 || status === 403));
    for (const { headers } of made) {
      const path = new URL(headers.get('location')).pathname;
      assert.equal((await server.fetch(path, { method: 'DELETE', headers: { 'tus-resumable': '1.0.0', ...as('small') } })).status, 204);
    }
    const after = await server.fetch('/uploads', {
      method: 'POST', headers: { 'tus-resumable': '1.0.0', 'upload-length': String(600 << 10), ...as('small') },
    });
    assert.equal(after.status, 201, 'those refused take nothing');
  } finally {
    await server.stop('SIGKILL');
  }
});

test('A key has so many uploads under way, and finished ones do not count', async () => {
  const server = await start('uploads');
  const create = (who, length) => server.ask('/uploads', {
    method: 'POST', headers: { 'tus-resumable': '1.0.0', 'upload-length': String(length), ...as(who) },
  });
  try {
    const made = [];
    for (let n = 0; n < 20; ++n) assert.equal((await create('free', 0)).status, 201);   // finished at once
    for (let n = 0; n < 100; ++n) made.push(await create('free', 1));
    assert.ok(made.every(({ status }) => status === 201));
    const refused = await create('free', 1);
    assert.deepEqual([refused.status, refused.headers.get('retry-after')], [429, '60']);
    assert.match((await refused.json()).detail, /You have 100 uploads under way/);
    assert.equal((await create('few', 1)).status, 201, 'the limit is of one key');
    const path = new URL(made[0].headers.get('location')).pathname;
    assert.equal((await server.ask(path, { method: 'DELETE', headers: { 'tus-resumable': '1.0.0', ...as('free') } })).status, 204);
    assert.equal((await create('free', 1)).status, 201);
  } finally {
    await server.stop('SIGKILL');
  }
});

test('A bake of too many tiles, or of too large a world, fails before its first tile', async () => {
  const server = await start('bakes');
  try {
    for (const [who, pointer, what] of [['tiles', '/bake/spacing', /gives \d+ tiles, the limit is 3$/],
                                        ['near', '/bake/extent', /^the longest side of the world is \d+(\.\d+)? m, the limit is 100(\.0)? m$/]]) {
      const id = await posted(server, who, 'bake-terrain', { scene });
      const { status, tiles, errors } = (await server.follow(id)).at(-1);
      assert.deepEqual([status, tiles.done, errors.length], ['failed', 0, 1]);
      assert.equal(errors[0].pointer, pointer);
      assert.match(errors[0].detail, what);
      const results = await server.ask(`/jobs/${id}/results`);
      assert.equal(results.status, 413);
    }
  } finally {
    await server.stop('SIGKILL');
  }
});

test('The command has these limits too', async () => {
  const bake = (...args) => hoodoo(['bake', join(work, 'scene.json'), '--base', root, '-o', join(work, 'out'), ...args]);
  await writeFile(join(work, 'scene.json'), JSON.stringify(scene));
  const planned = JSON.parse((await bake('--json', '--plan')).stdout).planned;
  const over = await bake('--most-tiles', String(planned - 1));
  assert.equal(over.code, 3);
  assert.match(over.stderr, new RegExp(`/bake/spacing: .* gives ${planned} tiles, the limit is ${planned - 1}`));
  const far = await bake('--most-extent', '50');
  assert.equal(far.code, 3);
  assert.match(far.stderr, /\/bake\/extent: the longest side of the world is/);
  assert.equal((await bake('--plan', '--most-tiles', String(planned), '--most-extent', '1e6')).code, 0);
  assert.equal((await bake('--most-tiles', '0')).code, 2);
});

test('Keys come and go without a restart, and a damaged file changes nothing', async () => {
  const file = join(work, 'changing.json');
  const old = await makeKey(file, 'artist');
  const server = await Server.start({ data: join(work, 'changing'), args: ['--keys', file] });
  const ask = async (key) => (await server.fetch('/jobs', { headers: { authorization: `Bearer ${key}` } })).status;
  const until = async (key, status) => {
    for (const end = Date.now() + 60_000; await ask(key) !== status; await sleep(100)) assert.ok(Date.now() < end, `it is not ${status}`);
  };
  try {
    assert.equal(await ask(old), 200);
    const other = await makeKey(file, 'artist');   // in its place
    await until(other, 200);
    assert.equal(await ask(old), 401);
    await writeFile(file, '{"keys": [');
    for (const end = Date.now() + 60_000; !server.stderr.includes('those of before are kept'); await sleep(100)) {
      assert.ok(Date.now() < end, 'the damage is not logged');
      assert.equal(await ask(other), 200);
    }
    assert.match(server.stderr, /changing\.json: is no JSON/);
    assert.equal(await ask(other), 200);
    await writeFile(file, '{"keys": []}');   // no key at all would let everybody in
    await sleep(1500);
    assert.deepEqual([await ask(other), await ask('hoodoo_0')], [200, 401]);
  } finally {
    await server.stop('SIGKILL');
  }
});

test('A file of keys tells what is wrong with a limit', async () => {
  const file = join(work, 'wrong.json');
  const entry = { name: 'a', sha256: '0'.repeat(64), scopes: ['read'] };
  for (const [most, where] of [[5, ''], [{ jobs: 0 }, '/jobs'], [{ bytes: -1 }, '/bytes'], [{ tiles: 1.5 }, '/tiles'],
                               [{ extent: 0 }, '/extent'], [{ files: 1 }, '/files']]) {
    await writeFile(file, JSON.stringify({ keys: [{ ...entry, most }] }));
    const { code, stderr } = await hoodoo(['serve', '--listen', '127.0.0.1:0', '--data', join(work, 'none'), '--keys', file], { limit: 10_000 });
    assert.equal(code, 2, JSON.stringify(most));
    assert.ok(stderr.includes(`wrong.json#/keys/0/most${where}: `), stderr);
  }
});

test('An asset is removed by who sent it or an administrator, when no job needs it', async () => {
  const server = await start('removed');
  try {
    const name = nameOf(dem);
    assert.equal((await put(server, 'free', dem)).status, 201);
    assert.equal(await remove(server, null, name), 401);
    assert.equal(await remove(server, 'few', name), 403);
    assert.equal(await remove(server, 'free', nameOf('nothing')), 404);
    // What waits behind a job that takes its time needs it.
    const running = await posted(server, 'few', 'echo', { echo: 1, pause: 10 });
    const own = { ...scene, terrains: [{ ...scene.terrains[0], dem: name }] };
    const waiting = await posted(server, 'few', 'bake-terrain', { scene: own });
    assert.equal(await remove(server, 'free', name), 409);
    assert.equal(await remove(server, 'ops', name), 409);
    await server.fetch(`/jobs/${running}`, { method: 'DELETE', headers: as('few') });
    assert.equal((await server.follow(waiting)).at(-1).status, 'successful');
    assert.equal(await remove(server, 'free', name), 204);
    assert.equal(await remove(server, 'free', name), 404);
    assert.equal(await onDisk('removed'), 0);
    assert.equal((await put(server, 'free', dem)).status, 201);
    assert.equal(await remove(server, 'ops', name), 204);
    // In parts it is its sender's too.
    const { headers } = await server.ask('/uploads', {
      method: 'POST', headers: { 'tus-resumable': '1.0.0', 'upload-length': String(dem.length), ...as('free') },
    });
    const patched = await server.ask(new URL(headers.get('location')).pathname, {
      method: 'PATCH', body: dem,
      headers: { 'tus-resumable': '1.0.0', 'upload-offset': '0', 'content-type': 'application/offset+octet-stream', ...as('free') },
    });
    assert.equal(patched.status, 204);
    assert.equal(await remove(server, 'few', name), 403);
    assert.equal(await remove(server, 'free', name), 204);
  } finally {
    await server.stop('SIGKILL');
  }
});

test('Assets that no job uses go after a time; what a job needs stays', async () => {
  const server = await start('kept', '--keep-assets', '2');
  try {
    const name = nameOf(dem);
    const unused = randomBytes(1000);
    assert.equal((await put(server, 'free', dem)).status, 201);
    const jobs = [];   // one runs, two wait
    for (let i = 0; i < 3; ++i) jobs.push(await posted(server, 'free', 'echo', { echo: { dem: name }, pause: 10 }));
    assert.equal((await put(server, 'free', unused)).status, 201);
    for (const end = Date.now() + 60_000; await onDisk('kept') > 1; await sleep(100)) assert.ok(Date.now() < end, 'nothing went');
    assert.equal((await server.fetch(`/assets/${nameOf(unused)}`, { method: 'HEAD', headers: as('free') })).status, 404);
    assert.equal((await server.fetch(`/assets/${name}`, { method: 'HEAD', headers: as('free') })).status, 200);
    for (const id of jobs) assert.equal((await server.fetch(`/jobs/${id}`, { method: 'DELETE', headers: as('free') })).status, 200);
    for (const end = Date.now() + 60_000; await onDisk('kept') > 0; await sleep(100)) assert.ok(Date.now() < end, 'it stays');
  } finally {
    await server.stop('SIGKILL');
  }
});

test('On a disk that is nearly full nothing more is taken', async () => {
  const server = await start('full', '--free-space', String(1024 ** 3));   // a pebibyte
  try {
    const refused = await execute(server, 'free', 'echo', { echo: 1 });
    assert.equal(refused.status, 507);
    assert.match((await refused.json()).errors[0].detail, /^the disk has no space: \d+ bytes are left, and 1125899906842624 are kept free$/);
    assert.equal((await put(server, 'free', randomBytes(10))).status, 507);
    const upload = await server.ask('/uploads', { method: 'POST', headers: { 'tus-resumable': '1.0.0', 'upload-length': '10', ...as('free') } });
    assert.equal(upload.status, 507);
  } finally {
    await server.stop('SIGKILL');
  }
});

/** The job server as a client meets it: post, poll, fetch, cancel, stop, start again. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFile, symlink, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { digests, exampleScene, hoodoo, makeFolder, makeRoot, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const sanitized = Boolean(process.env.HOODOO_SANITIZED);
const most = sanitized ? 30 : 3;   // seconds in which a wrong scene is refused: a process starts for it
let work, root, data, server, scene, id;

/** A scene that takes a while: the example on a finer grid. */
const long = () => ({ ...scene, bake: { ...scene.bake, spacing: 1 } });

before(async () => {
  work = await makeFolder();
  root = await makeRoot(work);
  data = join(work, 'data');
  scene = await exampleScene();
  await writeFile(join(work, 'outside.tif'), await readFile(join(root, 'dem.tif')));
  await symlink('../outside.tif', join(root, 'link.tif'));
  server = await Server.start({ data, roots: [root] });
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

test('A posted scene is baked: 201 with its absolute location, progress, results', async () => {
  const response = await server.post(scene);
  assert.equal(response.status, 201);
  const location = response.headers.get('location');
  id = (await response.json()).jobID;
  assert.equal(location, `${server.url}/jobs/${id}`);
  const seen = await server.follow(id);
  assert.equal(seen.at(-1).status, 'successful', JSON.stringify(seen.at(-1)));
  assert.equal(seen.at(-1).progress, 100);
  const progress = seen.map((info) => info.progress);
  assert.deepEqual(progress, progress.toSorted((a, b) => a - b), 'progress never goes back');
  const { tiles } = seen.at(-1);
  assert.ok(tiles.total > 1 && tiles.done === tiles.total);
  for (const member of ['processID', 'type', 'jobID', 'message', 'created', 'started', 'finished', 'updated', 'links']) {
    assert.ok(member in seen.at(-1), member);
  }
});

/** Every file that a tileset needs, from the address of its tileset.json. */
async function filesOf(url) {
  const found = new Map();
  const visit = async (address) => {
    if (found.has(address)) return;
    const response = await fetch(address);
    assert.equal(response.status, 200, address);
    const bytes = Buffer.from(await response.arrayBuffer());
    found.set(address, { bytes, response });
    if (!address.endsWith('.json')) return;
    const uris = [];
    JSON.stringify(JSON.parse(bytes), (key, value) => {
      if (key === 'uri') uris.push(value);
      return value;
    });
    for (const uri of uris) await visit(new URL(uri, address).href);
  };
  await visit(url);
  return found;
}

test('Results are absolute references, and every file of the tileset is there', async () => {
  const results = await server.json(`/jobs/${id}/results`);
  for (const name of ['tileset', 'manifest', 'report']) {
    assert.ok(results[name].href.startsWith(`${server.url}/jobs/${id}/`), name);
    assert.equal((await fetch(results[name].href)).status, 200, name);
  }
  assert.equal((await (await fetch(results.report.href)).json()).complete, true);
  const files = await filesOf(results.tileset.href);
  const tiles = [...files].filter(([address]) => address.endsWith('.glb'));
  assert.equal(tiles.length, (await server.json(`/jobs/${id}`)).tiles.total);
  for (const [address, { bytes, response }] of tiles) {
    assert.equal(response.headers.get('content-type'), 'model/gltf-binary');
    assert.match(response.headers.get('cache-control'), /immutable/);
    assert.equal(response.headers.get('access-control-allow-origin'), '*');
    const digest = createHash('sha256').update(bytes).digest('hex');
    assert.ok(address.endsWith(`/${digest}.glb`), 'a tile is named by its SHA-256');
    assert.equal(response.headers.get('etag'), `"${digest}"`);
  }
  const tileset = files.get(results.tileset.href).response.headers;
  assert.equal(tileset.get('content-type'), 'application/json');
  assert.equal(tileset.get('cache-control'), 'no-cache');
});

/** The path of one tile of the finished job. */
async function oneTile() {
  const { tiles } = await server.json(`/jobs/${id}/tiles/bake.json`);
  const { content } = tiles.find((tile) => tile.content);
  return `/jobs/${id}/tiles/tiles/${content.slice(0, 2)}/${content}.glb`;
}

test('A tile comes whole, in part, or not again', async () => {
  const path = await oneTile();
  const whole = Buffer.from(await (await server.fetch(path)).arrayBuffer());
  const with_ = (headers, method = 'GET') => server.fetch(path, { headers, method });
  const etag = (await with_({})).headers.get('etag');

  assert.equal((await with_({ 'if-none-match': etag })).status, 304);
  assert.equal((await with_({ 'if-none-match': '"other"' })).status, 200);

  const part = await with_({ range: 'bytes=4-11' });
  assert.equal(part.status, 206);
  assert.equal(part.headers.get('content-range'), `bytes 4-11/${whole.length}`);
  assert.deepEqual(Buffer.from(await part.arrayBuffer()), whole.subarray(4, 12));
  const tail = await with_({ range: 'bytes=-5' });
  assert.deepEqual(Buffer.from(await tail.arrayBuffer()), whole.subarray(-5));
  assert.equal((await with_({ range: 'bytes=4-11', 'if-range': '"older"' })).status, 200);

  for (const range of [`bytes=${whole.length}-`, 'bytes=0-1,4-5']) {
    const refused = await with_({ range });
    assert.equal(refused.status, 416, range);
    assert.equal(refused.headers.get('content-range'), `bytes */${whole.length}`);
    assert.equal(refused.headers.get('access-control-allow-origin'), '*');
  }
  for (const range of ['bytes=abc', 'bytes=9-4', 'lines=0-1']) {
    const ignored = await with_({ range });
    assert.deepEqual([ignored.status, Buffer.from(await ignored.arrayBuffer()).equals(whole)], [200, true], range);
    assert.equal((await server.fetch('/healthz', { headers: { range } })).status, 200);
    const body = JSON.stringify({ inputs: { echo: 1 } });
    assert.equal((await server.fetch('/processes/echo/execution', { method: 'POST', headers: { range, 'content-type': 'application/json' }, body })).status, 200);
  }
  const head = await with_({}, 'HEAD');
  assert.equal(head.headers.get('content-length'), String(whole.length));
  assert.equal(head.headers.get('accept-ranges'), 'bytes');
  for (const other of ['/healthz', '/nothing', path.replace(/\/tiles\/.*/, '/events'), `${path}x`]) {
    assert.equal((await server.fetch(other, { method: 'HEAD' })).headers.get('accept-ranges'), null, other);
  }
  assert.equal((await head.arrayBuffer()).byteLength, 0);
});

test('What lies beside the tiles is not served', async () => {
  const below = `/jobs/${id}/tiles`;
  for (const path of ['/.hoodoo', '/.hoodoo/', '/../job.json', '/../scene.json', '/%2e%2e/job.json', '/..%2fjob.json',
                      '/..%5cjob.json', '/tiles/', '/tiles', '/', '', '//bake.json', '/tileset.json/', '/tileset.json%00.glb',
                      '/nothing.json', '/tiles/../../job.json', '/.', '/..']) {
    const { status } = await server.raw(below + path);
    assert.ok(status === 404 || status === 400, `${path} answers ${status}`);
  }
  for (const path of ['/jobs/../data', '/jobs/..', `/jobs/${id}/out`, `/jobs/${id}/job.json`, '/etc/passwd', '/viewer/../../etc/passwd',
                      '/jobs/00000000000000000000000000000000', '/nothing']) {
    assert.equal((await server.raw(path)).status, 404, path);
  }
});

/** name: [body, status, what the problems say]. */
const wrong = {
  'No JSON': ['{"inputs": ', 400, /line/],
  'No scene': ['{"inputs": {}}', 400, /scene/],
  'A million nested arrays': ['['.repeat(1_000_000) + ']'.repeat(1_000_000), 413, /deep|nest|too many values/],
  'An unknown key': [{ bogus: 1 }, 422, /\/bogus/],
  'A value out of its range': [{ operations: [{ op: 'union', tree: { type: 'sphere', center: [0, 0, 0], radius: -1 } }] },
                               422, /\/operations\/0\/tree\/radius/],
  'A file that is not there': [{ terrains: [{ dem: 'nowhere.tif' }] }, 422, /\/terrains\/0\/dem/],
  'A cycle of use': [{ define: { a: { use: 'a' } }, operations: [{ op: 'union', tree: { use: 'a' } }] }, 422, /\/define\/a/],
  'A file above the root': [{ terrains: [{ dem: '../outside.tif' }] }, 422, /\/terrains\/0\/dem/],
  'A file elsewhere': [{ terrains: [{ dem: '/etc/passwd' }] }, 422, /\/terrains\/0\/dem/],
  'A link out of the root': [{ terrains: [{ dem: 'link.tif' }] }, 422, /\/terrains\/0\/dem/],
  'A grid out of reach': [{ bake: { spacing: 1e-5 } }, 422, /spacing/],
};
for (const [what, [body, status, says]] of Object.entries(wrong)) {
  test(`${what} is answered ${status}, in under ${most} s`, async () => {
    const start = performance.now();
    const response = await (typeof body === 'string' ? server.send(body) : server.post({ ...scene, ...body }));
    const text = await response.text();
    assert.equal(response.status, status, text.slice(0, 500));
    assert.equal(response.headers.get('content-type'), 'application/problem+json');
    assert.match(text, says);
    assert.ok(!text.includes(work), 'no folder of the server is named');
    assert.ok(performance.now() - start < 1000 * most);
  });
}

/** Asks, by its headers alone, whether a body of `length` bytes may follow. */
async function announce(length) {
  const { request } = await import('node:http');
  const headers = { 'content-type': 'application/json', 'content-length': length, expect: '100-continue' };
  return new Promise((resolve, reject) => {
    const asking = request(new URL('/processes/bake-terrain/execution', server.url), { method: 'POST', headers });
    asking.on('continue', () => reject(new Error('the body may follow')));
    asking.on('error', reject);
    asking.on('response', async (response) => {
      const text = (await response.setEncoding('utf8').toArray()).join('');
      asking.destroy();
      resolve({ status: response.statusCode, type: response.headers['content-type'], text });
    });
    asking.flushHeaders();
  });
}

test('A body over the limit is answered 413 before it is sent, and its sender is cut off', async () => {
  const { status, type, text } = await announce(5 << 20);
  assert.equal(status, 413, text);
  assert.equal(type, 'application/problem+json');
  assert.match(text, /limit/);
  // Whoever sends all the same may find the connection closed before the answer is read.
  const sent = await server.send('a'.repeat(5 << 20)).catch(({ cause }) => cause);
  assert.ok(sent.status === 413 || ['EPIPE', 'ECONNRESET', 'UND_ERR_SOCKET'].includes(sent.code), String(sent));
  assert.equal((await server.fetch('/jobs')).status, 200);
});

test('Every problem of a scene is in one answer, each with its pointer', async () => {
  const response = await server.post({ ...scene, bogus: 1, terrains: [{ dem: 'nowhere.tif' }] });
  const pointers = (await response.json()).errors.map(({ pointer }) => pointer);
  assert.ok(pointers.includes('/bogus') && pointers.includes('/terrains/0/dem'), pointers.join());
});

test('A request for another host is refused', async () => {
  const { hostname, port } = new URL(server.url);
  const { request } = await import('node:http');
  const status = await new Promise((resolve) => {
    request({ hostname, port, path: '/jobs', headers: { host: 'rebound.example' } }, (response) => {
      response.resume();
      resolve(response.statusCode);
    }).end();
  });
  assert.equal(status, 421);
});

test('A running job is cancelled within its tiles in flight, and removed when asked again', async () => {
  const running = await server.submit(long());
  const waiting = await server.submit(long());
  await server.follow(running, ({ tiles }) => tiles.done > 0);
  for (const job of [waiting, running]) {
    const answer = await server.fetch(`/jobs/${job}`, { method: 'DELETE' });
    assert.equal((await answer.json()).status, 'dismissed');
  }
  assert.equal((await server.fetch(`/jobs/${running}/results`)).status, 409);
  const gone = async () => {
    await server.fetch(`/jobs/${running}`, { method: 'DELETE' });
    return (await server.fetch(`/jobs/${running}`)).status === 404;
  };
  const end = Date.now() + (sanitized ? 60_000 : 10_000);
  while (!await gone()) assert.ok(Date.now() < end, 'the bake goes on after it was cancelled');
});

test('A second server on the port or the data fails and says so', async () => {
  const { host } = new URL(server.url);
  const port = await hoodoo(['serve', '--listen', host, '--data', join(work, 'other')], { limit: 10_000 });
  assert.equal(port.code, 4, port.stderr);
  assert.match(port.stderr, new RegExp(host));
  const taken = await hoodoo(['serve', '--listen', '127.0.0.1:0', '--data', data], { limit: 10_000 });
  assert.equal(taken.code, 4, taken.stderr);
  assert.match(taken.stderr, /in use/);
});

for (const signal of ['SIGTERM', 'SIGKILL']) {
  test(`A job interrupted by ${signal} to the server goes on at the next start, to the same bytes`, async () => {
    const expected = await digests(join(data, 'jobs', id, 'out'));
    const again = await server.submit(scene);
    await server.follow(again, ({ tiles, status }) => tiles.done > 0 || status === 'successful');
    const end = await server.stop(signal);
    if (signal === 'SIGTERM') assert.deepEqual(end, { code: 0, signal: null }, server.stderr);
    server = await Server.start({ data, roots: [root] });
    const seen = await server.follow(again);
    assert.equal(seen.at(-1).status, 'successful', JSON.stringify(seen.at(-1)));
    assert.deepEqual(await digests(join(data, 'jobs', again, 'out')), expected);
    assert.equal((await server.json(`/jobs/${id}`)).status, 'successful');
    await server.fetch(`/jobs/${again}`, { method: 'DELETE' });
  });
}

test('Without a root no file can be named', async () => {
  const bare = await Server.start({ data: join(work, 'bare') });
  try {
    for (const dem of ['dem.tif', join(root, 'dem.tif'), '../../root/dem.tif']) {
      const response = await bare.post({ hoodoo: 1, terrains: [{ dem }] });
      assert.equal(response.status, 422, dem);
    }
  } finally {
    await bare.stop();
  }
});

/** deploy/nginx/hoodoo.conf as it is, but for names and places, before a server with keys. */
import assert from 'node:assert/strict';
import { mkdir, symlink, writeFile } from 'node:fs/promises';
import { connect as connectTwo } from 'node:http2';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { connect } from 'node:tls';
import { exampleScene, makeFolder, makeKey, makeRoot, removeFolder } from './hoodoo.mjs';
import { Nginx } from './nginx.mjs';
import { answersIn } from './raw.mjs';
import { Server, freePort } from './server.mjs';

let work, server, nginx, key, scene, job;

before(async () => {
  work = await makeFolder();
  const root = await makeRoot(work), keys = join(work, 'keys.json');
  key = await makeKey(keys, 'artist');
  scene = await exampleScene();
  const port = await freePort();
  server = await Server.start({ data: join(work, 'data'), roots: [root], args: ['--public-url', `https://127.0.0.1:${port}`, '--keys', keys] });
  nginx = await Nginx.start({ folder: join(work, 'nginx'), port, upstream: new URL(server.url).port, data: join(work, 'data') });
});
after(async () => {
  await nginx?.stop();
  await server?.stop();
  await removeFolder(work);
});

const document = async (path, options) => JSON.parse((await nginx.ask(path, options)).body);
const submit = (more = {}) => nginx.ask('/processes/bake-terrain/execution', {
  method: 'POST', headers: { 'content-type': 'application/json', authorization: `Bearer ${key}`, ...more },
  body: JSON.stringify({ inputs: { scene } }),
});
/** What a connection that sends `text` gets until it is closed. */
const raw = (text) => new Promise((resolve, reject) => {
  const { hostname, port } = new URL(nginx.url);
  let got = '';
  const socket = connect({ host: hostname, port, ca: nginx.certificate }, () => socket.write(text));
  socket.setEncoding('latin1').on('data', (piece) => { got += piece; }).on('close', () => resolve(got)).on('error', reject);
});

/** What nginx refuses itself is told as hoodoo tells it. */
function isProblem({ status, headers, body }) {
  assert.equal(headers['content-type'], 'application/problem+json');
  const told = JSON.parse(body);
  assert.equal(told.status, status);
  assert.ok(told.detail.length > 10);
}

test('Links are those of the public address, over HTTP/2 too', async () => {
  for (const { href } of (await document('/')).links) assert.ok(href.startsWith(nginx.url), href);
  const session = connectTwo(nginx.url, { ca: nginx.certificate });
  const stream = session.request({ ':path': '/conformance' });
  const status = await new Promise((done, fail) => stream.on('response', (headers) => done(headers[':status'])).on('error', fail));
  stream.resume();
  session.close();
  assert.equal(status, 200);
  const { headers } = await nginx.ask('/viewer/');
  assert.match(headers['strict-transport-security'], /max-age/);
  assert.match(headers['content-security-policy'], /frame-ancestors 'none'/);
  assert.doesNotMatch(headers.server, /\d/, 'no version is told');
});

test('Figures stay within; keys are asked for', async () => {
  const figures = await nginx.ask('/metrics', { headers: { authorization: `Bearer ${key}` } });
  assert.equal(figures.status, 404);
  isProblem(figures);
  assert.equal((await nginx.ask('/healthz')).status, 200);
  assert.equal((await nginx.ask('/jobs')).status, 401);
  assert.equal((await submit({ authorization: 'Bearer hoodoo_wrong' })).status, 401);
});

test('A job runs, and its events come while it does', async () => {
  const answer = await submit();
  assert.equal(answer.status, 201, answer.body);
  assert.ok(answer.headers.location.startsWith(`${nginx.url}/jobs/`));
  job = JSON.parse(answer.body).jobID;
  const seen = [];
  const { headers, body } = await nginx.ask(`/jobs/${job}/events`, { on: () => seen.push(Date.now()) });
  assert.match(headers['content-type'], /^text\/event-stream/);
  assert.match(body.toString(), /"successful"/);
  assert.ok(seen.length > 2, `${seen.length} pieces came`);
});

test('Tiles come from the disk, whole or in part, and only what is a tile', async () => {
  const path = `/jobs/${job}/tiles/`, tileset = await document(`${path}tileset.json`);
  const tile = path + tileset.root.content.uri, direct = await server.fetch(tile);
  const bytes = Buffer.from(await direct.arrayBuffer());
  const { status, headers, body } = await nginx.ask(tile);
  assert.equal(status, 200);
  assert.deepEqual(body, bytes);
  for (const name of ['content-type', 'etag', 'cache-control', 'access-control-allow-origin', 'x-content-type-options']) {
    assert.equal(headers[name], direct.headers.get(name), name);
  }
  assert.equal(headers['x-request-id'], undefined, 'hoodoo was not asked');
  const part = await nginx.ask(tile, { headers: { range: 'bytes=10-19' } });
  assert.equal(part.status, 206);
  assert.deepEqual(part.body, bytes.subarray(10, 20));
  assert.equal((await nginx.ask(tile, { headers: { range: 'bytes=10-19', 'if-range': headers.etag } })).status, 206);
  assert.equal((await nginx.ask(tile, { headers: { range: 'bytes=10-19', 'if-range': '"other"' } })).status, 200);
  const several = await nginx.ask(tile, { headers: { range: 'bytes=0-1,4-5' } });
  assert.deepEqual([several.status, several.headers['content-type']], [200, headers['content-type']]);
  const unchanged = await nginx.ask(tile, { headers: { 'if-none-match': headers.etag } });
  assert.deepEqual([unchanged.status, unchanged.headers.etag, unchanged.headers['access-control-allow-origin']], [304, headers.etag, '*']);
  assert.equal((await nginx.ask(tile, { method: 'HEAD' })).headers['content-length'], `${bytes.length}`);
  const refused = await nginx.ask(tile, { method: 'DELETE' });
  assert.deepEqual([refused.status, refused.headers['content-type']], [405, 'application/problem+json']);
  const preflight = await nginx.ask(tile, { method: 'OPTIONS', headers: { origin: 'https://elsewhere.example', 'access-control-request-headers': 'if-none-match' } });
  assert.equal(preflight.status, 204);
  assert.match(preflight.headers['access-control-allow-headers'], /If-None-Match/);

  const missing = tile.replace(/[0-9a-f]{64}/, '0'.repeat(64));
  const { status: none, headers: told } = await nginx.ask(missing);
  assert.equal(none, 404);
  assert.ok(told['x-request-id'], 'hoodoo was asked');
  for (const other of ['scene.json', '../scene.json', '..%2fscene.json', '%2e%2e/scene.json', '.hidden.glb', 'tiles/..%2f..%2f..%2fjobs.db']) {
    const { status: refused } = await nginx.ask(path + other);
    assert.ok(refused === 404 || refused === 400, `${other}: ${refused}`);
  }
});

test('A link in the place of a tile leads nowhere', async () => {
  const outside = join(work, 'outside.glb'), folder = join(work, 'data', 'jobs', job, 'out', 'aa');
  await mkdir(folder);
  await writeFile(outside, 'secret');
  const linked = `${'a'.repeat(64)}.glb`, real = `${'b'.repeat(64)}.glb`;
  await symlink(outside, join(folder, linked));
  await writeFile(join(folder, real), 'a tile');
  const beside = await nginx.ask(`/jobs/${job}/tiles/aa/${real}`);
  assert.deepEqual([beside.status, beside.body.toString(), beside.headers['x-request-id']], [200, 'a tile', undefined]);
  const followed = await nginx.ask(`/jobs/${job}/tiles/aa/${linked}`);
  assert.ok(followed.status === 404 || followed.status === 403, `${followed.status}`);
  isProblem(followed);
  assert.doesNotMatch(followed.body.toString(), /secret/);
});

test('What is too large, malformed or smuggled ends at nginx', async () => {
  const { port } = new URL(nginx.url), host = `Host: 127.0.0.1:${port}\r\n`;
  const large = await nginx.ask('/processes/echo/execution', { method: 'POST', headers: { 'content-length': 17 * 1024 * 1024 } })
    .catch(({ code }) => ({ status: code }));
  assert.equal(large.status, 413);
  isProblem(large);
  const first = async (text) => (await raw(text)).split('\r\n')[0];
  assert.match(await first(`GET / HTTP/1.1\r\n${host}X: ${'x'.repeat(40_000)}\r\n\r\n`), / 400 /);
  assert.match(await first(`GET /${'x'.repeat(40_000)} HTTP/1.1\r\n${host}\r\n`), / 414 /);
  assert.match(await first(`POST /processes/echo/execution HTTP/1.1\r\n${host}Content-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET /metrics HTTP/1.1\r\n${host}\r\n`), / 400 /);
  assert.match(await first(`GET / HTTP/1.1\r\n${host}Content-Length: -1\r\n\r\n`), / 400 /);
  assert.match(await first('GET / HTTP/1.1\r\n\r\n'), / 400 /);
  const traced = await nginx.ask('/', { method: 'TRACE' });
  assert.equal(traced.status, 405);
  isProblem(traced);
  assert.equal((await nginx.ask('/healthz')).status, 200);
});

test('A client that posts too fast is held back, one that reads is not', async () => {
  const posts = await Promise.all(Array.from({ length: 60 }, () => nginx.ask('/processes/echo/execution', { method: 'POST', body: '{}' })));
  const counted = posts.filter(({ status }) => status === 429).length;
  assert.ok(counted > 20, `${counted} of 60 posts were held back`);
  const held = posts.find(({ status }) => status === 429);
  isProblem(held);
  assert.equal(held.headers['retry-after'], '1');
  const uploads = await Promise.all(Array.from({ length: 120 }, () => nginx.ask('/uploads', { method: 'POST' })));
  assert.ok(uploads.some(({ status }) => status === 429), 'uploads are begun as fast as one likes');
  const reads = await Promise.all(Array.from({ length: 60 }, () => nginx.ask('/conformance')));
  assert.deepEqual(reads.filter(({ status }) => status !== 200), []);
});

test('An address has 64 connections', async () => {
  const { hostname, port } = new URL(nginx.url), host = `Host: 127.0.0.1:${port}\r\n`, sockets = [];
  try {
    // A connection counts while it has a request: these wait for the rest of a body.
    for (let i = 0; i < 64; ++i) {
      const socket = connect({ host: hostname, port, ca: nginx.certificate });
      sockets.push(socket.on('error', () => {}).resume());
      await new Promise((done) => socket.once('secureConnect', done));
      socket.write(`GET / HTTP/1.1\r\n${host}Content-Length: 9\r\n\r\n`);
    }
    const refused = await nginx.ask('/conformance');
    assert.equal(refused.status, 429);
    isProblem(refused);
  } finally {
    for (const socket of sockets) socket.destroy();
  }
  while ((await nginx.ask('/conformance')).status !== 200) await sleep(50);
});

test('An address that asks without end is held back, tiles or not', async () => {
  const host = `Host: 127.0.0.1:${new URL(nginx.url).port}\r\n`;
  const tile = `GET /jobs/${job}/tiles/aa/${'b'.repeat(64)}.glb HTTP/1.1\r\n${host}\r\n`, other = `GET /conformance HTTP/1.1\r\n${host}`;
  // 4,000 requests, as fast as they can be answered: 2,000 may come at once, and 200 more each second.
  const flood = `${tile.repeat(19)}${other}\r\n`.repeat(24) + tile.repeat(19) + `${other}Connection: close\r\n\r\n`;
  const floods = await Promise.all(Array.from({ length: 8 }, () => raw(flood)));
  const answers = floods.flatMap((text) => answersIn(Buffer.from(text, 'latin1')));
  assert.equal(answers.length, 4000);
  const of = (status, kind) => answers.filter((answer, i) => answer.status === status && (i % 20 === 19) === (kind === other));
  for (const kind of [tile, other]) {
    assert.ok(of(200, kind).length > 0 && of(429, kind).length > 0, `${of(200, kind).length} answered, ${of(429, kind).length} held back`);
    assert.equal(of(200, kind).length + of(429, kind).length, kind === tile ? 3800 : 200);
    isProblem(of(429, kind)[0]);
  }
});

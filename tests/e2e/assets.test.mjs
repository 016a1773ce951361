/** Elevations that clients put whole under their SHA-256. In parts: uploads.test.mjs; what becomes of them: assets_use.test.mjs. */
import assert from 'node:assert/strict';
import { randomBytes } from 'node:crypto';
import { readFile } from 'node:fs/promises';
import { connect } from 'node:net';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { makeFolder, removeFolder, synthesize } from './hoodoo.mjs';
import { ask, hash, kept, mebibyte, nameOf, put } from './sending.mjs';
import { Server } from './server.mjs';

let work, data, server, dem;
const start = (name, ...args) => Server.start({ data: join(work, name), args });

before(async () => {
  work = await makeFolder();
  data = join(work, 'data');
  dem = await readFile(await synthesize(join(work, 'dem.tif')));
  server = await start('data', '--asset-space', '64');
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

test('An asset is put, and comes back to the byte; put again it is there already', async () => {
  const name = nameOf(dem), path = `/assets/${name}`;
  assert.equal((await server.fetch(path)).status, 404);
  const made = await put(server, dem);
  assert.equal(made.status, 201, made.text);
  assert.equal(made.headers.location, `${server.url}${path}`);
  assert.deepEqual(JSON.parse(made.text), { id: name, href: `${server.url}${path}`, bytes: dem.length });
  const got = await server.fetch(path);
  assert.ok(dem.equals(Buffer.from(await got.arrayBuffer())));
  assert.equal(got.headers.get('etag'), `"${name}"`);
  assert.match(got.headers.get('cache-control'), /immutable/);
  assert.equal((await put(server, dem)).status, 204);
  assert.deepEqual(await kept(data), { assets: [name], uploads: [] });
});

test('An asset comes in part, as its head alone, or not again', async () => {
  const path = `/assets/${nameOf(dem)}`;
  const part = await server.fetch(path, { headers: { range: 'bytes=4-11' } });
  assert.equal(part.status, 206);
  assert.equal(part.headers.get('content-range'), `bytes 4-11/${dem.length}`);
  assert.deepEqual(Buffer.from(await part.arrayBuffer()), dem.subarray(4, 12));
  assert.equal((await server.fetch(path, { headers: { range: 'bytes=0-1,4-5' } })).status, 416);
  const head = await server.fetch(path, { method: 'HEAD' });
  assert.deepEqual([head.status, head.headers.get('content-length')], [200, String(dem.length)]);
  assert.equal((await server.fetch(path, { headers: { 'if-none-match': head.headers.get('etag') } })).status, 304);
  assert.equal((await server.fetch(`/assets/${nameOf('nothing')}`, { method: 'HEAD' })).status, 404);
});

test('It is told which of some assets are there', async () => {
  await put(server, dem);
  const list = async (query) => (await server.json(`/assets?${query}`)).assets;
  const had = { id: nameOf(dem), href: `${server.url}/assets/${nameOf(dem)}`, bytes: dem.length };
  assert.deepEqual(await list(`id=${nameOf(dem)}`), [had]);
  assert.deepEqual(await list(`id=${nameOf('nothing')},${nameOf(dem)}`), [had]);
  assert.deepEqual(await list(`id=${nameOf('nothing')}&id=${nameOf(dem)}`), [had]);
  assert.deepEqual(await list(`id=${nameOf('nothing')}`), []);
  const many = Array(101).fill(nameOf(dem)).join();
  for (const query of ['', 'id', 'id=', 'id=x', `id=${nameOf(dem)},`, `id=,${nameOf(dem)}`, `id=${nameOf(dem)}&x=1`, 'id=../jobs.db', `id=${many}`]) {
    const response = await server.fetch(`/assets?${query}`);
    assert.equal(response.status, 400, query);
    assert.equal((await response.json()).errors[0].parameter, 'id', query);
  }
});

test('100-continue is answered by 100 for what is wanted, and else without taking the body', async () => {
  const bytes = randomBytes(3 * mebibyte);
  const wanted = await put(server, bytes, { expect: '100-continue' });
  assert.deepEqual([wanted.status, wanted.continued], [201, true], wanted.text);
  const had = await put(server, bytes, { expect: '100-continue' });
  assert.deepEqual([had.status, had.continued], [204, false]);
  const large = await ask(server, 'PUT', `/assets/${nameOf('large')}`, { 'content-length': 65 * mebibyte, expect: '100-continue' });
  assert.deepEqual([large.status, large.continued], [413, false]);
  assert.match(large.text, /67108864 bytes/);
});

test('Another digest is 422 and leaves nothing', async () => {
  const before_ = await kept(data);
  for (const size of [0, 1, 100_000, 5 * mebibyte]) {
    const wrong = await put(server, randomBytes(size), { name: nameOf('other') });
    assert.equal(wrong.status, 422, wrong.text);
    assert.match(wrong.text, new RegExp(`not ${hash('other')}`));
  }
  assert.equal((await server.fetch(`/assets/${nameOf('other')}`)).status, 404);
  assert.deepEqual(await kept(data), before_);
});

test('What is no asset by its name, its length or its form is refused', async () => {
  const bytes = Buffer.from('abc'), before_ = await kept(data);
  const hex = hash(bytes);
  for (const name of [hex, `sha256-${hex}.tif`, `sha256-${hex.toUpperCase()}`, `sha256-${hex.slice(1)}`, `sha512-${hex}`, 'x',
                      `sha256-${hex}%00`, `..%2fassets%2fsha256-${hex}`]) {
    const { status } = await put(server, bytes, { name });
    assert.ok(status === 400 || status === 404, `${name} answers ${status}`);
    assert.equal((await server.raw(`/assets/${name}`)).status, name.includes('%00') ? 400 : 404, name);
  }
  assert.equal((await server.raw('/assets/')).status, 404);
  const status = async (headers) => (await ask(server, 'PUT', `/assets/${nameOf(bytes)}`, headers, bytes)).status;
  assert.equal(await status({ 'transfer-encoding': 'chunked' }), 411);
  assert.equal(await status({ 'content-length': 3, 'content-type': 'multipart/form-data; boundary=x' }), 415);
  assert.equal(await status({ 'content-length': 3, 'content-encoding': 'gzip' }), 415);
  assert.equal(await status({ 'content-length': 3, 'content-range': 'bytes 0-2/9' }), 400);
  assert.equal(await ask(server, 'POST', `/assets/${nameOf(bytes)}`, { 'content-length': 3 }, bytes).then((r) => r.status), 405);
  assert.deepEqual(await kept(data), before_);
  const multipart = { 'content-length': 3, 'content-type': 'multipart/form-data; boundary=x' };
  assert.equal((await ask(server, 'POST', '/processes/echo/execution', multipart, bytes)).status, 415);
});

test('There is room for so many bytes of assets, and no more', async () => {
  const small = await start('small', '--asset-space', '4');
  const bytes = randomBytes(3 * mebibyte), more = randomBytes(2 * mebibyte);
  try {
    assert.equal((await put(small, randomBytes(5 * mebibyte))).status, 413);
    assert.equal((await put(small, bytes)).status, 201);
    const full = await put(small, more);
    assert.equal(full.status, 507, full.text);
    assert.match(full.text, /of 4194304 bytes for assets 3145728 are taken/);
    const tus = { 'tus-resumable': '1.0.0', 'content-length': 0 };
    assert.equal((await ask(small, 'POST', '/uploads', { ...tus, 'upload-length': more.length })).status, 507);
    assert.equal((await ask(small, 'POST', '/uploads', { ...tus, 'upload-length': mebibyte / 2 })).status, 201);
    assert.equal((await put(small, more.subarray(0, mebibyte))).status, 507, 'what an upload is to have is taken');
    assert.equal((await put(small, more.subarray(0, mebibyte / 4))).status, 201);
  } finally {
    await small.stop('SIGKILL');
  }
});

test('What a killed server had under way is gone when the next one starts, and what it had is there', async () => {
  const killed = await start('killed');
  const bytes = randomBytes(2 * mebibyte), { hostname, port } = new URL(killed.url);
  const socket = connect(Number(port), hostname);
  socket.on('error', () => {});
  assert.equal((await put(killed, dem)).status, 201);
  socket.write(`PUT /assets/${nameOf(bytes)} HTTP/1.1\r\nHost: ${hostname}:${port}\r\nContent-Length: ${bytes.length}\r\n\r\n`);
  socket.write(bytes.subarray(0, mebibyte));
  while ((await kept(join(work, 'killed'))).uploads.length === 0) await sleep(10);
  await killed.stop('SIGKILL');
  socket.destroy();
  const next = await start('killed');
  try {
    assert.deepEqual(await kept(join(work, 'killed')), { assets: [nameOf(dem)], uploads: [] });
  } finally {
    await next.stop();
  }
});

test('A body that ends early or comes too slowly is dropped; one that is under way does not keep the server', async () => {
  const bytes = randomBytes(mebibyte), { hostname, port } = new URL(server.url), before_ = await kept(data);
  const begin = (to = server) => {
    const address = new URL(to.url), socket = connect(Number(address.port), address.hostname);
    socket.on('error', () => {});
    socket.write(`PUT /assets/${nameOf(bytes)} HTTP/1.1\r\nHost: ${address.host}\r\nContent-Length: ${bytes.length}\r\n\r\n`);
    return socket;
  };
  const early = begin();
  early.end(bytes.subarray(0, 1000));
  const answer = (await early.setEncoding('utf8').toArray()).join('');
  assert.match(answer, /^HTTP\/1.1 400/);
  const slow = begin(), from = Date.now();
  const timer = setInterval(() => slow.write(bytes.subarray(0, 10)), 500);
  const said = await new Promise((done) => { slow.setEncoding('utf8').once('data', done); });
  clearInterval(timer);
  slow.destroy();
  assert.match(said, /^HTTP\/1.1 408/);
  assert.ok(Date.now() - from > 9000, 'it was given time');
  assert.deepEqual(await kept(data), before_);
  const stopping = await start('stopping'), held = begin(stopping);
  held.write(bytes.subarray(0, 1000));
  while ((await kept(join(work, 'stopping'))).uploads.length === 0) await sleep(10);
  const asked = Date.now(), drip = setInterval(() => held.write(bytes.subarray(0, 5000)), 100);
  const giveUp = setTimeout(() => stopping.child.kill('SIGKILL'), 20_000);
  assert.deepEqual(await stopping.stop(), { code: 0, signal: null });
  clearTimeout(giveUp);
  clearInterval(drip);
  held.destroy();
  assert.ok(Date.now() - asked < 10_000, `it took ${Date.now() - asked} ms`);
});

/**
 * Elevations as clients send them: put whole under their SHA-256, or in parts by tus 1.0, and baked from. HOODOO_FULL_DISK=1 fills a disk,
 * too.
 */
import assert from 'node:assert/strict';
import { createHash, randomBytes } from 'node:crypto';
import { mkdir, readFile, readdir, utimes, writeFile } from 'node:fs/promises';
import { request } from 'node:http';
import { connect } from 'node:net';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { example, hoodoo, makeFolder, removeFolder, run } from './hoodoo.mjs';
import { Server } from './server.mjs';

const mebibyte = 2 ** 20;
const offsetType = 'application/offset+octet-stream';
let work, data, server, dem;

const hash = (bytes, form = 'hex') => createHash('sha256').update(bytes).digest(form);
const nameOf = (bytes) => `sha256-${hash(bytes)}`;
const start = (name, ...args) => Server.start({ data: join(work, name), args });

before(async () => {
  work = await makeFolder();
  data = join(work, 'data');
  const made = await hoodoo(['synthesize', join(work, 'dem.tif')]);
  assert.equal(made.code, 0, made.stderr);
  dem = await readFile(join(work, 'dem.tif'));
  server = await start('data', '--asset-space', '64');
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

/**
 * One request, {status, headers, text, continued}: also an answer that comes before the body was sent, which fetch may not see.
 * Without `body` nothing but the head is sent, whatever Content-Length says.
 */
function ask(to, method, path, headers = {}, body = undefined) {
  return new Promise((resolve, reject) => {
    let answered = false, continued = false;
    const given = Object.fromEntries(Object.entries(headers).filter(([, value]) => value !== undefined));
    const asking = request(new URL(path, to.url), { method, headers: given, agent: false });
    asking.on('continue', () => {
      continued = true;
      asking.end(body);
    });
    asking.on('error', (error) => { if (!answered) reject(error); });
    asking.on('response', async (response) => {
      answered = true;
      const text = (await response.setEncoding('utf8').toArray()).join('');
      asking.destroy();
      resolve({ status: response.statusCode, headers: response.headers, text, continued });
    });
    if (headers.expect) asking.flushHeaders();
    else asking.end(body);
  });
}
const put = (bytes, { name = nameOf(bytes), to = server, ...headers } = {}) =>
  ask(to, 'PUT', `/assets/${name}`, { 'content-length': bytes.length, ...headers }, bytes);
/** Names of all that is kept for assets. */
async function kept(folder = data) {
  return { assets: await readdir(join(folder, 'assets')), uploads: await readdir(join(folder, 'uploads')) };
}

test('An asset is put, and comes back to the byte; put again it is there already', async () => {
  const name = nameOf(dem), path = `/assets/${name}`;
  assert.equal((await server.fetch(path)).status, 404);
  const made = await put(dem);
  assert.equal(made.status, 201, made.text);
  assert.equal(made.headers.location, `${server.url}${path}`);
  assert.deepEqual(JSON.parse(made.text), { id: name, href: `${server.url}${path}`, bytes: dem.length });
  const got = await server.fetch(path);
  assert.deepEqual(Buffer.from(await got.arrayBuffer()), dem);
  assert.equal(got.headers.get('etag'), `"${name}"`);
  assert.match(got.headers.get('cache-control'), /immutable/);
  assert.equal((await put(dem)).status, 204);
  assert.deepEqual(await kept(), { assets: [name], uploads: [] });
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
  await put(dem);
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
    assert.equal((await response.json()).errors[0].pointer, 'id', query);
  }
});

test('100-continue is answered by 100 for what is wanted, and else without taking the body', async () => {
  const bytes = randomBytes(3 * mebibyte);
  const wanted = await put(bytes, { expect: '100-continue' });
  assert.deepEqual([wanted.status, wanted.continued], [201, true], wanted.text);
  const had = await put(bytes, { expect: '100-continue' });
  assert.deepEqual([had.status, had.continued], [204, false]);
  const large = await ask(server, 'PUT', `/assets/${nameOf('large')}`, { 'content-length': 65 * mebibyte, expect: '100-continue' });
  assert.deepEqual([large.status, large.continued], [413, false]);
  assert.match(large.text, /67108864 bytes/);
});

test('Another digest is 422 and leaves nothing', async () => {
  const before_ = await kept();
  for (const size of [0, 1, 100_000, 5 * mebibyte]) {
    const wrong = await put(randomBytes(size), { name: nameOf('other') });
    assert.equal(wrong.status, 422, wrong.text);
    assert.match(wrong.text, new RegExp(`not ${hash('other')}`));
  }
  assert.equal((await server.fetch(`/assets/${nameOf('other')}`)).status, 404);
  assert.deepEqual(await kept(), before_);
});

test('What is no asset by its name, its length or its form is refused', async () => {
  const bytes = Buffer.from('abc'), before_ = await kept();
  const hex = hash(bytes);
  for (const name of [hex, `sha256-${hex}.tif`, `sha256-${hex.toUpperCase()}`, `sha256-${hex.slice(1)}`, `sha512-${hex}`, 'x',
                      `sha256-${hex}%00`, `..%2fassets%2fsha256-${hex}`]) {
    const { status } = await put(bytes, { name });
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
  assert.deepEqual(await kept(), before_);
  const multipart = { 'content-length': 3, 'content-type': 'multipart/form-data; boundary=x' };
  assert.equal((await ask(server, 'POST', '/processes/echo/execution', multipart, bytes)).status, 415);
});

test('There is room for so many bytes of assets, and no more', async () => {
  const small = await start('small', '--asset-space', '4');
  const bytes = randomBytes(3 * mebibyte), more = randomBytes(2 * mebibyte);
  try {
    assert.equal((await put(randomBytes(5 * mebibyte), { to: small })).status, 413);
    assert.equal((await put(bytes, { to: small })).status, 201);
    const full = await put(more, { to: small });
    assert.equal(full.status, 507, full.text);
    assert.match(full.text, /of 4194304 bytes for assets 3145728 are taken/);
    const tus = { 'tus-resumable': '1.0.0', 'content-length': 0 };
    assert.equal((await ask(small, 'POST', '/uploads', { ...tus, 'upload-length': more.length })).status, 507);
    assert.equal((await ask(small, 'POST', '/uploads', { ...tus, 'upload-length': mebibyte / 2 })).status, 201);
    assert.equal((await put(more.subarray(0, mebibyte), { to: small })).status, 507, 'what an upload is to have is taken');
    assert.equal((await put(more.subarray(0, mebibyte / 4), { to: small })).status, 201);
  } finally {
    await small.stop('SIGKILL');
  }
});

test('What a killed server had under way is gone when the next one starts, and what it had is there', async () => {
  const killed = await start('killed');
  const bytes = randomBytes(2 * mebibyte), { hostname, port } = new URL(killed.url);
  const socket = connect(Number(port), hostname);
  socket.on('error', () => {});
  assert.equal((await put(dem, { to: killed })).status, 201);
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
  const bytes = randomBytes(mebibyte), { hostname, port } = new URL(server.url), before_ = await kept();
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
  assert.deepEqual(await kept(), before_);
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

// --- resumable uploads

const tus = { 'tus-resumable': '1.0.0' };
const metadata = (bytes) => `filename ${btoa('dem.tif')},sha256 ${btoa(hash(bytes))}`;
/** The path of a new upload. */
async function create(bytes, headers = { 'upload-metadata': metadata(bytes) }, to = server) {
  const made = await ask(to, 'POST', '/uploads', { ...tus, 'upload-length': bytes.length, 'content-length': 0, ...headers });
  assert.equal(made.status, 201, made.text);
  assert.ok(made.headers.location.startsWith(`${to.url}/uploads/`));
  return made.headers.location.slice(to.url.length);
}
const patch = (path, offset, bytes, headers = {}, to = server) =>
  ask(to, 'PATCH', path, { ...tus, 'content-type': offsetType, 'upload-offset': offset, 'content-length': bytes.length, ...headers }, bytes);
const offsetOf = async (path, to = server) => {
  const { status, headers } = await ask(to, 'HEAD', path, tus);
  assert.equal(status, 200);
  assert.equal(headers['cache-control'], 'no-store');
  return Number(headers['upload-offset']);
};

test('OPTIONS tells what of tus there is', async () => {
  const { status, headers } = await ask(server, 'OPTIONS', '/uploads');
  assert.equal(status, 204);
  assert.equal(headers['tus-version'], '1.0.0');
  assert.deepEqual(headers['tus-extension'].split(',').sort(), ['checksum', 'creation', 'expiration', 'termination']);
  assert.equal(headers['tus-max-size'], String(64 * mebibyte));
  assert.equal(headers['tus-checksum-algorithm'], 'sha256');
});

test('An upload in parts becomes an asset', async () => {
  const bytes = randomBytes(3 * mebibyte + 7), half = mebibyte + 3;
  const path = await create(bytes);
  assert.equal(await offsetOf(path), 0);
  const first = await patch(path, 0, bytes.subarray(0, half));
  assert.deepEqual([first.status, first.headers['upload-offset'], first.headers['tus-resumable']], [204, String(half), '1.0.0']);
  assert.ok(Date.parse(first.headers['upload-expires']) > Date.now() + 3600e3);
  assert.equal(first.headers.link, undefined);
  assert.equal((await server.fetch(`/assets/${nameOf(bytes)}`)).status, 404);
  for (const wrong of [0, half - 1, half + 1]) {
    const { status, headers } = await patch(path, wrong, bytes.subarray(half));
    assert.deepEqual([status, headers['upload-offset']], [409, String(half)]);
  }
  const last = await patch(path, half, bytes.subarray(half), { expect: '100-continue' });
  assert.deepEqual([last.status, last.continued], [204, true]);
  assert.equal(last.headers.link, `<${server.url}/assets/${nameOf(bytes)}>; rel="canonical"`);
  assert.deepEqual(Buffer.from(await (await server.fetch(`/assets/${nameOf(bytes)}`)).arrayBuffer()), bytes);
  assert.equal(await offsetOf(path), bytes.length, 'who missed the last answer learns of it');
  assert.equal((await patch(path, 0, bytes)).status, 409);
  assert.equal((await ask(server, 'DELETE', path, tus)).status, 204);
  assert.equal((await ask(server, 'HEAD', path, tus)).status, 404);
  assert.equal((await server.fetch(`/assets/${nameOf(bytes)}`, { method: 'HEAD' })).status, 200);
});

test('An upload needs no digest beforehand, and may be empty', async () => {
  const bytes = randomBytes(1000), path = await create(bytes, {});
  const { headers } = await patch(path, 0, bytes);
  assert.ok(headers.link.includes(`/assets/${nameOf(bytes)}>`));
  assert.equal(await offsetOf(await create(Buffer.alloc(0))), 0);
  assert.equal((await server.fetch(`/assets/${nameOf('')}`, { method: 'HEAD' })).headers.get('content-length'), '0');
});

test('An upload of another digest is 422 and leaves nothing', async () => {
  const bytes = randomBytes(100_000), before_ = await kept();
  const path = await create(bytes, { 'upload-metadata': metadata('other') });
  assert.equal((await patch(path, 0, bytes.subarray(0, 5000))).status, 204);
  assert.equal((await patch(path, 5000, bytes.subarray(5000))).status, 422);
  assert.equal((await ask(server, 'HEAD', path, tus)).status, 404);
  assert.deepEqual(await kept(), before_);
});

test('A part of another checksum is 460 and taken back', async () => {
  const bytes = randomBytes(200_000), path = await create(bytes), half = 90_000;
  const checked = (part) => ({ 'upload-checksum': `sha256 ${hash(part, 'base64')}` });
  const [one, two] = [bytes.subarray(0, half), bytes.subarray(half)];
  assert.equal((await patch(path, 0, one, checked(two))).status, 460);
  assert.equal(await offsetOf(path), 0);
  assert.equal((await patch(path, 0, one, checked(one))).status, 204);
  assert.equal((await patch(path, half, two, checked(one))).status, 460);
  assert.equal(await offsetOf(path), half);
  for (const wrong of ['md5 AAAA', 'sha256 AAAA', 'sha256', 'sha256 !']) {
    assert.equal((await patch(path, half, two, { 'upload-checksum': wrong })).status, 400, wrong);
  }
  const last = await patch(path, half, two, checked(two));
  assert.equal(last.status, 204, last.text);
  assert.ok(last.headers.link.includes(nameOf(bytes)));
});

test('What is no upload of tus 1.0 is refused', async () => {
  const bytes = randomBytes(100), path = await create(bytes);
  const old = await ask(server, 'HEAD', path, {});
  assert.deepEqual([old.status, old.headers['tus-version']], [412, '1.0.0']);
  assert.equal((await ask(server, 'POST', '/uploads', { 'upload-length': 5, 'content-length': 0 })).status, 412);
  const post = async (headers, body) => (await ask(server, 'POST', '/uploads', { ...tus, 'content-length': 0, ...headers }, body)).status;
  for (const length of ['-1', 'x', '', '5.5', '9'.repeat(30)]) assert.equal(await post({ 'upload-length': length }), 400, length);
  assert.equal(await post({ 'upload-defer-length': 1 }), 400);
  assert.equal(await post({ 'upload-length': 65 * mebibyte }), 413);
  assert.equal(await post({ 'upload-length': 3, 'content-length': 3 }, 'abc'), 400);
  for (const text of ['sha256', 'sha256 AAAA', 'sha256 !', `sha256 ${btoa('x'.repeat(64))}`, 'a b c', ',']) {
    assert.equal(await post({ 'upload-length': 5, 'upload-metadata': text }), 400, text);
  }
  assert.equal((await patch(path, 0, bytes, { 'content-type': 'application/octet-stream' })).status, 415);
  assert.equal((await patch(path, 'x', bytes)).status, 400);
  assert.equal((await patch(path, 0, randomBytes(101))).status, 413);
  assert.equal((await patch(path, 0, bytes, { 'content-length': undefined, 'transfer-encoding': 'chunked' })).status, 411);
  assert.equal((await patch(`/uploads/${'0'.repeat(32)}`, 0, bytes)).status, 404);
  assert.equal((await ask(server, 'GET', path, tus)).status, 405);
  const overridden = await ask(server, 'POST', path, { ...tus, 'x-http-method-override': 'PATCH', 'content-type': offsetType,
                                                       'upload-offset': 0, 'content-length': bytes.length }, bytes);
  assert.equal(overridden.status, 204, overridden.text);
});

test('One request at a time adds to an upload', async () => {
  const bytes = randomBytes(mebibyte), path = await create(bytes), { hostname, port, host } = new URL(server.url);
  const socket = connect(Number(port), hostname);
  socket.write(`PATCH ${path} HTTP/1.1\r\nHost: ${host}\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: 0\r\nContent-Type: ${offsetType}\r\n` +
               `Content-Length: ${bytes.length}\r\n\r\n`);
  socket.write(bytes.subarray(0, 1000));
  while (await offsetOf(path) < 1000) await sleep(10);
  assert.equal((await patch(path, 1000, bytes.subarray(1000))).status, 423);
  assert.equal((await ask(server, 'DELETE', path, tus)).status, 423);
  socket.destroy();
  let answer;
  while ((answer = await patch(path, 1000, bytes.subarray(1000))).status === 423) await sleep(20);
  assert.equal(answer.status, 204, answer.text);
  assert.ok(answer.headers.link.includes(nameOf(bytes)));
});

/** Sends what is left of an upload, `pace` bytes at a time, until `over()`; the connection may break at any moment. */
function sendSlowly(to, path, bytes, offset, pace, over) {
  const { hostname, port, host } = new URL(to.url);
  return new Promise((resolve) => {
    const socket = connect(Number(port), hostname);
    let answer = '', at = offset;
    socket.on('error', () => {}).on('close', () => resolve(answer));
    socket.setEncoding('utf8').on('data', (text) => { answer += text; socket.end(); });
    socket.write(`PATCH ${path} HTTP/1.1\r\nHost: ${host}\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: ${offset}\r\n` +
                 `Content-Type: ${offsetType}\r\nContent-Length: ${bytes.length - offset}\r\n\r\n`);
    const timer = setInterval(() => {
      if (over()) socket.destroy();
      if (at >= bytes.length || socket.destroyed) return clearInterval(timer);
      socket.write(bytes.subarray(at, at + pace));
      at += pace;
    }, 2);
  });
}

test('An upload goes on after broken connections and killed servers, to the same bytes', async () => {
  let to = await start('resumed');
  try {
    const bytes = randomBytes(12 * mebibyte), path = await create(bytes, undefined, to);
    const reached = [];
    for (let round = 0; round < 6; ++round) {
      const offset = await offsetOf(path, to), from = Date.now();
      assert.ok(offset >= (reached.at(-1) ?? 0), 'what was there stays');
      reached.push(offset);
      const sending = sendSlowly(to, path, bytes, offset, 64 << 10, () => round % 2 === 0 && Date.now() - from > 60);
      if (round % 2 === 1) {
        await sleep(60);
        await to.stop('SIGKILL');
      }
      await sending;
      if (round % 2 === 1) to = await start('resumed');
    }
    assert.ok(reached.at(-1) > 0 && reached.at(-1) < bytes.length, reached.join());
    let last;
    do {
      const offset = await offsetOf(path, to);
      last = await patch(path, offset, bytes.subarray(offset), {}, to);
    } while (last.status === 423 || last.status === 409);
    assert.equal(last.status, 204, last.text);
    assert.deepEqual(Buffer.from(await (await to.fetch(`/assets/${nameOf(bytes)}`)).arrayBuffer()), bytes);
    assert.deepEqual((await kept(join(work, 'resumed'))).assets, [nameOf(bytes)]);
  } finally {
    await to.stop('SIGKILL');
  }
});

test('An upload whose server was killed when all had come is finished by the next', async () => {
  let to = await start('finished');
  try {
    const bytes = randomBytes(50_000), path = await create(bytes, undefined, to);
    assert.equal((await patch(path, 0, bytes.subarray(0, 100), {}, to)).status, 204);
    await to.stop('SIGKILL');
    await writeFile(join(work, 'finished/uploads', `${path.split('/').at(-1)}.data`), bytes);
    to = await start('finished');
    const { headers } = await ask(to, 'HEAD', path, tus);
    assert.equal(headers['upload-offset'], String(bytes.length));
    assert.ok(headers.link.includes(nameOf(bytes)));
    assert.equal((await to.fetch(`/assets/${nameOf(bytes)}`, { method: 'HEAD' })).status, 200);
  } finally {
    await to.stop('SIGKILL');
  }
});

test('Uploads that nothing is added to expire, and leave nothing', async () => {
  let to = await start('expiring', '--upload-seconds', '2');
  try {
    const bytes = randomBytes(50_000), path = await create(bytes, undefined, to), done = await create(bytes, undefined, to);
    await patch(path, 0, bytes.subarray(0, 100), {}, to);
    assert.equal((await patch(done, 0, bytes, {}, to)).status, 204);
    await sleep(3500);
    for (const one of [path, done]) assert.equal((await ask(to, 'HEAD', one, tus)).status, 404);
    assert.deepEqual(await kept(join(work, 'expiring')), { assets: [nameOf(bytes)], uploads: [] });
    const left = await create(bytes, undefined, to), id = left.split('/').at(-1);
    await to.stop('SIGKILL');
    await utimes(join(work, 'expiring/uploads', `${id}.data`), 0, 0);
    to = await start('expiring');
    assert.deepEqual((await kept(join(work, 'expiring'))).uploads, []);
  } finally {
    await to.stop('SIGKILL');
  }
});

test('With keys, assets are read with one and sent with another', async () => {
  const keys = {};
  for (const [name, scopes] of [['artist', 'submit'], ['other', 'submit'], ['monitor', 'read']]) {
    const { code, stdout, stderr } = await hoodoo(['key', join(work, 'keys.json'), name, '--scopes', scopes]);
    assert.equal(code, 0, stderr);
    keys[name] = { authorization: `Bearer ${stdout.trim()}` };
  }
  const to = await start('keys', '--keys', join(work, 'keys.json')), path = `/assets/${nameOf(dem)}`;
  try {
    const sent = async (who) => (await put(dem, { to, expect: '100-continue', ...keys[who] })).status;
    assert.deepEqual([await sent('nobody'), await sent('monitor'), await sent('artist')], [401, 403, 201]);
    const got = async (who) => (await to.fetch(path, { headers: keys[who] ?? {} })).status;
    assert.deepEqual([await got('nobody'), await got('artist'), await got('monitor')], [401, 403, 200]);
    assert.match((await to.fetch(path, { headers: keys.monitor })).headers.get('cache-control'), /^private/);
    const made = async (who) => (await ask(to, 'POST', '/uploads', { ...tus, 'upload-length': 3, 'content-length': 0, ...keys[who] })).status;
    assert.deepEqual([await made('nobody'), await made('monitor')], [401, 403]);
    const upload = await create(Buffer.from('abc'), keys.artist, to);
    assert.equal((await patch(upload, 0, Buffer.from('abc'), {}, to)).status, 401);
    assert.equal((await patch(upload, 0, Buffer.from('abc'), keys.other, to)).status, 403);
    assert.equal((await ask(to, 'DELETE', upload, { ...tus, ...keys.other })).status, 403);
    assert.equal((await patch(upload, 0, Buffer.from('abc'), keys.artist, to)).status, 204);
  } finally {
    await to.stop('SIGKILL');
  }
});

test('A scene is baked from an asset that was sent, and an elevation model analyzed', async () => {
  const scene = JSON.parse(await readFile(join(example, 'scene.json'), 'utf8'));
  const name = nameOf(dem);
  const named = { ...scene, bake: { ...scene.bake, spacing: 8 }, terrains: scene.terrains.map((one) => ({ ...one, dem: name })) };
  assert.equal((await put(dem)).status < 300, true);
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
  const bytes = Buffer.from(dem), path = await create(bytes);
  assert.equal((await patch(path, 0, bytes.subarray(0, 1000))).status, 204);
  const id = path.split('/').at(-1);
  for (const name of [`${id}.data`, `../uploads/${id}.data`, `${id}.json`, '../jobs.db']) {
    assert.equal((await server.post({ hoodoo: 1, terrains: [{ dem: name }] })).status, 422, name);
    assert.equal((await server.raw(`/assets/${name}`)).status, 404);
  }
  assert.equal((await ask(server, 'DELETE', path, tus)).status, 204);
});

test('A disk without room is 507, before the body is sent, and while it is', async (t) => {
  if (!process.env.HOODOO_FULL_DISK) return t.skip('set HOODOO_FULL_DISK=1');
  const disk = join(work, 'disk');
  await mkdir(disk);
  const mounted = await run('mount', ['-t', 'tmpfs', '-o', `size=${96 * mebibyte}`, 'none', disk]);
  if (mounted.code !== 0) return t.skip(`nothing may be mounted here: ${mounted.stderr.trim()}`);
  let to;
  try {
    to = await start('disk');
    const bytes = randomBytes(40 * mebibyte), small = randomBytes(8 * mebibyte);
    for (const expect of [{}, { expect: '100-continue' }]) {
      const full = await put(bytes, { to, ...expect });
      assert.deepEqual([full.status, full.continued], [507, false], full.text);
    }
    assert.equal((await put(small, { to })).status, 201);
    assert.equal((await ask(to, 'POST', '/uploads', { ...tus, 'upload-length': bytes.length, 'content-length': 0 })).status, 507);
    // One that began while there was room, on a disk that fills meanwhile.
    const later = randomBytes(16 * mebibyte), path = await create(later, undefined, to), half = 4 * mebibyte;
    assert.equal((await patch(path, 0, later.subarray(0, half), {}, to)).status, 204);
    await run('fallocate', ['-l', String(78 * mebibyte), join(disk, 'other')]);
    const failed = await patch(path, half, later.subarray(half), {}, to);
    assert.equal(failed.status, 507, failed.text);
    assert.match(failed.text, /No space left/);
    assert.equal(await offsetOf(path, to), half);
    await run('rm', [join(disk, 'other')]);
    assert.equal((await patch(path, half, later.subarray(half), {}, to)).status, 204);
    assert.deepEqual((await kept(disk)).assets.sort(), [nameOf(small), nameOf(later)].sort());
  } finally {
    await to?.stop('SIGKILL');
    await run('umount', [disk]);
  }
});

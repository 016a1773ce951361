/** Elevations that clients send in parts, by tus 1.0. */
import assert from 'node:assert/strict';
import { randomBytes } from 'node:crypto';
import { utimes, writeFile } from 'node:fs/promises';
import { connect } from 'node:net';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { makeFolder, removeFolder } from './hoodoo.mjs';
import { ask, create, hash, kept, mebibyte, metadata, nameOf, offsetOf, offsetType, patch, tus } from './sending.mjs';
import { Server } from './server.mjs';

let work, data, server;
const start = (name, ...args) => Server.start({ data: join(work, name), args });

before(async () => {
  work = await makeFolder();
  data = join(work, 'data');
  server = await start('data', '--asset-space', '64');
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

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
  const path = await create(server, bytes);
  assert.equal(await offsetOf(server, path), 0);
  const first = await patch(server, path, 0, bytes.subarray(0, half));
  assert.deepEqual([first.status, first.headers['upload-offset'], first.headers['tus-resumable']], [204, String(half), '1.0.0']);
  assert.ok(Date.parse(first.headers['upload-expires']) > Date.now() + 3600e3);
  assert.equal(first.headers.link, undefined);
  assert.equal((await server.fetch(`/assets/${nameOf(bytes)}`)).status, 404);
  for (const wrong of [0, half - 1, half + 1]) {
    const { status, headers } = await patch(server, path, wrong, bytes.subarray(half));
    assert.deepEqual([status, headers['upload-offset']], [409, String(half)]);
  }
  const last = await patch(server, path, half, bytes.subarray(half), { expect: '100-continue' });
  assert.deepEqual([last.status, last.continued], [204, true]);
  assert.equal(last.headers.link, `<${server.url}/assets/${nameOf(bytes)}>; rel="canonical"`);
  assert.ok(Buffer.from(await (await server.fetch(`/assets/${nameOf(bytes)}`)).arrayBuffer()).equals(bytes));
  assert.equal(await offsetOf(server, path), bytes.length, 'who missed the last answer learns of it');
  assert.equal((await patch(server, path, 0, bytes)).status, 409);
  assert.equal((await ask(server, 'DELETE', path, tus)).status, 204);
  assert.equal((await ask(server, 'HEAD', path, tus)).status, 404);
  assert.equal((await server.fetch(`/assets/${nameOf(bytes)}`, { method: 'HEAD' })).status, 200);
});

test('An upload needs no digest beforehand, and may be empty', async () => {
  const bytes = randomBytes(1000), path = await create(server, bytes, {});
  const { headers } = await patch(server, path, 0, bytes);
  assert.ok(headers.link.includes(`/assets/${nameOf(bytes)}>`));
  assert.equal(await offsetOf(server, await create(server, Buffer.alloc(0))), 0);
  assert.equal((await server.fetch(`/assets/${nameOf('')}`, { method: 'HEAD' })).headers.get('content-length'), '0');
});

test('An upload of another digest is 422 and leaves nothing', async () => {
  const bytes = randomBytes(100_000), before_ = await kept(data);
  const path = await create(server, bytes, { 'upload-metadata': metadata('other') });
  assert.equal((await patch(server, path, 0, bytes.subarray(0, 5000))).status, 204);
  assert.equal((await patch(server, path, 5000, bytes.subarray(5000))).status, 422);
  assert.equal((await ask(server, 'HEAD', path, tus)).status, 404);
  assert.deepEqual(await kept(data), before_);
});

test('A part of another checksum is 460 and taken back', async () => {
  const bytes = randomBytes(200_000), path = await create(server, bytes), half = 90_000;
  const checked = (part) => ({ 'upload-checksum': `sha256 ${hash(part, 'base64')}` });
  const [one, two] = [bytes.subarray(0, half), bytes.subarray(half)];
  assert.equal((await patch(server, path, 0, one, checked(two))).status, 460);
  assert.equal(await offsetOf(server, path), 0);
  assert.equal((await patch(server, path, 0, one, checked(one))).status, 204);
  assert.equal((await patch(server, path, half, two, checked(one))).status, 460);
  assert.equal(await offsetOf(server, path), half);
  for (const wrong of ['md5 AAAA', 'sha256 AAAA', 'sha256', 'sha256 !']) {
    assert.equal((await patch(server, path, half, two, { 'upload-checksum': wrong })).status, 400, wrong);
  }
  const last = await patch(server, path, half, two, checked(two));
  assert.equal(last.status, 204, last.text);
  assert.ok(last.headers.link.includes(nameOf(bytes)));
});

test('What is no upload of tus 1.0 is refused', async () => {
  const bytes = randomBytes(100), path = await create(server, bytes);
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
  assert.equal((await patch(server, path, 0, bytes, { 'content-type': 'application/octet-stream' })).status, 415);
  assert.equal((await patch(server, path, 'x', bytes)).status, 400);
  assert.equal((await patch(server, path, 0, randomBytes(101))).status, 413);
  assert.equal((await patch(server, path, 0, bytes, { 'content-length': undefined, 'transfer-encoding': 'chunked' })).status, 411);
  assert.equal((await patch(server, `/uploads/${'0'.repeat(32)}`, 0, bytes)).status, 404);
  assert.equal((await ask(server, 'GET', path, tus)).status, 405);
  const overridden = await ask(server, 'POST', path, { ...tus, 'x-http-method-override': 'PATCH', 'content-type': offsetType,
                                                       'upload-offset': 0, 'content-length': bytes.length }, bytes);
  assert.equal(overridden.status, 204, overridden.text);
});

test('One request at a time adds to an upload', async () => {
  const bytes = randomBytes(mebibyte), path = await create(server, bytes), { hostname, port, host } = new URL(server.url);
  const socket = connect(Number(port), hostname);
  socket.write(`PATCH ${path} HTTP/1.1\r\nHost: ${host}\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: 0\r\nContent-Type: ${offsetType}\r\n` +
               `Content-Length: ${bytes.length}\r\n\r\n`);
  socket.write(bytes.subarray(0, 1000));
  while (await offsetOf(server, path) < 1000) await sleep(10);
  assert.equal((await patch(server, path, 1000, bytes.subarray(1000))).status, 423);
  assert.equal((await ask(server, 'DELETE', path, tus)).status, 423);
  socket.destroy();
  let answer;
  while ((answer = await patch(server, path, 1000, bytes.subarray(1000))).status === 423) await sleep(20);
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
    const bytes = randomBytes(12 * mebibyte), path = await create(to, bytes);
    const reached = [];
    for (let round = 0; round < 6; ++round) {
      const offset = await offsetOf(to, path), from = Date.now();
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
      const offset = await offsetOf(to, path);
      last = await patch(to, path, offset, bytes.subarray(offset));
    } while (last.status === 423 || last.status === 409);
    assert.equal(last.status, 204, last.text);
    assert.ok(Buffer.from(await (await to.fetch(`/assets/${nameOf(bytes)}`)).arrayBuffer()).equals(bytes));
    assert.deepEqual((await kept(join(work, 'resumed'))).assets, [nameOf(bytes)]);
  } finally {
    await to.stop('SIGKILL');
  }
});

test('An upload whose server was killed when all had come is finished by the next', async () => {
  let to = await start('finished');
  try {
    const bytes = randomBytes(50_000), path = await create(to, bytes);
    assert.equal((await patch(to, path, 0, bytes.subarray(0, 100))).status, 204);
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
    const bytes = randomBytes(50_000), path = await create(to, bytes), done = await create(to, bytes);
    await patch(to, path, 0, bytes.subarray(0, 100));
    assert.equal((await patch(to, done, 0, bytes)).status, 204);
    await sleep(3500);
    for (const one of [path, done]) assert.equal((await ask(to, 'HEAD', one, tus)).status, 404);
    assert.deepEqual(await kept(join(work, 'expiring')), { assets: [nameOf(bytes)], uploads: [] });
    const left = await create(to, bytes), id = left.split('/').at(-1);
    await to.stop('SIGKILL');
    await utimes(join(work, 'expiring/uploads', `${id}.data`), 0, 0);
    to = await start('expiring');
    assert.deepEqual((await kept(join(work, 'expiring'))).uploads, []);
  } finally {
    await to.stop('SIGKILL');
  }
});

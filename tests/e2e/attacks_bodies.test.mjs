/**
 * Bodies as an attacker sends them: endless, packed, nested, slow. Each is refused with its status, the server stays small and goes on.
 * Heads: attacks_heads.test.mjs; the digest, length and disk of assets: assets.test.mjs.
 */
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { brotliCompressSync, deflateSync, gzipSync } from 'node:zlib';
import { makeFolder, removeFolder } from './hoodoo.mjs';
import { Memory, assertDiscreet, assertWell, converse, times } from './raw.mjs';
import { Server } from './server.mjs';

const execution = (process = 'echo') => `/processes/${process}/execution`;
const anAsset = `/assets/sha256-${'0'.repeat(64)}`;
let work, server, memory, host;

before(async () => {
  work = await makeFolder();
  server = await Server.start({ data: join(work, 'data') });
  host = `Host: ${new URL(server.url).host}\r\n`;
  for (let i = 0; i < 20; ++i) await (await server.fetch('/api')).text();
  memory = new Memory(server.child.pid);
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

const head = (line, lines = '', version = '1.1') => `${line} HTTP/${version}\r\n${host}Content-Type: application/json\r\n${lines}\r\n`;
const post = (lines = '', version = '1.1') => head(`POST ${execution()}`, lines, version);
const sized = (body) => `Content-Length: ${Buffer.byteLength(body, 'latin1')}\r\n`;

/** The only answer, of this status; the connection has ended. */
async function refused(parts, status, options) {
  const { answers, closed, seconds, sent } = await converse(server.url, parts, { patience: 60, ...options });
  const shown = JSON.stringify(answers).slice(0, 500);
  assert.deepEqual(answers.map((one) => one.status), [status], shown);
  assert.ok(closed);
  assertDiscreet(answers[0]);
  await assertWell(server, memory);
  return { seconds, sent, answer: answers[0] };
}

const chunked = 'Transfer-Encoding: chunked\r\n', chunk = `100000\r\n${'x'.repeat(0x100000)}\r\n`;

test('Chunks of 300 MB are cut off: 413, 411 where a length must be said', async () => {
  const body = function* (first) {
    yield first;
    yield* times(300, chunk);
  };
  await refused(body(post(chunked)), 413);
  await refused(body(head(`PUT ${anAsset}`, chunked)), 411);
  await refused(body(head('PATCH /uploads/0', `${chunked}Tus-Resumable: 1.0.0\r\n`)), 404);
  await refused(body(head('POST /uploads', `${chunked}Tus-Resumable: 1.0.0\r\nUpload-Length: 3\r\n`)), 400);
  await refused(body(head('POST /nothing', chunked)), 413);
});

test('A length of 300 MB is refused before it comes: 413', async () => {
  // Side by side: each waits for more of its body before it ends.
  const paths = [execution(), '/nothing', '/a%20b', '/%c3%a9', `/${'x'.repeat(2000)}`].map((path) => [path, 300e6]);
  const lengths = [2 ** 31, 2 ** 40, 2 ** 62].map((length) => [execution(), length]);
  await Promise.all([...paths, ...lengths].map(([path, length]) => refused(
    [head(`POST ${path}`, `Content-Length: ${length}\r\n`), ...times(20, 'x'.repeat(1e6))], 413)));
  await refused(head(`PUT ${anAsset}`, `Content-Length: ${2 ** 50}\r\n`), 413, { end: true });
});

test('A body without a length in HTTP/1.0: 411', async () => {
  await refused([post('', '1.0'), ...times(100, 'x'.repeat(1e6))], 411);
});

test('Chunks whose sizes are none: 400', async () => {
  const sizes = ['-1', '-2', '-fffffffffffffffb', '+5', '0x5', ' 5', '5 ', '', 'g', '5;name=value', ';', 'ffffffffffffffff', 'fffffffffffffffe', '7fffffffffffffff', '100000000',
                 '0'.repeat(20) + '5', 'x'.repeat(100_000), '5\n', '5\r'];
  for (const size of sizes) {
    const { answer } = await refused(`${post(chunked)}${size}\r\nhello\r\n0\r\n\r\n`, 400, { end: true });
    assert.match(answer.body, /did not come whole|understood/, size);
  }
  for (const rest of ['5\r\nhello0\r\n\r\n', '5\r\nhello\n0\r\n\r\n', '5\r\nhelloworld\r\n0\r\n\r\n', '0\r\nX: trailer\r\n\r\n', '0\r\nContent-Length: 5\r\n\r\n']) {
    await refused(post(chunked) + rest, 400, { end: true });
  }
});

test('Packed bodies are not unpacked: 415', async () => {
  const bomb = Buffer.alloc(100e6, ' ');
  for (const [coding, packed] of [['gzip', gzipSync(bomb, { level: 1 })], ['deflate', deflateSync(bomb, { level: 1 })], ['br', brotliCompressSync(bomb.subarray(0, 20e6), { params: { 1: 1 } })],
                                  ['zstd', bomb.subarray(0, 1000)], ['identity', Buffer.from('{}')], ['gzip, gzip', Buffer.from('{}')], ['x', Buffer.from('{}')]]) {
    for (const path of [`POST ${execution()}`, `PUT ${anAsset}`, 'DELETE /jobs/0']) {
      await refused([head(path, `Content-Encoding: ${coding}\r\nContent-Length: ${packed.length}\r\n`), packed], 415);
    }
  }
});

test('Forms are not taken apart: 415', async () => {
  const part = '--x\r\nContent-Disposition: form-data; name="a"; filename="b"\r\n\r\nc\r\n';
  const bodies = [part.repeat(5000) + '--x--\r\n', `--x\r\nContent-Disposition: form-data; name="a"; filename="${'b'.repeat(1e6)}"\r\n\r\n`, '--x'.repeat(10_000)];
  for (const body of bodies) {
    for (const path of [`POST ${execution()}`, `PUT ${anAsset}`]) {
      await refused(`${path} HTTP/1.1\r\n${host}Content-Type: multipart/form-data; boundary=x\r\n${sized(body)}\r\n${body}`, 415);
    }
  }
  const form = 'a=b&'.repeat(100_000);
  await refused(`POST ${execution()} HTTP/1.1\r\n${host}Content-Type: application/x-www-form-urlencoded\r\n${sized(form)}\r\n${form}`, 415);
});

const nested = (open, close, depth) => open.repeat(depth) + close.repeat(depth);
const inputs = (text) => `{"inputs":{"echo":${text}}}`;
/** what: [status, body]. */
const documents = {
  '100,000 open brackets': [413, '['.repeat(100_000)],
  '4 million open brackets': [413, '['.repeat(4_000_000)],
  '100,000 nested arrays': [413, nested('[', ']', 100_000)],
  '500,000 nested objects': [413, nested('{"a":', '}', 500_000)],
  'Arrays and objects in turn': [413, '[{"a":'.repeat(100_000)],
  'Nested one level too deep': [413, inputs(nested('[', ']', 63))],
  '1,900,000 values': [413, inputs(`[${'0,'.repeat(1_900_000)}0]`)],
  '900,000 empty objects': [413, inputs(`[${'{},'.repeat(900_000)}0]`)],
  '900,000 empty texts': [413, inputs(`[${'"",'.repeat(900_000)}0]`)],
  '400,000 members': [413, inputs(`{${Array.from({ length: 400_000 }, (_, i) => `"${i.toString(36)}":0`).join()}}`)],
  '1,300,000 empty arrays': [413, inputs(`[${'[],'.repeat(1_300_000)}0]`)],
  'A key twice': [400, '{"inputs":{},"inputs":{"echo":1}}'],
  'A number beyond all': [400, inputs('1e999')],
  'NaN': [400, inputs('NaN')],
  'Bytes that are no UTF-8': [400, inputs('"\xff\xfe"')],
  'Half a surrogate pair': [400, inputs('"\\ud800"')],
  'A zero in a text': [400, inputs('"\0"')],
  'A text without an end': [400, `{"${'a'.repeat(4_000_000)}`],
  'Nothing': [400, ''],
  'A mark of byte order and nothing': [400, '\xef\xbb\xbf'],
  'JSON twice': [400, '{}{}'],
  'A comment': [400, '/* */{}'],
  'CBOR': [400, '\x9f'.repeat(100_000)],
};
for (const [what, [status, body]] of Object.entries(documents)) {
  test(`${what}: ${status}`, () => refused(post(sized(body)) + body, status));
}

test('What is within every limit, and costs most, costs little', async () => {
  const largest = {
    'numbers, deep down': inputs('['.repeat(55) + `0${',0'.repeat(990_000)}` + ']'.repeat(55)),
    'members': inputs(`{${Array.from({ length: 150_000 }, (_, i) => `"${i.toString(36)}":0`).join()}}`),
    'empty objects': inputs(`[{}${',{}'.repeat(290_000)}]`),
    'texts': inputs(`[""${',""'.repeat(400_000)}]`),
    'one text': inputs(JSON.stringify('\u0001'.repeat(690_000))),
  };
  for (const [what, body] of Object.entries(largest)) {
    assert.ok(body.length < 4 * 2 ** 20, `${what}: ${body.length}`);
    const start = memory.now().most;
    const response = await server.fetch(execution(), { method: 'POST', headers: { 'content-type': 'application/json' }, body });
    const text = await response.text();
    assert.equal(response.status, 200, `${what}: ${text.slice(0, 300)}`);
    assert.deepEqual(JSON.parse(text), { echo: JSON.parse(body).inputs.echo }, what);
    assert.ok(text.length < 2 * body.length + 1000, `${what}: ${text.length} bytes come for ${body.length}`);
    await assertWell(server, memory).catch((error) => assert.fail(`${what}: ${error.message}, from ${start - memory.idle}`));
  }
});

test('A body that comes too slowly is 408, by its length and in chunks, and in what frames them', async () => {
  const drip = async function* (first, piece) {
    yield first;
    for (;;) {
      await sleep(500);
      yield piece;
    }
  };
  const cases = [drip(post('Content-Length: 100000\r\n'), 'x'), drip(post(chunked), '1\r\nx\r\n'), drip(head(`PUT ${anAsset}`, 'Content-Length: 100000\r\n'), 'xyz')];
  const framing = drip(`${post(chunked)}1\r\nx\r\n`, '0');
  const silent = [post('Content-Length: 5\r\n'), `${post(chunked)}5\r\nhe`];
  const ended = await Promise.all([...cases, ...silent].map((parts) => converse(server.url, parts, { patience: 60 })));
  for (const { answers, closed, seconds } of ended) {
    assert.deepEqual(answers.map(({ status }) => status), [408]);
    assert.ok(closed && seconds > 9 && seconds < 40, `after ${seconds} s`);
  }
  const { answers, closed } = await converse(server.url, framing, { patience: 60 });
  assert.ok(closed && [400, 408].includes(answers[0].status));
  await assertWell(server, memory);
});

test('A body nobody asked for ends its connection with the answer, however slowly it comes', async () => {
  for (const line of ['GET /healthz', 'OPTIONS /healthz', 'HEAD /healthz']) {
    const drip = async function* () {
      for (yield head(line, 'Content-Length: 100000\r\n'); ; yield 'x') await sleep(500);
    };
    const { answers, closed, seconds } = await converse(server.url, drip(), { patience: 30 });
    assert.ok(closed && seconds < 5, `${line}: after ${seconds} s`);
    assert.ok(answers.length === 1 && answers[0].status < 300);
  }
  await assertWell(server, memory);
});

test('An upgrade is overlooked: one answer, with its length', async () => {
  const upgrade = 'Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n';
  const within = head('GET /readyz');
  const { answers, closed } = await converse(server.url, head('GET /healthz', upgrade + sized(within)) + within, { patience: 30 });
  assert.deepEqual(answers.map(({ status }) => status), [200]);
  assert.ok(closed && Number(answers[0].headers['content-length']) > 0, JSON.stringify(answers[0].headers));
});

test('Hundreds of slow bodies and of clients that do not read keep nobody waiting', async () => {
  const open = [];
  try {
    for (let i = 0; i < 200; ++i) open.push(converse(server.url, post('Content-Length: 1000\r\n'), { patience: 3 }));
    const api = `GET /api HTTP/1.1\r\n${host}\r\n`;
    const { connect } = await import('node:net');
    const { hostname, port } = new URL(server.url);
    for (let i = 0; i < 50; ++i) {
      const socket = connect(Number(port), hostname).pause();
      socket.on('error', () => {});
      socket.write(api.repeat(100));
      open.push(sleep(3000).then(() => socket.destroy()));
    }
    await sleep(1000);
    const asked = performance.now();
    assert.equal((await converse(server.url, `GET /healthz HTTP/1.1\r\n${host}Connection: close\r\n\r\n`)).answers[0]?.status, 200);
    assert.ok(performance.now() - asked < 5000, `after ${performance.now() - asked} ms`);
  } finally {
    await Promise.all(open);
  }
  await assertWell(server, memory);
});

test('It has stayed small', (t) => t.diagnostic(`grown by ${memory.growth().toFixed(1)} MiB at most over ${memory.idle.toFixed(1)} MiB`));

/**
 * Heads of requests as an attacker writes them: too large, two-faced, endless. Each is refused with its status, the server stays small
 * and goes on. Files and paths: attacks_files.test.mjs; bodies: attacks_bodies.test.mjs; a listener alone: tests/server/http.
 */
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { makeFolder, removeFolder } from './hoodoo.mjs';
import { Nginx } from './nginx.mjs';
import { Memory, answersIn, assertDiscreet, assertWell, converse, times } from './raw.mjs';
import { Server, freePort } from './server.mjs';

const mebibyte = 2 ** 20;
let work, server, nginx, plain, memory;

before(async () => {
  work = await makeFolder();
  const port = await freePort(), second = await freePort();
  server = await Server.start({ data: join(work, 'data'), args: ['--public-url', `http://127.0.0.1:${second}`, '--log', 'json'] });
  nginx = await Nginx.start({ folder: join(work, 'nginx'), port, upstream: new URL(server.url).port, data: join(work, 'data'), limits: false, plain: second });
  plain = `http://127.0.0.1:${second}`;
  for (let i = 0; i < 20; ++i) await (await server.fetch('/api')).text();
  memory = new Memory(server.child.pid);
});
after(async () => {
  await nginx?.stop();
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

const hostOf = (url) => `Host: ${new URL(url).host}\r\n`;
/** A request; `lines` come after the host's. */
const head = (url, line, lines = '') => `${line} HTTP/1.1\r\n${hostOf(url)}${lines}\r\n`;
const echo = 'POST /processes/echo/execution', json = 'Content-Type: application/json\r\n', body = '{"inputs":{"echo":1}}';
const length = (text) => `Content-Length: ${text.length}\r\n`;
/** A second request, which must never be answered where it is hidden in a first one. */
const hidden = (url) => head(url, 'GET /conformance', 'X-Hidden: yes\r\n');

/** One answer with one of `statuses`, then the connection ends. */
async function refused(url, parts, ...statuses) {
  const { answers, closed } = await converse(url, parts);
  const shown = JSON.stringify(answers).slice(0, 600);
  assert.equal(answers.length, 1, shown);
  assert.ok(closed, 'the connection stays open');
  assert.ok(statuses.includes(answers[0].status), shown);
  if (url === server.url) assertDiscreet(answers[0]);
  return answers[0];
}

/** what: [direct status, through nginx (0: none comes), parts of the request to a URL]. */
const large = {
  'A million headers': [431, 400, (url) => [head(url, 'GET /').slice(0, -2), ...Array(1000).fill('a: b\r\n'.repeat(1000)), '\r\n']],
  'A header of 300 MB': [431, 400, function* (url) { yield `${head(url, 'GET /').slice(0, -2)}X: `; yield* times(300, 'x'.repeat(1e6)); }],
  'A name of a header of 300 MB': [431, 400, function* (url) { yield head(url, 'GET /').slice(0, -2); yield* times(300, 'x'.repeat(1e6)); }],
  'A request line of 300 MB': [414, 414, function* () { yield 'GET /'; yield* times(300, 'x'.repeat(1e6)); }],
  'A method of 300 MB': [414, 414, () => times(300, 'G'.repeat(1e6))],
  'A query of 300 MB': [414, 414, function* () { yield 'GET /jobs?a='; yield* times(300, 'x'.repeat(1e6)); }],
  '100,000 empty lines': [400, 0, () => times(100, '\r\n'.repeat(1000))],
  '300 MB of zeros': [400, 400, () => times(300, '\0'.repeat(1e6))],
  'A path of 8,000 characters': [414, 414, (url) => head(url, `GET /${'x'.repeat(8000)}`)],
  'A path of 8,100 characters': [414, 414, (url) => head(url, `POST /${'a/'.repeat(4050)}`, 'Content-Length: 0\r\n')],
  '65 headers': [431, 431, (url) => head(url, 'GET /', Array.from({ length: 65 }, (_, i) => `X${i}: 1\r\n`).join(''))],
};
for (const [what, [direct, , parts]] of Object.entries(large)) {
  test(`${what}: ${direct}`, async () => {
    await refused(server.url, parts(server.url), direct);
    await assertWell(server, memory);
  });
}

/** While more of these comes than nginx reads, its answer may be lost as it closes. */
const lost = ['A million headers', 'A header of 300 MB', 'A name of a header of 300 MB', 'A request line of 300 MB', 'A method of 300 MB',
              'A query of 300 MB', '300 MB of zeros'];
test('The same through nginx', async () => {
  for (const [what, [, through, parts]] of Object.entries(large)) {
    const { answers, closed } = await converse(plain, parts(plain), { enough: ([first]) => first?.whole, patience: 20 });
    if (through === 0 || (lost.includes(what) && closed)) assert.ok(closed, `${what}: the connection stays open`);
    else assert.equal(answers.length, 1, `${what}: no answer`);
    assert.ok(answers.every(({ status }) => status === through), `${what}: ${answers[0]?.status}, not ${through}`);
    await assertWell(server, memory);
  }
});

const chunked = 'Transfer-Encoding: chunked\r\n', zero = '0\r\n\r\n';
/** what: [status, request with a second one hidden in it]. */
const twofaced = {
  'A length and chunks': [400, (url) => head(url, echo, `${json}Content-Length: 5\r\n${chunked}`) + zero + hidden(url)],
  'Chunks and a length': [400, (url) => head(url, echo, `${json}${chunked}Content-Length: 5\r\n`) + zero + hidden(url)],
  'No length and chunks': [400, (url) => head(url, echo, `${json}Content-Length: 0\r\n${chunked}`) + zero + hidden(url)],
  'Two lengths': [400, (url) => head(url, echo, `${json}Content-Length: 0\r\nContent-Length: 5\r\n`) + hidden(url)],
  'The same length twice': [400, (url) => head(url, echo, json + length(body) + length(body)) + body + hidden(url)],
  'Two lengths in one': [400, (url) => head(url, echo, `${json}Content-Length: 0, 5\r\n`) + hidden(url)],
  'A length of letters': [400, (url) => head(url, echo, `${json}Content-Length: abc\r\n`) + hidden(url)],
  'A length of letters for a GET': [400, (url) => head(url, 'GET /', 'Content-Length: abc\r\n') + hidden(url)],
  'A negative length': [400, (url) => head(url, echo, `${json}Content-Length: -1\r\n`) + hidden(url)],
  'A length with a sign': [400, (url) => head(url, echo, `${json}Content-Length: +0\r\n`) + hidden(url)],
  'A length in hexadecimal': [400, (url) => head(url, echo, `${json}Content-Length: 0x5\r\n`) + hidden(url)],
  'A length beyond 64 bits': [400, (url) => head(url, echo, `${json}Content-Length: 18446744073709551617\r\n`) + hidden(url)],
  'A length of nothing': [400, (url) => head(url, echo, `${json}Content-Length:\r\n`) + hidden(url)],
  'An encoded length': [400, (url) => head(url, echo, `${json}Content-Length: %30\r\n`) + hidden(url)],
  'Another coding': [501, (url) => head(url, echo, `${json}Transfer-Encoding: gzip\r\n`) + hidden(url)],
  'A coding after chunked': [501, (url) => head(url, echo, `${json}Transfer-Encoding: chunked, identity\r\n`) + zero + hidden(url)],
  'A coding before chunked': [501, (url) => head(url, echo, `${json}Transfer-Encoding: gzip, chunked\r\n`) + zero + hidden(url)],
  'Chunked twice': [501, (url) => head(url, echo, json + chunked + chunked) + zero + hidden(url)],
  'Almost chunked': [501, (url) => head(url, echo, `${json}Transfer-Encoding: xchunked\r\n`) + zero + hidden(url)],
  'An encoded coding': [501, (url) => head(url, echo, `${json}Transfer-Encoding: chunke%64\r\n`) + zero + hidden(url)],
  'A coding with a tab': [400, (url) => head(url, echo, `${json}Transfer-Encoding:\x0bchunked\r\n`) + zero + hidden(url)],
  'Chunks in HTTP/1.0': [400, (url) => `${echo} HTTP/1.0\r\n${hostOf(url)}${json}${chunked}\r\n${zero}${hidden(url)}`],
  'A space before the colon': [400, (url) => head(url, echo, `${json}Content-Length : 0\r\n`) + hidden(url)],
  'A folded line': [400, (url) => head(url, echo, `${json}X: a\r\n Content-Length: 0\r\n`) + hidden(url)],
  'A folded coding': [501, (url) => head(url, echo, `${json}Transfer-Encoding:\r\n chunked\r\n`) + zero + hidden(url)],
  'A line without a colon': [400, (url) => head(url, 'GET /', 'nonsense\r\n') + hidden(url)],
  'A header without a name': [400, (url) => head(url, 'GET /', ': x\r\n') + hidden(url)],
  'Lines that end in LF': [400, (url) => (head(url, 'GET /') + hidden(url)).replaceAll('\r', '')],
  'One line that ends in LF': [400, (url) => head(url, 'GET /', 'X: a\nContent-Length: 5\r\n') + hidden(url)],
  'A CR within a line': [400, (url) => head(url, 'GET /', 'X: a\rContent-Length: 5\r\n') + hidden(url)],
  'A zero in a header': [400, (url) => head(url, 'GET /', 'X: a\0b\r\n') + hidden(url)],
  'A zero in the path': [400, (url) => head(url, 'GET /\0') + hidden(url)],
  'An escape in a header': [400, (url) => head(url, 'GET /', 'X: \x1b[31m\r\n') + hidden(url)],
  'Two hosts': [400, (url) => head(url, 'GET /', 'Host: rebound.example\r\n') + hidden(url)],
  'No host': [400, (url) => `GET / HTTP/1.1\r\n\r\n${hidden(url)}`],
  'Another host': [421, (url) => `GET / HTTP/1.1\r\nHost: rebound.example\r\n\r\n${hidden(url)}`],
  'An encoded line end in the path': [400, (url) => head(url, 'GET /a%0d%0aX-Evil:%20yes') + hidden(url)],
  'An encoded zero in the path': [400, (url) => head(url, 'GET /viewer/index.html%00.png') + hidden(url)],
  'A path that is cut short': [400, (url) => head(url, 'GET /%4') + hidden(url)],
  'A space in the path': [400, (url) => head(url, 'GET /a b') + hidden(url)],
  'A path in UTF-8': [400, (url) => head(url, 'GET /caf\xc3\xa9') + hidden(url)],
  'A tab for a space': [400, (url) => `GET\t/\tHTTP/1.1\r\n${hostOf(url)}\r\n${hidden(url)}`],
  'HTTP/0.9': [400, (url) => `GET /\r\n\r\n${hidden(url)}`],
  'HTTP/2 without asking': [505, (url) => `PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n${hidden(url)}`],
  'HTTP/1.1 with a space': [400, (url) => `GET / HTTP/1.1 \r\n${hostOf(url)}\r\n${hidden(url)}`],
  'TLS': [400, () => Buffer.concat([Buffer.from('16030100f1010000ed0303', 'hex'), Buffer.alloc(200, 7), Buffer.from('\n')])],
  'CONNECT': [501, (url) => head(url, 'CONNECT 127.0.0.1:22') + hidden(url)],
  'TRACE with a body': [501, (url) => head(url, 'TRACE /', 'Content-Length: 300000000\r\n') + hidden(url)],
  'A method of its own': [501, (url) => head(url, 'BREW /') + hidden(url)],
  'A method in lower case': [501, (url) => head(url, 'get /') + hidden(url)],
};
for (const [what, [status, request]] of Object.entries(twofaced)) {
  test(`${what}: ${status}, and nothing after it is taken for a request`, async () => {
    await refused(server.url, request(server.url), status);
  });
}

/** Where nginx and RFC 9112 agree that the first one ends before the second: that is a request of its own. */
const own = ['A line without a colon', 'Lines that end in LF', 'An escape in a header', 'Another host', 'An encoded line end in the path',
             'A path in UTF-8', 'HTTP/1.1 with a space', 'A method of its own'];
const byNginx = /^[0-9a-f]{32}$/;   // the ids that it gives to requests; hoodoo's own are shorter

/** What came by nginx has its id, or was refused: by nginx itself, or by hoodoo for its head, which then has told no id. */
function assertByNginx(what, { status, headers }) {
  assert.equal(headers.server, 'nginx', what);
  assert.ok(status >= 400 || byNginx.test(headers['x-request-id']), `${what}: ${status}, ${headers['x-request-id']}`);
}
/** The requests that a server tells of, up to one that is asked last. */
async function logged(id) {
  assert.equal((await server.fetch('/healthz', { headers: { 'x-request-id': id } })).status, 200);
  for (;; await sleep(20)) {
    const lines = server.stderr.split('\n').filter((line) => line.endsWith('}')).map((line) => JSON.parse(line));
    const last = lines.findIndex(({ request }) => request === id);
    if (last >= 0) return lines.slice(0, last);
  }
}

test('None of them comes through nginx as two', async () => {
  const before = await logged('before'), two = [];
  for (const [what, [, request]] of Object.entries(twofaced)) {
    const patience = own.includes(what) ? 30 : 2;
    const { answers } = await converse(plain, request(plain), { enough: (all) => all.length > 1 && all.at(-1).whole, patience });
    for (const answer of answers) assertByNginx(what, answer);
    if (answers.some(({ body: text }) => text.includes('conformsTo'))) two.push(what);
  }
  assert.deepEqual(two, own);
  // One that was hidden from nginx would have no answer here: hoodoo must have heard of none.
  const heard = (await logged('after')).slice(before.length).filter(({ path }) => path === '/conformance');
  assert.equal(heard.length, own.length, JSON.stringify(heard));
  for (const { request } of heard) assert.match(request, byNginx);
  await assertWell(server, memory);
});

test('A GET with a body is one request, and its body none', async () => {
  const within = hidden(server.url);
  for (const more of [`${length(within)}\r\n`, `${length(within)}Connection: close\r\n\r\n`]) {
    const { answers } = await converse(server.url, `GET / HTTP/1.1\r\n${hostOf(server.url)}${more}${within}`, { enough: (all) => all.length > 1, patience: 3 });
    assert.deepEqual(answers.map(({ status }) => status), [200]);
    assert.ok(!answers[0].body.includes('conformsTo'));
  }
  const inChunks = `${within.length.toString(16)}\r\n${within}\r\n0\r\n\r\n`;
  const { answers } = await converse(server.url, head(server.url, 'GET /', chunked) + inChunks, { enough: (all) => all.length > 1, patience: 3 });
  assert.deepEqual(answers.map(({ status }) => status), [200]);
});

test('Requests that come in one packet are all answered, in order', async () => {
  const url = server.url;
  const many = head(url, 'GET /healthz') + head(url, echo, json + length(body)) + body + head(url, echo, json + chunked) +
    `${body.length.toString(16)}\r\n${body}\r\n0\r\n\r\n` + head(url, 'OPTIONS /jobs') + head(url, 'GET /readyz', 'Connection: close\r\n') + hidden(url);
  const { answers, closed } = await converse(url, many);
  assert.deepEqual(answers.map(({ status }) => status), [200, 200, 200, 204, 200]);
  assert.match(answers[4].body, /ready/);
  assert.ok(closed, 'what follows the last one is not answered');
  const thousand = await converse(url, head(url, 'GET /healthz').repeat(1000), { enough: (all) => all.length === 1000 });
  assert.equal(thousand.answers.length, 1000);
  assert.ok(thousand.answers.every(({ status }) => status === 200));
});

test('An answer that says that the connection closes is the last', async () => {
  const { answers, closed } = await converse(server.url, head(server.url, 'GET /nothing') + hidden(server.url));
  assert.deepEqual([answers.length, answers[0].status, answers[0].headers.connection, closed], [1, 404, 'close', true]);
});

test('Line ends in the value of a header stay what they are, and are told to nobody', async () => {
  for (const line of ['X-Request-Id: a%0d%0aX-Evil: yes', 'Idempotency-Key: a%0d%0aX-Evil:yes', 'If-None-Match: "%0d%0aX-Evil: yes"', 'Prefer: wait=0%0d%0aX-Evil: yes',
                      'Range: bytes=0-1%0d%0aX-Evil: yes', 'Origin: a%0d%0aX-Evil: yes', 'Last-Event-ID: %0d%0aX-Evil: yes']) {
    const { answers } = await converse(server.url, head(server.url, 'GET /conformance', `${line}\r\n`), { enough: (all) => all.length > 0 });
    assert.equal(answers[0].status, 200, line);
    assert.equal(answers[0].headers['x-evil'], undefined, line);
    assert.ok(!answers[0].body.includes('X-Evil'), line);
  }
});

test('Media types and preferences are the same in upper and lower case, and no others are taken for them', async () => {
  const status = async (type, prefer) => {
    const { answers } = await converse(server.url, head(server.url, echo, `Content-Type: ${type}\r\nPrefer: ${prefer}\r\n${length(body)}Connection: Close\r\n`) + body);
    return answers[0].status;
  };
  assert.equal(await status('Application/JSON; charset=utf-8', 'wait=0'), 200);
  assert.equal(await status('application/json', 'Respond-Async'), 201);
  for (const type of ['application/jsonfoo', 'application/json5', 'text/plain', '']) assert.equal(await status(type, 'wait=0'), 415, type);
});

test('Names that gateways take for others are refused: 400', async () => {
  for (const name of ['REMOTE_ADDR', 'HTTP_HOST', 'Content_Length', 'X_Forwarded_For', 'LOCAL_ADDR', 'REMOTE_PORT']) {
    await refused(server.url, head(server.url, 'GET /', `${name}: 6.6.6.6\r\n`), 400);
  }
  for (const name of ['X-Forwarded-For', 'Forwarded', 'X-Real-IP', 'X-Forwarded-Host', 'X-Original-URL', 'X-Rewrite-URL', 'X-HTTP-Method-Override']) {
    const { answers } = await converse(server.url, head(server.url, 'GET /conformance', `${name}: /metrics\r\n`), { enough: (all) => all.length > 0 });
    assert.match(answers[0].body, /conformsTo/, `${name} changes nothing`);
  }
});

test('A request after an empty line is one; heads that end early are none', async () => {
  const { answers } = await converse(server.url, `\r\n${head(server.url, 'GET /healthz')}`, { enough: (all) => all.length > 0 });
  assert.equal(answers[0].status, 200);
  for (const part of ['G', 'GET / HTTP/1.1\r\n', head(server.url, 'GET /').slice(0, -2), head(server.url, 'GET /').slice(0, -1)]) {
    const early = await converse(server.url, part, { end: true });
    assert.ok(early.closed);
    assert.deepEqual(early.answers.map(({ status }) => status), [400], part);
  }
});

test('A head that comes too slowly is 408 after 10 s; hundreds of them keep nobody waiting', async () => {
  const url = server.url;
  const drip = async function* () {
    yield head(url, 'GET /').slice(0, -2);
    for (;;) {
      await new Promise((done) => { setTimeout(done, 400); });
      yield 'a: b\r\n';
    }
  };
  const slow = Array.from({ length: 200 }, () => converse(url, drip(), { patience: 40 }));
  await new Promise((done) => { setTimeout(done, 1500); });
  await assertWell(server, memory);
  for (const { answers, closed, seconds } of await Promise.all(slow)) {
    assert.deepEqual(answers.map(({ status }) => status), [408]);
    assert.ok(closed && seconds > 9 && seconds < 30, `after ${seconds} s`);
  }
  await assertWell(server, memory);
});

test('answersIn reads what it should', () => {
  const two = answersIn(Buffer.from('HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nabHTTP/1.1 404 Not Found\r\nA: b\r\nContent-Length: 3\r\n\r\nab'));
  assert.deepEqual(two.map(({ status, body: text, whole }) => [status, text, whole]), [[200, 'ab', true], [404, 'ab', false]]);
});

test('It has stayed small', (t) => {
  t.diagnostic(`grown by ${memory.growth().toFixed(1)} MiB at most over ${memory.idle.toFixed(1)} MiB; ${(300e6 / mebibyte).toFixed(0)} MiB were sent several times`);
});

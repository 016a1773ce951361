/** Callbacks: what a subscriber hears, signed, at least once, through refusals and killed servers; and what the server will not ask. */
import assert from 'node:assert/strict';
import { createHmac } from 'node:crypto';
import { writeFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { Contract } from './contract.mjs';
import { exampleScene, hoodoo, makeFolder, makeRoot, removeFolder } from './hoodoo.mjs';
import { Server, freePort } from './server.mjs';

const secret = 'a secret of the test';
let work, root, scene;

before(async () => {
  work = await makeFolder();
  root = await makeRoot(work);
  await writeFile(join(work, 'secret'), `${secret}\n`);
  await writeFile(join(root, 'none.tif'), 'no raster');
  scene = await exampleScene();
});
after(() => removeFolder(work));

/** Listens on a loopback port, notes what comes, and answers with `answers`, one after the other, then with 204. */
class Receiver {
  static async start({ port = 0, answers = [] } = {}) {
    const receiver = new Receiver();
    receiver.calls = [];
    receiver.http = createServer((request, response) => {
      let body = '';
      request.setEncoding('utf8').on('data', (text) => { body += text; }).on('end', () => {
        receiver.calls.push({ method: request.method, path: request.url, headers: request.headers, body, at: Date.now() });
        const [status, headers] = answers.shift() ?? [204, {}];
        response.writeHead(status, headers).end(status === 204 ? undefined : 'x'.repeat(200_000));
      });
    }).listen(port, '127.0.0.1');
    await new Promise((resolve, reject) => receiver.http.once('listening', resolve).once('error', reject));
    receiver.port = receiver.http.address().port;
    receiver.url = `http://127.0.0.1:${receiver.port}`;
    receiver.host = `127.0.0.1:${receiver.port}`;
    return receiver;
  }
  async until(count) {
    for (const end = Date.now() + 120_000; this.calls.length < count; await sleep(20)) {
      assert.ok(Date.now() < end, `${this.calls.length} of ${count} calls came`);
    }
    return this.calls;
  }
  subscriber() {
    return { successUri: `${this.url}/yes?a=b`, inProgressUri: `${this.url}/begun`, failedUri: `${this.url}/no` };
  }
  stop() {
    this.http.closeAllConnections();
    return new Promise((done) => this.http.close(done));
  }
}

const start = (name, hosts, { pause = '0.2', args = [] } = {}) => Server.start({
  data: join(work, name), roots: [root],
  args: [...hosts.flatMap((host) => ['--callback-allow', host]), '--callback-secret', join(work, 'secret'), '--callback-seconds', pause, ...args],
});
const execute = (ask, process, body) => ask(`/processes/${process}/execution`, {
  method: 'POST', headers: { 'content-type': 'application/json', prefer: 'respond-async' }, body: JSON.stringify(body),
});
async function posted(ask, process, body) {
  const response = await execute(ask, process, body);
  assert.equal(response.status, 201, await response.clone().text());
  return (await response.json()).jobID;
}
const metric = async (server, name) => Number(new RegExp(`^${name.replace(/[{}]/g, '\\$&')} (\\S+)$`, 'm')
  .exec(await (await server.fetch('/metrics')).text())?.[1]);
async function untilMetric(server, name, value) {
  for (const end = Date.now() + 120_000; await metric(server, name) !== value; await sleep(50)) {
    assert.ok(Date.now() < end, `${name} is ${await metric(server, name)}, not ${value}`);
  }
}

/** What was signed is what came, now. */
function checkSignature({ headers, body, method }) {
  assert.equal(method, 'POST');
  assert.equal(headers['content-type'], 'application/json');
  const time = headers['hoodoo-timestamp'];
  assert.ok(Math.abs(Date.now() / 1000 - Number(time)) < 300, time);
  const expected = createHmac('sha256', secret).update(`${time}.${body}`).digest('hex');
  assert.equal(headers['hoodoo-signature'], `sha256=${expected}`);
}

test('A host that does not answer holds up itself alone', async () => {
  const held = [];
  const silent = createServer((request) => { held.push(request.url); }).listen(0, '127.0.0.1');
  await new Promise((done) => silent.once('listening', done));
  const healthy = await Receiver.start();
  const address = `127.0.0.1:${silent.address().port}`;
  const server = await start('silent', [address, healthy.host]);
  try {
    const tell = (uri) => posted(server.fetch.bind(server), 'echo', { inputs: { echo: 1 }, subscriber: { successUri: uri } });
    for (let n = 0; n < 3; ++n) await tell(`http://${address}/${n}`);
    for (const end = Date.now() + 60_000; held.length < 1; await sleep(20)) assert.ok(Date.now() < end, 'nobody called');
    const before = Date.now();
    await tell(`${healthy.url}/yes`);
    await healthy.until(1);
    const took = Date.now() - before;
    assert.ok(took < 8000, `the other host waited ${took} ms, which is a silent one's patience`);
    assert.equal(held.length, 1, 'one at a time of one host');
  } finally {
    await server.stop('SIGKILL');
    silent.closeAllConnections();
    silent.close();
    await healthy.stop();
  }
});

test('A subscriber hears that a bake begins and what it has made', async () => {
  const receiver = await Receiver.start();
  const server = await start('success', [receiver.host]);
  try {
    const contract = new Contract(await server.json('/api'));
    const id = await posted(contract.of(server), 'bake-terrain', { inputs: { scene }, subscriber: receiver.subscriber() });
    const [begun, done] = await receiver.until(2);
    assert.deepEqual([begun.path, done.path], ['/begun', '/yes?a=b']);
    [begun, done].forEach(checkSignature);
    assert.deepEqual([begun, done].map(({ headers }) => [headers['hoodoo-event'], headers['hoodoo-delivery']]),
                     [['inProgress', `${id}-inProgress`], ['success', `${id}-success`]]);
    const info = JSON.parse(begun.body);
    assert.deepEqual([info.jobID, info.status], [id, 'running']);
    assert.ok(contract.ajv.validate({ $ref: 'api#/components/schemas/statusInfo' }, info), contract.ajv.errorsText());
    assert.deepEqual(JSON.parse(done.body), await server.json(`/jobs/${id}/results`));
    await untilMetric(server, 'hoodoo_callbacks_total{result="delivered"}', 2);
    assert.equal(await metric(server, 'hoodoo_callbacks_pending'), 0);
    assert.ok((await server.json('/conformance')).conformsTo.some((one) => one.endsWith('/conf/callback')));
  } finally {
    await server.stop('SIGKILL');
    await receiver.stop();
  }
});

test('It hears of a failure, why it was, and nothing of this machine', async () => {
  const receiver = await Receiver.start();
  const server = await start('failure', [receiver.host]);
  try {
    const { successUri, failedUri } = receiver.subscriber();
    const id = await posted(server.fetch.bind(server), 'analyze-dem',
                            { inputs: { dem: 'none.tif' }, subscriber: { successUri, failedUri } });
    const [failed] = await receiver.until(1);
    checkSignature(failed);
    assert.equal(failed.path, '/no');
    const info = JSON.parse(failed.body);
    assert.deepEqual([info.jobID, info.status, info.errors.length], [id, 'failed', 1]);
    assert.ok(!failed.body.includes(work));
  } finally {
    await server.stop('SIGKILL');
    await receiver.stop();
  }
});

test('What is not taken is sent again, the same, after growing pauses; a redirect is not followed', async () => {
  const elsewhere = await Receiver.start();
  const receiver = await Receiver.start({ answers: [[500, {}], [302, { location: elsewhere.url }], [503, {}]] });
  const server = await start('retries', [receiver.host, elsewhere.host], { args: ['--log', 'json'] });
  try {
    const id = await posted(server.fetch.bind(server), 'echo', { inputs: { echo: [1, 'é'] }, subscriber: { successUri: receiver.url } });
    const calls = await receiver.until(4);
    calls.forEach(checkSignature);
    for (const { headers, body } of calls) {
      assert.equal(headers['hoodoo-delivery'], `${id}-success`);
      assert.deepEqual(JSON.parse(body), { echo: [1, 'é'] });
    }
    const pauses = calls.slice(1).map(({ at }, i) => at - calls[i].at);
    [200, 400, 800].forEach((least, i) => assert.ok(pauses[i] >= least - 20, `${pauses}`));
    await untilMetric(server, 'hoodoo_callbacks_total{result="delivered"}', 1);
    assert.equal(await metric(server, 'hoodoo_callbacks_total{result="failed"}'), 3);
    assert.equal(elsewhere.calls.length, 0);
    const lines = server.stderr.trimEnd().split('\n').map((line) => JSON.parse(line)).filter(({ event }) => event === 'callback');
    assert.deepEqual(lines.map(({ job, status, tries }) => [job, status, tries]), [[id, 500, 1], [id, 302, 2], [id, 503, 3], [id, 204, 4]]);
  } finally {
    await server.stop('SIGKILL');
    await receiver.stop();
    await elsewhere.stop();
  }
});

test('After six tries it is given up', async () => {
  const receiver = await Receiver.start({ answers: Array(10).fill([500, {}]) });
  const server = await start('given-up', [receiver.host], { pause: '0.05' });
  try {
    await posted(server.fetch.bind(server), 'echo', { inputs: { echo: 1 }, subscriber: { successUri: receiver.url } });
    await untilMetric(server, 'hoodoo_callbacks_total{result="given_up"}', 1);
    assert.equal(receiver.calls.length, 6);
    assert.equal(await metric(server, 'hoodoo_callbacks_pending'), 0);
    assert.match(server.stderr, /callback \w+-success is given up after 6 tries: answered 500/);
  } finally {
    await server.stop('SIGKILL');
    await receiver.stop();
  }
});

test('What is owed outlives a killed server', async () => {
  const port = await freePort();
  const args = ['--public-url', 'http://terrain.example'];
  let server = await start('killed', [`127.0.0.1:${port}`], { args });
  let receiver;
  try {
    const subscriber = { successUri: `http://127.0.0.1:${port}/yes` };
    const ids = [];
    for (let i = 0; i < 5; ++i) ids.push(await posted(server.fetch.bind(server), 'echo', { inputs: { echo: i }, subscriber }));
    await server.follow(ids[0]);
    await server.stop('SIGKILL');   // some have ended, others have not begun
    receiver = await Receiver.start({ port });
    server = await start('killed', [receiver.host], { args });
    await untilMetric(server, 'hoodoo_jobs{status="successful"}', 5);
    await untilMetric(server, 'hoodoo_callbacks_pending', 0);
    const heard = new Map(receiver.calls.map(({ headers, body }) => [headers['hoodoo-delivery'], JSON.parse(body).echo]));
    assert.deepEqual(heard, new Map([...heard.keys()].map((key) => [key, ids.indexOf(key.replace('-success', ''))])));
    assert.deepEqual([...heard.values()].sort(), [0, 1, 2, 3, 4], 'none was lost');
    receiver.calls.forEach(checkSignature);
  } finally {
    await server.stop('SIGKILL');
    await receiver?.stop();
  }
});

test('A job that is cancelled tells no more', async () => {
  const port = await freePort();   // where nobody listens
  const server = await start('cancelled', [`127.0.0.1:${port}`]);
  try {
    const uri = `http://127.0.0.1:${port}/`;
    const id = await posted(server.fetch.bind(server), 'echo',
                            { inputs: { echo: 1, pause: 10 }, subscriber: { successUri: uri, inProgressUri: uri, failedUri: uri } });
    await untilMetric(server, 'hoodoo_callbacks_pending', 1);
    assert.equal((await server.fetch(`/jobs/${id}`, { method: 'DELETE' })).status, 200);
    assert.equal(await metric(server, 'hoodoo_callbacks_pending'), 0);
    assert.equal(await metric(server, 'hoodoo_callbacks_total{result="given_up"}'), 0);
  } finally {
    await server.stop('SIGKILL');
  }
});

test('Hosts that are not on the list are refused, and not asked', async () => {
  const receiver = await Receiver.start(), other = await Receiver.start();
  const server = await start('refused', [receiver.host, `localhost:${other.port}`]);
  try {
    const contract = new Contract(await server.json('/api'));
    const ask = contract.of(server);
    const refused = async (subscriber, status, ...pointers) => {
      const response = await execute(ask, 'echo', { inputs: { echo: 1 }, subscriber });
      const problem = await response.json();
      assert.equal(response.status, status, JSON.stringify([subscriber, problem]));
      assert.deepEqual(problem.errors.map(({ pointer }) => pointer), pointers);
    };
    const good = `${receiver.url}/`;
    for (const successUri of [other.url, 'http://example.org/', 'http://169.254.169.254/latest/', 'http://127.0.0.1/', 'http://[::1]:80/',
                              `https://127.0.0.1:${other.port}/`, `http://127.0.0.1.nip.example:${receiver.port}/`, `${server.url}/jobs`]) {
      await refused({ successUri }, 422, '/subscriber/successUri');
    }
    await refused({ successUri: good, failedUri: other.url, inProgressUri: other.url }, 422, '/subscriber/inProgressUri', '/subscriber/failedUri');
    for (const successUri of ['', 'x', 5, 'ftp://127.0.0.1/', 'file:///etc/passwd', `http://user:pass@${receiver.host}/`,
                              `http://user@${receiver.host}/`, `${good}${'a'.repeat(3000)}`]) {
      await refused({ successUri }, 400, '/subscriber/successUri');
    }
    await refused({}, 400, '/subscriber/successUri');
    await refused('x', 400, '/subscriber');
    await refused({ successUri: good, other: good }, 400, '/subscriber/other');
    assert.equal((await ask('/processes/echo/execution', {
      method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify({ inputs: { echo: 1 }, subscriber: { successUri: good } }),
    })).status, 400, 'only jobs have subscribers');
    // A name may be on the list; where it leads to is looked at before it is asked.
    await posted(ask, 'echo', { inputs: { echo: 1 }, subscriber: { successUri: `http://localhost:${other.port}/` } });
    await untilMetric(server, 'hoodoo_callbacks_total{result="given_up"}', 1);
    for (let tries = 0; !/localhost leads to .*, which is not public/.test(server.stderr); ++tries, await sleep(20)) assert.ok(tries < 500, server.stderr);
    assert.deepEqual([receiver.calls, other.calls], [[], []]);
  } finally {
    await server.stop('SIGKILL');
    await receiver.stop();
    await other.stop();
  }
});

test('There are none without a list, nor without a secret', async () => {
  const server = await Server.start({ data: join(work, 'without') });
  try {
    const response = await execute(server.fetch.bind(server), 'echo', { inputs: { echo: 1 }, subscriber: { successUri: 'http://127.0.0.1:1/' } });
    assert.equal(response.status, 400);
    assert.equal((await response.json()).errors[0].pointer, '/subscriber');
    assert.ok(!(await server.json('/conformance')).conformsTo.some((one) => one.endsWith('/conf/callback')));
  } finally {
    await server.stop('SIGKILL');
  }
  const serve = (...args) => hoodoo(['serve', '--listen', '127.0.0.1:0', '--data', join(work, 'none'), ...args], { limit: 10_000 });
  const bare = await serve('--callback-allow', 'hooks.example');
  assert.equal(bare.code, 2);
  assert.match(bare.stderr, /--callback-secret: is needed with --callback-allow/);
  await writeFile(join(work, 'short'), 'short\n');
  const short = await serve('--callback-allow', 'hooks.example', '--callback-secret', join(work, 'short'));
  assert.equal(short.code, 2);
  assert.match(short.stderr, /short: must hold a secret of 16 to 4096 characters, got 5/);
  const wrong = await serve('--callback-allow', 'http://hooks.example', '--callback-secret', join(work, 'secret'));
  assert.equal(wrong.code, 2);
  assert.match(wrong.stderr, /--callback-allow: must be HOST or HOST:PORT, got "http:\/\/hooks.example"/);
});

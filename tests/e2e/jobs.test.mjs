/** What a job survives, and what it leaves: crashes, limits, cancelling, servers that are killed again and again. */
import assert from 'node:assert/strict';
import { readdir, readFile } from 'node:fs/promises';
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { DatabaseSync } from 'node:sqlite';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { assertNoOrphans } from './folder.mjs';
import { digests, exampleScene, makeFolder, makeRoot, removeFolder, seededRandom } from './hoodoo.mjs';
import { Server } from './server.mjs';

const sanitized = Boolean(process.env.HOODOO_SANITIZED);
let work, root, data, server, scene;
/** A scene that takes a while: the example on a finer grid. */
const long = () => ({ ...scene, bake: { ...scene.bake, spacing: 1 } });

before(async () => {
  work = await makeFolder();
  root = await makeRoot(work);
  data = join(work, 'data');
  scene = await exampleScene();
  server = await Server.start({ data, roots: [root] });
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

/** The processes that a server has started and that live: their ids. */
function children(of) {
  return readdirSync('/proc').filter((name) => /^\d+$/.test(name)).filter((pid) => {
    try {
      const [state, parent] = readFileSync(`/proc/${pid}/stat`, 'utf8').replace(/.*\) /s, '').split(' ');
      return Number(parent) === of.child.pid && state !== 'Z';
    } catch {
      return false;
    }
  }).map(Number);
}
/** Names of temporary files below a folder. */
async function leftovers(folder) {
  return (await readdir(folder, { recursive: true })).filter((name) => name.endsWith('.part'));
}
const tilesBegun = ({ tiles, status }) => tiles.done > 0 || status === 'successful';
const outOf = (id) => join(data, 'jobs', id, 'out');

test('A crash costs one job: it fails, says why, and the next one runs', async () => {
  const first = await server.submit(long());
  const second = await server.submit(scene);
  await server.follow(first, tilesBegun);
  const running = children(server);
  assert.equal(running.length, 1, 'one job runs, in a process of its own');
  process.kill(running[0], 'SIGSEGV');
  const failed = (await server.follow(first)).at(-1);
  assert.equal(failed.status, 'failed');
  assert.equal((await server.fetch(`/jobs/${first}/results`)).status, 500);
  assert.equal((await server.follow(second)).at(-1).status, 'successful');
  assert.deepEqual(await leftovers(data), []);
});

test('A cancelled job has stopped within a second and leaves no temporary file', async () => {
  const id = await server.submit(long());
  await server.follow(id, tilesBegun);
  assert.equal(children(server).length, 1);
  const start = performance.now();
  assert.equal((await server.fetch(`/jobs/${id}`, { method: 'DELETE' })).status, 200);
  while (children(server).length > 0) await sleep(5);
  const took = performance.now() - start;
  assert.ok(sanitized || took < 1000, `${took} ms`);
  assert.equal((await server.json(`/jobs/${id}`)).status, 'dismissed');
  // Asked again, the job is removed as soon as nothing writes to it any more.
  assert.equal((await server.fetch(`/jobs/${id}`, { method: 'DELETE' })).status, 200);
  assert.equal((await server.fetch(`/jobs/${id}`)).status, 404);
  assert.ok(!(await readdir(join(data, 'jobs'))).includes(id));
});

test('Jobs of a higher priority come first, and one that is out of range is refused', async () => {
  const running = await server.submit(long());
  const low = await server.submit(scene, { priority: -1 });
  const high = await server.submit(scene, { priority: 3 });
  await server.fetch(`/jobs/${running}`, { method: 'DELETE' });
  await server.follow(low);
  const started = async (id) => Date.parse((await server.json(`/jobs/${id}`)).started);
  assert.ok(await started(high) < await started(low));
  for (const priority of [11, -11, 0.5, '1', null]) {
    const { status } = await server.post(scene, { priority });
    assert.equal(status, 400, JSON.stringify(priority));
  }
});

test('A queue that is full answers 503 and says when to come again', async () => {
  const small = await Server.start({ data: join(work, 'small'), roots: [root], args: ['--queue', '1'] });
  try {
    const running = await small.submit(long());
    await small.follow(running, ({ status }) => status === 'running');
    await small.submit(scene);
    const refused = await small.post(scene);
    assert.equal(refused.status, 503);
    assert.ok(Number(refused.headers.get('retry-after')) > 0);
    assert.equal((await small.json('/jobs')).jobs.length, 2);
    assert.equal((await readdir(join(work, 'small', 'jobs'))).length, 2, 'nothing is kept of it');
  } finally {
    await small.stop();
  }
});

test('A request that is sent again with its Idempotency-Key is one job, over a restart too', async () => {
  const send = (body, key) => server.post(body, {}, { 'idempotency-key': key });
  const first = await send(scene, 'k-1');
  assert.equal(first.status, 201);
  const { jobID } = await first.json();
  const again = await send(scene, 'k-1');
  assert.equal(again.status, 200);
  assert.equal((await again.json()).jobID, jobID);
  assert.equal(again.headers.get('location'), `${server.url}/jobs/${jobID}`);
  await server.stop('SIGKILL');
  server = await Server.start({ data, roots: [root] });
  assert.equal((await (await send(scene, 'k-1')).json()).jobID, jobID);
  assert.equal((await send({ ...scene, name: 'Another' }, 'k-1')).status, 422);
  for (const key of ['', 'a'.repeat(256), 'k\u00e9']) assert.equal((await send(scene, key)).status, 400, key);
  await server.follow(jobID);
});

test('A key whose job has failed or was cancelled is free again', async () => {
  const send = async (body, key) => {
    const response = await server.post(body, {}, { 'idempotency-key': key });
    return [response.status, await response.json()];
  };
  const [, first] = await send(long(), 'k-2');
  assert.equal((await send(long(), 'k-2'))[0], 200);
  await server.fetch(`/jobs/${first.jobID}`, { method: 'DELETE' });
  const [status, second] = await send(long(), 'k-2');
  assert.equal(status, 201);
  assert.notEqual(second.jobID, first.jobID);
  assert.equal((await send(long(), 'k-2'))[1].jobID, second.jobID);
  await server.follow(second.jobID, tilesBegun);
  process.kill(children(server)[0], 'SIGSEGV');
  assert.equal((await server.follow(second.jobID)).at(-1).status, 'failed');
  const [again, third] = await send(scene, 'k-2');
  assert.equal(again, 201);
  await finish(third.jobID);
  assert.equal((await send(scene, 'k-2'))[0], 200, 'one that has ended well keeps it');
  assert.equal((await send(long(), 'k-2'))[0], 422);
});

test('A long bake tells how much time is left, once that is known', async () => {
  const id = await server.submit({ ...scene, bake: { ...scene.bake, spacing: 0.5 } });
  const seen = await server.follow(id, ({ secondsLeft, status }) => secondsLeft !== undefined || status === 'successful');
  const { secondsLeft, phase, message, tiles, status } = seen.at(-1);
  assert.equal(status, 'running', 'it took longer than two seconds');
  assert.ok(Number.isInteger(secondsLeft) && secondsLeft >= 0 && tiles.done > 0 && phase === 'tiles');
  assert.match(message, new RegExp(`, about ${secondsLeft} s left\\.$`));
  assert.equal(seen[0].secondsLeft, undefined);
  await server.fetch(`/jobs/${id}`, { method: 'DELETE' });
  assert.equal((await server.json(`/jobs/${id}`)).secondsLeft, undefined);
});

test('Events tell which tiles are finished and where, each once', async () => {
  const id = await server.submit(long());
  const events = async (headers = {}) => (await (await server.fetch(`/jobs/${id}/events`, { headers })).text()).split('\n\n')
    .filter((event) => event.startsWith('id: '))
    .map((event) => ({ id: event.match(/^id: (.+)$/m)[1], tiles: JSON.parse(event.match(/^data: (.+)$/m)[1]).finishedTiles ?? [] }));
  const seen = await events();
  const tiles = seen.flatMap((event) => event.tiles);
  assert.ok(seen.filter((event) => event.tiles.length > 0).length > 2, 'they come while it bakes');
  assert.equal(new Set(tiles.map(({ tile }) => tile)).size, tiles.length);
  const baked = new Map(JSON.parse(await readFile(join(outOf(id), 'bake.json'), 'utf8')).tiles.map(({ key, box }) => [key, box]));
  for (const { tile, box } of tiles) assert.deepEqual(box, baked.get(tile), tile);
  assert.ok(tiles.length > baked.size / 2, `${tiles.length} of ${baked.size}`);
  const middle = seen.findIndex((event) => event.tiles.length > 0);
  const later = (await events({ 'last-event-id': seen[middle].id })).flatMap((event) => event.tiles);
  assert.ok(seen[middle].tiles.every(({ tile }) => !later.some((other) => other.tile === tile)), 'what was seen is not told again');
});

test('While nothing changes, a comment every 15 s keeps the events of a job open', { timeout: 120_000 }, async () => {
  const busy = await server.submit({ ...scene, bake: { ...scene.bake, spacing: 0.25 } });
  await server.follow(busy, ({ status }) => status === 'running');
  const waiting = await server.submit(scene);
  // Where silence ends a connection, it is often after a minute.
  const response = await server.fetch(`/jobs/${waiting}/events`, { signal: AbortSignal.timeout(55_000) });
  let text = '', told;
  for await (const piece of response.body.pipeThrough(new TextDecoderStream())) {
    text += piece;
    if (told === undefined && text.endsWith('\n\n')) told = performance.now();
    if (/^:/m.test(text)) break;
  }
  assert.match(text, /^id: \d+\nevent: status\ndata: .*"accepted".*\n\n:.*\n\n$/);
  assert.ok(performance.now() - told > 10_000, 'no more often than it must');
  for (const id of [waiting, busy]) await server.fetch(`/jobs/${id}`, { method: 'DELETE' });
});

test('Whatever moment a server and its worker are killed at, jobs go on, to the same bytes', { timeout: 600_000 }, async () => {
  const expected = await digests(outOf(await finish(await server.submit(scene))));
  const seed = 11;
  const random = seededRandom(seed);
  const ids = [], ended = new Map(), rounds = 20;
  /** A job that has ended has done so once and for all. */
  const look = async () => {
    const { jobs } = await server.json('/jobs?limit=1000');
    for (const { jobID, status, started, finished } of jobs.filter((job) => ids.includes(job.jobID) && job.finished)) {
      const end = { status, started, finished };
      assert.deepEqual(end, ended.get(jobID) ?? end, 'done twice');
      ended.set(jobID, end);
    }
  };
  let lived = 0;   // rounds in which a job runs when its server is killed
  for (let round = 0; round < rounds; ++round) {
    await look();
    while (ids.length - ended.size < 3) ids.push(await server.submit(scene));
    await sleep(random() * 500);
    const running = children(server);
    if (running.length > 0) ++lived;
    if (round % 2 === 0) {
      for (const pid of running) kill(pid);
      await sleep(random() * 50);
    }
    await server.stop('SIGKILL');
    for (const end = Date.now() + 5000; running.some(alive);) {
      assert.ok(Date.now() < end, 'a job outlives its server');
      await sleep(1);
    }
    server = await Server.start({ data, roots: [root] });
  }
  assert.ok(lived > rounds / 2, `a job ran in ${lived} of ${rounds} rounds`);
  for (const id of ids) {
    await finish(id);
    assert.deepEqual(await digests(outOf(id)), expected, `seed ${seed}`);
    await assertNoOrphans(outOf(id));
  }
  await look();
  assert.equal(ended.size, ids.length);
  assert.deepEqual(await leftovers(data), []);
  assert.deepEqual(await readdir(join(data, 'checks')), []);
  const kept = (await server.json('/jobs?limit=1000')).jobs.map(({ jobID }) => jobID);
  for (const id of ids) assert.equal(kept.filter((other) => other === id).length, 1);
  assert.deepEqual((await readdir(join(data, 'jobs'))).sort(), kept.sort());
  const jobs = new DatabaseSync(join(data, 'jobs.db'), { readOnly: true });
  assert.deepEqual({ ...jobs.prepare('PRAGMA integrity_check').get() }, { integrity_check: 'ok' });
  jobs.close();
});

test('A worker that is killed is started again, but not for ever', async () => {
  const id = await server.submit(scene);
  await server.follow(id, ({ status }) => status === 'running');
  kill(await worker());
  await finish(id);
  const unlucky = await server.submit(long());
  for (const dead = []; dead.length < 3;) {
    dead.push(await worker(dead));
    kill(dead.at(-1));
  }
  const failed = (await server.follow(unlucky)).at(-1);
  assert.equal(failed.status, 'failed');
  assert.deepEqual(await leftovers(data), []);
});
/** The process of the job that runs, once there is one other than these. */
async function worker(dead = []) {
  for (const end = Date.now() + 10_000; Date.now() < end; await sleep(5)) {
    const pid = children(server).find((one) => !dead.includes(one));
    if (pid) return pid;
  }
  throw new Error('no job runs');
}
function kill(pid) {
  try {
    process.kill(pid, 'SIGKILL');
  } catch {}  // it has just ended
}
function alive(pid) {
  try {
    return !/\) Z/.test(readFileSync(`/proc/${pid}/stat`, 'utf8'));
  } catch {
    return false;
  }
}
async function finish(id) {
  const last = (await server.follow(id)).at(-1);
  assert.equal(last.status, 'successful', JSON.stringify(last));
  return id;
}

test('A job that wants more memory than it may have fails alone', { skip: sanitized && 'sanitizers reserve all of it' },
  async () => {
    const tight = await Server.start({ data: join(work, 'tight'), roots: [root], args: ['--job-memory', '160'] });
    try {
      const id = await tight.submit({ ...scene, bake: { ...scene.bake, spacing: 0.5 } });
      const last = (await tight.follow(id)).at(-1);
      assert.equal(last.status, 'failed', JSON.stringify(last));
      const { status } = await tight.fetch(`/jobs/${id}/results`);
      assert.equal(status, 413);
      assert.equal((await tight.fetch('/healthz')).status, 200);
    } finally {
      await tight.stop();
    }
  });

test('A job that takes more processor time than it may fails alone', async () => {
  const short = await Server.start({ data: join(work, 'short'), roots: [root], args: ['--job-seconds', '1'] });
  try {
    const id = await short.submit({ ...scene, bake: { ...scene.bake, spacing: 0.5 } });
    const last = (await short.follow(id)).at(-1);
    assert.equal(last.status, 'failed', JSON.stringify(last));
    assert.match(last.message, /processor time/);
  } finally {
    await short.stop();
  }
});

/** The TypeScript client: its types are those of the service, its example runs, and what breaks on the way goes on. */
import assert from 'node:assert/strict';
import { createHash, randomBytes } from 'node:crypto';
import { copyFile, mkdir, readFile, writeFile } from 'node:fs/promises';
import { openAsBlob } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { command, hoodoo, makeFolder, makeKey, removeFolder, run, synthesize } from './hoodoo.mjs';
import { Server } from './server.mjs';

const folder = resolve(import.meta.dirname, '../../client');
const built = join(dirname(command), 'viewer/client.js');   // bundled, as the viewer loads it
const mebibyte = 2 ** 20;
const { Hoodoo, Problem, readEvents, sha256 } = await import(pathToFileURL(built));
const hash = (bytes) => createHash('sha256').update(bytes).digest('hex');
const tool = (path, args) => run(process.execPath, [join(folder, 'node_modules', path), ...args]);
let work, dem, server, client;

before(async () => {
  work = await makeFolder();
  dem = await synthesize(join(work, 'dem.tif'), '--pixels', '100');
  server = await Server.start({ data: join(work, 'data') });
  client = new Hoodoo(server.url);
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

const sceneOf = (name, spacing = 16) => ({ hoodoo: 1, name: 'Client', terrains: [{ id: 'land', dem: name }], bake: { spacing } });

test('Its types are made from the document of the service', async () => {
  const document = join(work, 'api.json'), fresh = join(work, 'api.ts'), kept = join(folder, 'src/api.ts');
  await writeFile(document, await (await server.fetch('/api')).text());
  const { stdout } = await hoodoo(['schema', 'openapi']);
  assert.deepEqual(JSON.parse(stdout.replaceAll('http://127.0.0.1:8080', server.url)), JSON.parse(await readFile(document, 'utf8')));
  const made = await tool('openapi-typescript/bin/cli.js', [document, '-o', fresh]);
  assert.equal(made.code, 0, made.stderr);
  if (process.env.HOODOO_BLESS) await copyFile(fresh, kept);
  assert.equal(await readFile(kept, 'utf8'), await readFile(fresh, 'utf8'), 'make them anew with HOODOO_BLESS=1');
});

test('The example of its README compiles and runs', async () => {
  const readme = await readFile(join(folder, 'README.md'), 'utf8');
  const [, example] = /```ts\n(.*?)```/s.exec(readme);
  const package_ = join(work, 'node_modules/hoodoo-client');
  await mkdir(package_, { recursive: true });
  await writeFile(join(package_, 'package.json'), '{"type": "module", "exports": "./client.js"}');
  await copyFile(built, join(package_, 'client.js'));
  await writeFile(join(work, 'example.ts'), example);
  const config = {
    extends: join(folder, 'tsconfig.json'), include: [join(work, 'example.ts')],
    compilerOptions: {
      rootDir: '/', outDir: join(work, 'types'), noEmitOnError: true, paths: { 'hoodoo-client': [join(folder, 'src/index.ts')] },
    },
  };
  await writeFile(join(work, 'tsconfig.json'), JSON.stringify(config));
  const compiled = await tool('typescript/bin/tsc', ['-p', join(work, 'tsconfig.json')]);
  assert.equal(compiled.code, 0, compiled.stdout);
  await copyFile(join(work, 'types', work, 'example.js'), join(work, 'example.mjs'));

  const { bake } = await import(pathToFileURL(join(work, 'example.mjs')));
  const tileset = await bake(server.url, await openAsBlob(dem));
  assert.match(tileset, /\/jobs\/[0-9a-f]{32}\/tiles\/tileset\.json$/);
  assert.equal((await (await fetch(tileset)).json()).asset.version, '1.1');
  await assert.rejects(bake(server.url, new Blob(['no elevations'])), { name: 'Problem', status: 422 });
});

test('It tells what is wrong with a scene, by pointers', async () => {
  const name = await client.upload(await openAsBlob(dem));
  assert.equal(name, `sha256-${hash(await readFile(dem))}`);
  assert.deepEqual(await client.validate(sceneOf(name)), []);
  const [{ pointer, detail }] = await client.validate(sceneOf(name, -1));
  assert.equal(pointer, '/bake/spacing');
  await assert.rejects(client.submit(sceneOf(name, -1)), (error) => {
    assert.ok(error instanceof Problem);
    assert.equal(error.status, 422);
    assert.deepEqual(error.errors, [{ pointer, detail }]);
    return true;
  });
  await assert.rejects(client.job('0'.repeat(32)), { name: 'Problem', status: 404 });
  await assert.rejects(new Hoodoo('http://127.0.0.1:1').job('x'), TypeError);
});

test('Jobs are listed page by page, followed, cancelled and removed', async () => {
  const name = await client.upload(await openAsBlob(dem));
  const made = [];
  for (const priority of [0, 0, 3]) made.push(await client.submit(sceneOf(name), { priority }));
  assert.equal(made[2].priority, 3);
  const again = { idempotencyKey: 'one' };
  assert.equal((await client.submit(sceneOf(name), again)).jobID, (await client.submit(sceneOf(name), again)).jobID);

  const first = await client.jobs({ limit: 2 }), second = await client.jobs({ limit: 2, before: first.before });
  assert.equal(first.jobs.length, 2);
  assert.equal(second.jobs[0].jobID, made[1].jobID);
  const states = [];
  const ended = await client.wait(made[0].jobID, { onChange: ({ status }) => states.push(status) });
  assert.equal(ended.status, 'successful', ended.message);
  assert.equal(states.at(-1), 'successful');
  assert.deepEqual(Object.keys(await client.results(made[0].jobID)).sort(), ['manifest', 'report', 'tileset']);
  assert.ok((await client.jobs({ status: ['successful'] })).jobs.every(({ status }) => status === 'successful'));

  const long = await client.submit(sceneOf(name, 0.25));
  assert.equal((await client.dismiss(long.jobID)).status, 'dismissed');
  assert.equal((await client.wait(long.jobID)).status, 'dismissed');
  await client.dismiss(long.jobID);
  await assert.rejects(client.job(long.jobID), { status: 404 });
});

test('Events go on from where they broke, and end with the signal', async () => {
  const name = await client.upload(await openAsBlob(dem));
  const known = [];
  const breaking = new Hoodoo(server.url, { fetch: async (request) => {
    const response = await fetch(request);
    if (!request.url.endsWith('/events')) return response;
    known.push(request.headers.get('last-event-id'));
    if (known.length > 2) return response;
    const reader = response.body.getReader();   // one piece, and then the line is dead
    const { value } = await reader.read();
    await reader.cancel();
    const stream = new ReadableStream({ pull(controller) {
      if (this.sent) controller.error(new TypeError('broken'));
      else controller.enqueue(value);
      this.sent = true;
    } });
    return new Response(stream, { headers: response.headers });
  } });
  const { jobID } = await breaking.submit(sceneOf(name, 1));
  const updates = [], told = [];
  const tell = { onRetry: ({ name: kind }) => told.push(kind), onConnect: () => told.push('back') };
  for await (const { updated } of breaking.follow(jobID, tell)) updates.push(updated);
  assert.deepEqual(told.slice(0, 2), ['TypeError', 'back']);
  assert.equal((await client.job(jobID)).status, 'successful');
  assert.ok(known.length >= 2 && known[0] === null && known.slice(1).every((id) => /^\d+$/.test(id)), JSON.stringify(known));
  assert.equal(new Set(updates).size, updates.length, 'none came twice');

  const waiting = await client.submit(sceneOf(name, 0.25)), stop = new AbortController();
  const seen = client.wait(waiting.jobID, { signal: stop.signal, onChange: () => stop.abort(new Error('enough')) });
  await assert.rejects(seen, /enough|abort/i);
  await client.dismiss(waiting.jobID);
});

test('Events are read however they are cut', async () => {
  const text = ': hello\r\n\r\nid: 7\nevent: status\ndata: {"a":\ndata: 1}\n\ndata\n\nid: 8\rdata:x\r\rdata: ends early';
  for (const size of [1, 2, 3, 7, 1000]) {
    const bytes = new TextEncoder().encode(text);
    const stream = new ReadableStream({ start(controller) {
      for (let at = 0; at < bytes.length; at += size) controller.enqueue(bytes.slice(at, at + size));
      controller.close();
    } });
    assert.deepEqual(await Array.fromAsync(readEvents(stream)), [
      { id: '7', event: 'status', data: '{"a":\n1}' }, { id: '7', event: 'message', data: '' },
      { id: '8', event: 'message', data: 'x' }], `pieces of ${size}`);
  }
});

test('An upload in parts tells its progress, and goes on after the line broke and the page was closed', async () => {
  const bytes = randomBytes(5 * mebibyte + 3), file = new Blob([bytes]), kept = new Map(), requests = [];
  const storage = {
    getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => kept.set(key, value), removeItem: (key) => kept.delete(key),
  };
  const digest = await sha256(file);
  assert.equal(digest, hash(bytes));
  let fault = () => false;
  const watched = () => new Hoodoo(server.url, { fetch: async (request) => {
    requests.push(`${request.method} ${new URL(request.url).pathname.split('/')[1]}`);
    if (fault(request)) throw new TypeError('broken');
    return fetch(request);
  } });
  // The third part is lost on its way, and all that follows when the page is closed.
  let parts = 0, retries = 0;
  fault = ({ method }) => method === 'PATCH' && ++parts === 3;
  const closed = new AbortController(), progress = [];
  await assert.rejects(watched().upload(file, {
    sha256: digest, storage, signal: closed.signal, onRetry: () => { ++retries; },
    onProgress: (sent) => { progress.push(sent); if (retries > 0 && sent > 2 * mebibyte) closed.abort(new Error('closed')); },
  }), /closed|abort/i);
  assert.equal(retries, 1);
  assert.ok(progress.length > 3 && progress.every((sent, i) => i === 0 || sent >= progress[i - 1]), progress.join());
  assert.equal(kept.size, 1);

  requests.length = 0;
  fault = () => false;
  const name = await watched().upload(file, { storage });
  assert.equal(name, `sha256-${digest}`);
  assert.ok(!requests.includes('POST uploads'), 'it is the same upload');
  assert.ok(requests.includes('HEAD uploads'));
  assert.equal(kept.size, 0);
  assert.equal(hash(Buffer.from(await (await server.fetch(`/assets/${name}`)).arrayBuffer())), digest);

  requests.length = 0;
  await watched().upload(file);
  assert.deepEqual(requests, ['GET assets'], 'it is not sent again');
  assert.equal(await client.hasAsset(name), true);
  assert.equal(await client.hasAsset(`sha256-${hash('none')}`), false);
});

test('An upload that the server has forgotten begins anew, one with another digest fails', async () => {
  const bytes = randomBytes(3 * mebibyte), kept = new Map([[`sha256-${hash(bytes)}`, 'f'.repeat(32)]]);
  const storage = {
    getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => kept.set(key, value), removeItem: (key) => kept.delete(key),
  };
  assert.equal(await client.upload(new Blob([bytes]), { storage }), `sha256-${hash(bytes)}`);
  const wrong = client.upload(new Blob([randomBytes(2 * mebibyte)]), { sha256: hash('other'), tries: 2 });
  await assert.rejects(wrong, { name: 'Problem', status: 422 });
});

test('A key goes with every request', async () => {
  const keys = join(work, 'keys.json');
  const key = await makeKey(keys, 'somebody');
  const guarded = await Server.start({ data: join(work, 'guarded'), args: ['--keys', keys] });
  try {
    await assert.rejects(new Hoodoo(guarded.url).jobs(), { name: 'Problem', status: 401 });
    const allowed = new Hoodoo(guarded.url, { key: () => key });
    assert.deepEqual(await allowed.jobs(), { jobs: [], before: undefined });
    const job = await allowed.submit(sceneOf(await allowed.upload(await openAsBlob(dem))));
    assert.equal((await allowed.wait(job.jobID)).status, 'successful');
  } finally {
    await guarded.stop('SIGKILL');
  }
});

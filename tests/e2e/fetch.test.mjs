/** Elevations from an address: `POST /assets` on a server with --fetch-allow, and what keeps it from asking anybody else. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFile, readdir } from 'node:fs/promises';
import { createServer } from 'node:http';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { hoodoo, makeFolder, makeKey, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

let work, source, server, dem, name, host;
const asked = [];

/** What the other host answers, by path. */
const answers = {
  '/dem.tif': (response) => response.writeHead(200, { 'content-length': dem.length }).end(dem),
  '/moved.tif': (response) => response.writeHead(302, { location: '/dem.tif' }).end(),
  '/inside.tif': (response) => response.writeHead(302, { location: `${server.url}/healthz` }).end(),
  '/none.tif': (response) => response.writeHead(404).end('nothing'),
  '/endless.tif': (response) => response.writeHead(200).end(dem),   // in chunks, of no stated length
  '/huge.tif': (response) => { response.writeHead(200, { 'content-length': 1e15 }).write('II'); },
  '/large.tif': (response) => response.writeHead(200, { 'content-length': 2 << 20 }).end(Buffer.alloc(2 << 20)),
  '/short.tif': (response) => { response.writeHead(200, { 'content-length': dem.length }); response.write(dem.subarray(0, 1000), () => response.destroy()); },
  '/silent.tif': (response) => { response.writeHead(200, { 'content-length': dem.length }).flushHeaders(); },
};

before(async () => {
  work = await makeFolder();
  assert.equal((await hoodoo(['synthesize', join(work, 'dem.tif'), '--pixels', '100'])).code, 0);
  dem = await readFile(join(work, 'dem.tif'));
  name = `sha256-${createHash('sha256').update(dem).digest('hex')}`;
  source = createServer((request, response) => {
    asked.push({ path: request.url, headers: request.headers });
    (answers[request.url] ?? answers['/none.tif'])(response);
  }).listen(0, '127.0.0.1');
  await new Promise((done) => source.once('listening', done));
  host = `127.0.0.1:${source.address().port}`;
  server = await Server.start({ data: join(work, 'data'), args: ['--fetch-allow', host, '--asset-space', '100'] });
});
after(async () => {
  await server?.stop('SIGKILL');
  source?.closeAllConnections();
  source?.close();
  await removeFolder(work);
});

const post = (body, headers = {}, to = server) => to.fetch('/assets', {
  method: 'POST', headers: { 'content-type': 'application/json', ...headers }, body: typeof body === 'string' ? body : JSON.stringify(body),
});
async function refused(body, status, pointer, what, to = server) {
  const response = await post(body, {}, to);
  assert.equal(response.status, status, `${JSON.stringify(body)}: ${await response.clone().text()}`);
  const problem = await response.json();
  if (pointer !== undefined) {
    assert.deepEqual(problem.errors.map((error) => error.pointer), [pointer]);
    assert.match(problem.errors[0].detail, what);
  }
  assert.deepEqual((await readdir(join(work, 'data/uploads'))), [], 'nothing is left of it');
}

test('What cannot be had is said, and nothing is kept of it', async () => {
  const at = (path) => ({ href: `http://${host}${path}` });
  await refused(at('/none.tif'), 502, '/href', /answered with 404/);
  await refused(at('/moved.tif'), 502, '/href', /answered with 302/);
  await refused(at('/inside.tif'), 502, '/href', /answered with 302/);
  await refused(at('/endless.tif'), 502, '/href', /without a Content-Length/);
  await refused(at('/short.tif'), 502, '/href', /cannot be had/);
  await refused(at('/huge.tif'), 413);
  await refused({ ...at('/dem.tif'), id: `sha256-${'0'.repeat(64)}` }, 422);
  assert.deepEqual(await readdir(join(work, 'data/assets')), []);
});

test('A host that stops sending is given up after ten seconds', async () => {
  await refused({ href: `http://${host}/silent.tif` }, 502, '/href', /cannot be had/);
});

test('Nobody else is asked, whatever the address looks like', async () => {
  const { port } = source.address();
  const before = asked.length;
  for (const href of [`http://localhost:${port}/dem.tif`, `http://127.0.0.2:${port}/dem.tif`, `http://[::1]:${port}/dem.tif`, 'http://169.254.169.254/latest/',
                      `http://2130706433:${port + 1}/`, 'http://127.0.0.1/dem.tif', `https://elsewhere.example/dem.tif`, server.url + '/healthz']) {
    await refused({ href }, 422, '/href', /may not be called/);
  }
  for (const href of [`http://user:word@${host}/dem.tif`, 'file:///etc/passwd', 'ftp://127.0.0.1/dem.tif', 'gopher://127.0.0.1/', 'dem.tif', '', `http://${host}\r\nX: y/`]) {
    await refused({ href }, 400, '/href', /./);
  }
  assert.equal(asked.length, before);
});

test('A request that is not in form is told what is wrong', async () => {
  await refused({}, 400, '/href', /missing/);
  await refused({ href: 7 }, 400, '/href', /string/);
  await refused({ href: `http://${host}/dem.tif`, id: 'sha256-7' }, 400, '/id', /64/);
  await refused({ href: `http://${host}/dem.tif`, more: 1 }, 400, '/more', /neither/);
  await refused([], 400);
  await refused('{', 400);
  await refused(JSON.stringify({ href: 'x'.repeat(20_000) }), 413);
  assert.equal((await post({}, { 'content-type': 'text/plain' })).status, 415);
});

test('Without --fetch-allow nothing is fetched', async () => {
  const closed = await Server.start({ data: join(work, 'closed') });
  try {
    const response = await post({ href: `http://${host}/dem.tif` }, {}, closed);
    assert.equal(response.status, 422);
    assert.match((await response.json()).errors[0].detail, /may not be called/);
  } finally {
    await closed.stop('SIGKILL');
  }
  const { code, stderr } = await hoodoo(['serve', '--data', join(work, 'none'), '--fetch-allow', 'http://a.example/']);
  assert.equal(code, 2);
  assert.match(stderr, /--fetch-allow: must be HOST or HOST:PORT/);
});

test('An elevation model is fetched, is an asset like any other, and is not asked for twice where its name is known', async () => {
  const before = asked.length;
  const response = await post({ href: `http://${host}/dem.tif` });
  assert.equal(response.status, 201, await response.clone().text());
  assert.equal(response.headers.get('location'), `${server.url}/assets/${name}`);
  assert.deepEqual(await response.json(), { id: name, href: `${server.url}/assets/${name}`, bytes: dem.length });
  assert.ok(Buffer.from(await (await server.fetch(`/assets/${name}`)).arrayBuffer()).equals(dem));
  assert.equal(asked.length, before + 1);
  assert.equal(asked.at(-1).headers['user-agent'].split('/')[0], 'hoodoo');
  assert.equal((await post({ href: `http://${host}/dem.tif`, id: name })).status, 200);
  assert.equal(asked.length, before + 1);
  const job = await server.submit({ hoodoo: 1, terrains: [{ id: 'land', dem: name }], bake: { spacing: 4 } });
  assert.equal((await server.follow(job)).at(-1).status, 'successful');
});

test('What a key may keep bounds what it fetches', async () => {
  const keys = join(work, 'keys.json');
  const small = await makeKey(keys, 'small', '--scopes', 'read,submit', '--most-space', '1');
  const reader = await makeKey(keys, 'reader', '--scopes', 'read');
  const guarded = await Server.start({ data: join(work, 'guarded'), args: ['--keys', keys, '--fetch-allow', host] });
  try {
    const status = async (key) => (await post({ href: `http://${host}/large.tif` }, key ? { authorization: `Bearer ${key}` } : {}, guarded)).status;
    assert.equal(await status(), 401);
    assert.equal(await status(reader), 403);
    assert.equal(await status(small), 413);
  } finally {
    await guarded.stop('SIGKILL');
  }
});

/** JSON and the viewer's files in the content codings that clients take, tiles as they are. */
import assert from 'node:assert/strict';
import { request } from 'node:http';
import { after, before, test } from 'node:test';
import { brotliDecompressSync, gunzipSync, zstdDecompressSync } from 'node:zlib';
import { join } from 'node:path';
import { exampleScene, makeFolder, makeRoot, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const unpack = { br: brotliDecompressSync, gzip: gunzipSync, zstd: zstdDecompressSync };
let work, server, tileset, tile;

/** An answer as it came, which fetch would unpack: {status, headers, body}. */
function ask(path, headers = {}, method = 'GET') {
  return new Promise((resolve, reject) => {
    request(new URL(path, server.url), { method, headers }, async (response) => {
      resolve({ status: response.statusCode, headers: response.headers, body: Buffer.concat(await response.toArray()) });
    }).on('error', reject).end();
  });
}

before(async () => {
  work = await makeFolder();
  server = await Server.start({ data: join(work, 'data'), roots: [await makeRoot(work)] });
  const id = await server.submit(await exampleScene());
  await server.follow(id);
  tileset = `/jobs/${id}/tiles/tileset.json`;
  const [, file] = /"uri":\s*"([^"]+\.glb)"/.exec(await (await server.unchecked(tileset)).text());
  tile = `/jobs/${id}/tiles/${file}`;
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

test('Documents, tilesets and scripts come in each coding, smaller and the same', async () => {
  const [script] = /[\w./-]+\.js\b/.exec((await ask('/viewer/')).body.toString());
  for (const path of ['/api', '/processes/bake-terrain', tileset, `/viewer/${script}`]) {
    const plain = await ask(path);
    assert.equal(plain.status, 200, path);
    assert.equal(plain.headers['content-encoding'], undefined);
    assert.equal(plain.headers.vary, 'Accept-Encoding', path);
    for (const [coding, decode] of Object.entries(unpack)) {
      const packed = await ask(path, { 'accept-encoding': coding });
      assert.equal(packed.headers['content-encoding'], coding, path);
      assert.equal(packed.headers.vary, 'Accept-Encoding');
      assert.equal(packed.headers['content-type'], plain.headers['content-type']);
      assert.ok(packed.body.length < 0.6 * plain.body.length, `${path}: ${packed.body.length} of ${plain.body.length} bytes`);
      assert.ok(decode(packed.body).equals(plain.body), path);
      assert.notEqual(packed.headers.etag, plain.headers.etag);
      assert.ok((await ask(path, { 'accept-encoding': coding })).body.equals(packed.body), 'the same bytes each time');
    }
  }
});

test('A client that has one coding is told that nothing has changed, with its own tag', async () => {
  for (const path of ['/api', tileset]) {
    const plain = (await ask(path)).headers.etag;
    for (const coding of Object.keys(unpack)) {
      const { etag } = (await ask(path, { 'accept-encoding': coding })).headers;
      for (const [known, answered] of [[etag, etag], [plain, plain], [`"other", ${etag}`, etag]]) {
        const again = await ask(path, { 'accept-encoding': coding, 'if-none-match': known });
        assert.deepEqual([again.status, again.body.length, again.headers.etag, again.headers.vary],
                         [304, 0, answered, 'Accept-Encoding'], `${path} ${known}`);
      }
    }
  }
});

test('HEAD tells of the coding what GET does', async () => {
  const headers = { 'accept-encoding': 'gzip' };
  const got = await ask(tileset, headers), head = await ask(tileset, headers, 'HEAD');
  for (const name of ['content-encoding', 'content-length', 'etag', 'vary']) assert.equal(head.headers[name], got.headers[name], name);
  assert.equal(head.body.length, 0);
});

test('A part is a part of the file itself', async () => {
  const whole = await ask(tileset);
  const part = await ask(tileset, { 'accept-encoding': 'gzip', range: 'bytes=10-19' });
  assert.deepEqual([part.status, part.headers['content-encoding'], part.headers.etag], [206, undefined, whole.headers.etag]);
  assert.ok(part.body.equals(whole.body.subarray(10, 20)));
  // Of a coding nobody has a part, so the tag of one is that of another file.
  const { etag } = (await ask(tileset, { 'accept-encoding': 'gzip' })).headers;
  assert.equal((await ask(tileset, { 'if-range': etag, range: 'bytes=10-19' })).status, 200);
});

test('Tiles, short documents and events stay as they are', async () => {
  const all = 'br, zstd, gzip';
  for (const path of [tile, '/healthz', '/conformance/none', tileset.replace('tiles/tileset.json', 'events')]) {
    const { headers } = await ask(path, { 'accept-encoding': all });
    assert.equal(headers['content-encoding'], undefined, path);
  }
  assert.equal((await ask(tile, { 'accept-encoding': all })).headers.vary, undefined);
});

test('Crowds that ask for one file at once get the same', async () => {
  const first = await ask(tileset, { 'accept-encoding': 'br' });
  const all = await Promise.all(Array.from({ length: 40 }, (_, i) => ask(tileset, { 'accept-encoding': ['br', 'zstd', 'gzip'][i % 3] })));
  const plain = (await ask(tileset)).body;
  for (const { headers, body } of all) assert.ok(unpack[headers['content-encoding']](body).equals(plain));
  assert.ok(first.body.equals(all[0].body));
});

test('If-Match holds for what is there, in any coding, and for nothing else', async () => {
  const { etag } = (await ask(tileset)).headers, coded = (await ask(tileset, { 'accept-encoding': 'br' })).headers.etag;
  for (const [wanted, status] of [[etag, 200], [coded, 200], [`"other", ${etag}`, 200], ['*', 200], ['"other"', 412], [`W/${etag}`, 412]]) {
    assert.equal((await ask(tileset, { 'if-match': wanted })).status, status, wanted);
  }
  const job = tileset.split('/tiles/')[0];
  const { etag: now } = (await ask(job)).headers;
  assert.equal((await ask(job, { 'if-match': '"other"' }, 'DELETE')).status, 412);
  assert.equal((await ask(`${job}x`, { 'if-match': '*' }, 'DELETE')).status, 412);
  const upload = await server.fetch('/uploads', { method: 'POST', headers: { 'tus-resumable': '1.0.0', 'upload-length': '5' } });
  const path = new URL(upload.headers.get('location')).pathname;
  assert.equal((await ask(path, { 'if-match': '*', 'tus-resumable': '1.0.0' }, 'DELETE')).status, 204, 'it is there');
  assert.equal((await ask(job)).status, 200, 'it is still there');
  assert.equal((await ask(job, { 'if-match': now }, 'DELETE')).status, 200);
  assert.equal((await ask(job)).status, 404);
});

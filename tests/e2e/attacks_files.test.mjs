/**
 * Ways to files and to other servers: paths, links, ranges, references, and elevation models that are none. What is hostile for the
 * command alone: hostile.test.mjs; what lies beside tiles: serve.test.mjs; names of assets: assets.test.mjs.
 */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { existsSync } from 'node:fs';
import { copyFile, mkdir, readFile, readdir, symlink, writeFile } from 'node:fs/promises';
import { createServer } from 'node:net';
import { basename, join } from 'node:path';
import { after, before, test } from 'node:test';
import { exampleScene, makeFolder, makeRoot, removeFolder, testData } from './hoodoo.mjs';
import { Nginx } from './nginx.mjs';
import { Memory, assertDiscreet, assertWell, converse } from './raw.mjs';
import { Server, freePort } from './server.mjs';

const secret = 'root-of-all-secrets';
let work, data, root, server, nginx, plain, memory, scene, job, trap, reached = 0;

before(async () => {
  work = await makeFolder();
  data = join(work, 'data');
  root = await makeRoot(work);
  const tiles = join(work, 'hills');
  for (const folder of [tiles, join(tiles, '.git'), join(tiles, 'sub'), join(work, 'outside')]) await mkdir(folder);
  scene = await exampleScene();
  scene.bake = { ...scene.bake, spacing: 8 };
  for (const name of ['outside/secret.json', 'outside/tileset.json', 'hills/.git/config', 'hills/.secret.json', 'hills/.json', 'hills/notes.txt', 'hills/sub/.env.json']) {
    await writeFile(join(work, name), JSON.stringify(secret));
  }
  await writeFile(join(tiles, 'tileset.json'), '{}');
  await copyFile(join(root, 'dem.tif'), join(work, 'outside/dem.tif'));
  await symlink('../outside/secret.json', join(tiles, 'link.json'));
  await symlink('../outside', join(tiles, 'folder'));
  await symlink('../outside/dem.tif', join(root, 'link.tif'));
  await symlink('../outside', join(root, 'folder'));
  await symlink('/dev/zero', join(root, 'zero.tif'));
  trap = createServer((socket) => { ++reached; socket.destroy(); }).listen(0, '127.0.0.1');
  await new Promise((done) => trap.once('listening', done));
  const port = await freePort(), second = await freePort();
  server = await Server.start({ data, roots: [root], args: ['--tileset', tiles, '--public-url', `http://127.0.0.1:${second}`, '--jobs', '2', '--queue', '1000'] });
  nginx = await Nginx.start({ folder: join(work, 'nginx'), port, upstream: new URL(server.url).port, data, limits: false, plain: second });
  plain = `http://127.0.0.1:${second}`;
  job = await server.submit(scene);
  assert.equal((await server.follow(job)).at(-1).status, 'successful');
  await symlink('../../../../outside/secret.json', join(data, 'jobs', job, 'out/link.json'));
  await symlink('../../../../outside', join(data, 'jobs', job, 'out/folder'));
  memory = new Memory(server.child.pid);
});
after(async () => {
  trap?.close();
  await nginx?.stop();
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

async function ask(url, line, lines = '') {
  const { answers } = await converse(url, `${line} HTTP/1.1\r\nHost: ${new URL(url).host}\r\nConnection: close\r\n${lines}\r\n`, { enough: ([first]) => first?.whole });
  assert.equal(answers.length, 1, `${line}: ${answers.length} answers`);
  return answers[0];
}

/** Ways down from "/X/" that must lead nowhere. */
const tricks = ['..', '../', '../../jobs.db', '../scene.json', '%2e%2e/scene.json', '%2e%2e%2fscene.json', '..%2fscene.json', '..%5cscene.json', '..\\scene.json', '.%2e/scene.json',
                '%252e%252e%252fscene.json', '%c0%ae%c0%ae/scene.json', '%e0%80%ae/scene.json', '....//scene.json', '..;/scene.json', './/../scene.json', '%2f..%2fscene.json', '/etc/passwd',
                '//etc/passwd', '%2fetc%2fpasswd', 'C:%5cscene.json', 'file:///etc/passwd', '.git/config', '.git%2fconfig', '%2egit/config', '.secret.json', '.json', 'sub/.env.json', '.',
                'notes.txt', 'link.json', 'folder/secret.json', 'folder/tileset.json', 'folder/../outside/secret.json', 'folder', 'sub', 'sub/', 'tileset.json/', 'tileset.json/..',
                'tileset.json%00', 'tileset.json%00.glb', 'tileset.json%20', 'tileset.json.', 'tileset.json~', 'tileset.JSON', 'TILESET.json', 'tileset.json::$DATA', 'tileset.json%0a',
                'a/'.repeat(400), 'a'.repeat(900), `${'../'.repeat(200)}etc/passwd`, 'job.json', 'inputs.json', 'jobs.db', 'jobs.db-wal', '.hoodoo/use.lock', '*', '~', '~root/.bashrc', '-'];

for (const [what, start] of [['a tileset', () => '/tilesets/hills/'], ['the tiles of a job', () => `/jobs/${job}/tiles/`], ['the files of a job', () => `/jobs/${job}/files/`],
                             ['the viewer', () => '/viewer/'], ['the assets', () => '/assets/'], ['the uploads', () => '/uploads/'], ['the jobs', () => '/jobs/'], ['the root', () => '/']]) {
  test(`No path leads from ${what} to what is not of it`, async () => {
    for (const url of [server.url, plain]) {
      for (const trick of tricks) {
        const { status, body } = await ask(url, `GET ${start()}${trick}`);
        // Those that a proxy makes "/" of, or that are the page of all viewers.
        const harmless = url === plain && status === 200 && !body.includes(secret) && !/^root:/.test(body) && /^\.\.?\/?$|\.\.$|\/\.\.$/.test(trick);
        assert.ok([400, 403, 404, 405, 414].includes(status) || harmless, `${start()}${trick} at ${url}: ${status}`);
        assert.ok(!body.includes(secret) && !body.includes('root:x'), `${trick} gives ${body.slice(0, 200)}`);
        if (url === server.url) assertDiscreet({ status, headers: { 'content-type': 'application/problem+json' }, body });
      }
    }
    await assertWell(server, memory);
  });
}

test('A file comes in one range or whole, whatever is asked for', async () => {
  const { tiles } = await server.json(`/jobs/${job}/tiles/bake.json`);
  const { content } = tiles.find((tile) => tile.content);
  const path = `/jobs/${job}/tiles/tiles/${content.slice(0, 2)}/${content}.glb`;
  const size = (await ask(server.url, `GET ${path}`)).body.length;
  const bombs = { 'bytes=0-,0-,0-,0-': 416, [`bytes=${Array(1000).fill('0-').join()}`]: 416, [`bytes=${Array.from({ length: 1200 }, (_, i) => `${i}-${i}`).join()}`]: 431,
                  'bytes=-1,-2,-3': 416, 'bytes=0-0,-1': 416, 'bytes=9-4': 200, 'bytes=99999999999999999999-': 416, 'bytes=0-99999999999999999999': 206, 'bytes=-': 200, 'bytes=--1': 200,
                  'bytes=-0': 416, 'bytes=a-b': 200, 'bytes=': 200, 'bytes=0-0x10': 200, 'bytes= 0-1': 206, [`bytes=${size}-`]: 416, 'lines=0-1': 200, 'bytes=0-18446744073709551615': 206,
                  'bytes=0-0': 206, 'bytes=-1': 206, [`bytes=-${size + 1}`]: 206, 'bytes=1-': 206 };
  for (const [range, expected] of Object.entries(bombs)) {
    const { status, body, headers } = await ask(server.url, `GET ${path}`, `Range: ${range}\r\n`);
    assert.ok([expected].flat().includes(status), `${range.slice(0, 60)}: ${status}`);
    assert.ok(body.length <= size || status > 400, `${range.slice(0, 60)}: ${body.length} bytes`);
    assert.ok(!/multipart/.test(headers['content-type']));
    assert.equal(headers['access-control-allow-origin'], '*');
    if (status === 416) assert.equal(headers['content-range'], `bytes */${size}`);
  }
  await assertWell(server, memory);
});

const execute = (process, inputs) => server.fetch(`/processes/${process}/execution`, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify({ inputs }) });

/** Names of things that are not below a root of this server. */
const elsewhere = () => {
  const at = `127.0.0.1:${trap.address().port}`, p = trap.address().port;
  return [`http://${at}/dem.tif`, `https://${at}/dem.tif`, `http://localhost:${p}/dem.tif`, `http://[::1]:${p}/`, `http://[::ffff:127.0.0.1]:${p}/`, `http://2130706433:${p}/`, `http://0x7f.1:${p}/`,
          `http://0:${p}/`, `http://127.1:${p}/`, `http://a@${at}/`, `${server.url}@${at}/`, `${server.url}.evil.example:${p}/`, 'http://169.254.169.254/latest/meta-data/', 'http://10.0.0.1/', 'http://192.168.0.1/',
          'http://[fd00::1]/', `ftp://${at}/dem.tif`, `gopher://${at}/_x`, `//${at}/dem.tif`, `/vsicurl/http://${at}/dem.tif`, `/vsicurl_streaming/http://${at}/dem.tif`, `/vsis3/bucket/key`, `/vsizip//vsicurl/http://${at}/a.zip/dem.tif`,
          `WMS:http://${at}/?`, `<GDAL_WMS><Service name="TMS"><ServerUrl>http://${at}/</ServerUrl></Service></GDAL_WMS>`, `<VRTDataset><SourceFilename>/vsicurl/http://${at}/a</SourceFilename></VRTDataset>`,
          'GTIFF_DIR:1:/etc/passwd', 'file:///etc/passwd', 'file:/etc/passwd', 'file:../outside/dem.tif', 'file:%2e%2e/outside/dem.tif', 'file:link.tif', 'file:folder/dem.tif', 'file:zero.tif', 'file:', 'file:.', 'file:..',
          'file:dem.tif\0.png', `file://${at}/dem.tif`, `file:http://${at}/dem.tif`, '/dev/zero', '/proc/self/environ', '/proc/self/fd/0', '../outside/dem.tif', 'link.tif', 'folder/dem.tif', 'zero.tif', 'dem.tif/../../outside/dem.tif',
          `${server.url}/assets/../jobs.db`, `${server.url}/assets/sha256-..%2f..%2fjobs.db`, `${server.url}/jobs/../../outside`];
};

test('No reference has the server ask another one, or read what is not below its roots', async () => {
  for (const name of elsewhere()) {
    for (const [process, inputs] of [['analyze-dem', { dem: name }], ['analyze-dem', { dem: { href: name } }], ['bake-terrain', { scene: { href: name } }], ['validate-scene', { scene: { href: name } }],
                                     ['diff-tilesets', { first: name, second: { href: name } }]]) {
      const response = await execute(process, inputs), text = await response.text();
      assert.equal(response.status, 400, `${process} ${JSON.stringify(inputs)}: ${text.slice(0, 300)}`);
      assert.ok(!text.includes(work) && !text.includes('root:x'), text);
    }
    const { valid, problems } = await (await execute('validate-scene', { scene: { ...scene, terrains: [{ dem: name }] } })).json();
    assert.equal(valid, false, name);
    assert.ok(problems.some(({ pointer }) => pointer === '/terrains/0/dem'), `${name}: ${JSON.stringify(problems)}`);
  }
  assert.equal(reached, 0, 'somebody was asked');
  await assertWell(server, memory);
});

/** Bytes as an asset; gives its name. */
async function put(bytes) {
  const name = `sha256-${createHash('sha256').update(bytes).digest('hex')}`;
  const { status } = await server.fetch(`/assets/${name}`, { method: 'PUT', body: bytes });
  assert.ok(status === 201 || status === 204, `${status}`);
  return name;
}

/** Bakes from an asset: the refusal, or how the job ended. */
async function bakeFrom(bytes) {
  const response = await server.post({ hoodoo: 1, terrains: [{ dem: await put(bytes) }] });
  const answer = await response.json();
  if (response.status !== 201) return { status: response.status, text: JSON.stringify(answer) };
  const last = (await server.follow(answer.jobID, undefined, 120)).at(-1);
  return { status: last.status, text: JSON.stringify(last), id: answer.jobID };
}

test('A text that is not an elevation model is one for nobody', async () => {
  const at = `127.0.0.1:${trap.address().port}`;
  const texts = [`<VRTDataset rasterXSize="9" rasterYSize="9"><VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename>/vsicurl/http://${at}/a.tif</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>`,
                 `<VRTDataset rasterXSize="9" rasterYSize="9"><VRTRasterBand dataType="Byte" band="1"><SimpleSource><SourceFilename>/etc/passwd</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>`,
                 `<GDAL_WMS><Service name="TMS"><ServerUrl>http://${at}/\${z}/\${x}/\${y}.png</ServerUrl></Service><DataWindow><SizeX>9</SizeX><SizeY>9</SizeY></DataWindow></GDAL_WMS>`,
                 `{"type":"FeatureCollection","href":"http://${at}/"}`, 'P5 4 4 255\n0123456789abcdef', '#!/bin/sh\ntouch /tmp/x\n', '', 'II*\0', 'II*\0\xff\xff\xff\xff', 'MM\0+\0\x08\0\0'];
  for (const text of texts) {
    const { status, text: said } = await bakeFrom(Buffer.from(text, 'latin1'));
    assert.ok(status === 422 || status === 'failed', `${text.slice(0, 40)}: ${status}`);
    assert.match(said, /terrains\/0\/dem|TIFF|sha256-/, 'it is said where');
    assert.ok(!said.includes(work) && !said.includes('root:x'), said);
  }
  assert.equal(reached, 0, 'somebody was asked');
  await assertWell(server, memory);
});

test('Every hostile TIFF sent as an asset fails one job, or is refused, and no more', async (t) => {
  const folder = join(testData, 'hostile_tiff');
  if (!existsSync(folder)) return t.skip(`${folder} is absent: set HOODOO_TEST_DATA`);
  const files = (await readdir(folder, { recursive: true, withFileTypes: true }))
    .filter((entry) => entry.isFile()).map((entry) => join(entry.parentPath, entry.name)).sort();
  assert.ok(files.length > 100);
  const waiting = [...files], complaints = [], ends = {};
  const lane = async () => {
    for (let file; (file = waiting.shift());) {
      const { status, text, id } = await bakeFrom(await readFile(file));
      ends[status] = (ends[status] ?? 0) + 1;
      if (![422, 'failed', 'successful'].includes(status)) complaints.push(`${basename(file)}: ${status} ${text.slice(0, 300)}`);
      if (status === 'failed' && !/"errors":\[\{"detail":"[^"]+"/.test(text)) complaints.push(`${basename(file)}: no reason in ${text.slice(0, 600)}`);
      if (text.includes(work)) complaints.push(`${basename(file)}: a folder of the server in ${text.slice(0, 600)}`);
      if (id) await server.fetch(`/jobs/${id}`, { method: 'DELETE' });
    }
  };
  await Promise.all([lane(), lane()]);
  t.diagnostic(`${JSON.stringify(ends)}; grown by ${memory.growth().toFixed(1)} MiB`);
  assert.deepEqual(complaints, []);
  await assertWell(server, memory);
});

/** A bake by edit: `bake --reuse`, and jobs that begin with an earlier one. */
import assert from 'node:assert/strict';
import { readFile, rm, stat, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { filesBelow, json } from './folder.mjs';
import { digests, hoodoo, makeFolder, makeRoot, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const moved = [480, 500, 20];
const change = [{ op: 'replace', path: '/operations/0/tree/center', value: moved }];
const scene = {
  hoodoo: 1, name: 'One of two balls moves', terrains: [{ id: 'land', dem: 'dem.tif' }],
  operations: [[480, 490, 20], [800, 200, 30]].map((center, n) => ({ id: `ball${n}`, op: 'carve', tree: { type: 'sphere', center, radius: 12, falloff: 3 } })),
  bake: { spacing: 2, tile_cells: 32 },
};
const edited = structuredClone(scene);
edited.operations[0].tree.center = moved;

let work, root, server, first, clean, stale;

before(async () => {
  work = await makeFolder();
  root = await makeRoot(work);
  assert.equal((await hoodoo(['synthesize', join(root, 'dem.tif')])).code, 0);
  server = await Server.start({ data: join(work, 'data'), roots: [root] });
  first = await server.submit(scene);
  await successful(first);
  clean = join(work, 'clean');
  await bake(edited, clean);
  const known = new Set((await json(join(results(first), 'bake.json'))).tiles.map(({ slice }) => slice));
  stale = (await json(join(clean, 'bake.json'))).tiles.filter(({ slice }) => !known.has(slice)).length;
  assert.ok(stale > 0 && 4 * stale < known.size, `${stale} of ${known.size} tiles are stale`);
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

const results = (id) => join(work, 'data/jobs', id, 'out');
async function bake(what, folder, ...options) {
  const file = join(root, 'scene.json');
  await writeFile(file, JSON.stringify(what));
  const { code, stderr, stdout } = await hoodoo(['--json', 'bake', file, '-o', folder, ...options]);
  assert.equal(code, 0, stderr);
  return JSON.parse(stdout);
}
async function successful(id) {
  const info = (await server.follow(id)).at(-1);
  assert.equal(info.status, 'successful', info.message);
  return info;
}
const post = (inputs) => server.send(JSON.stringify({ inputs }));
async function refused(inputs, pointer, what) {
  const response = await post(inputs);
  assert.equal(response.status, 400, pointer);
  const { errors } = await response.json();
  assert.deepEqual(errors.map((error) => error.pointer), [pointer]);
  assert.match(errors[0].detail, what);
}
/** What a client may ask for; `.hoodoo` is the bake's own. */
async function files(folder) {
  return Object.fromEntries(Object.entries(await digests(folder)).filter(([name]) => !name.startsWith('.hoodoo')));
}

for (const [what, inputs] of Object.entries({
  'and a changed scene': () => ({ base: first, scene: edited }),
  'and a JSON Patch of its scene': () => ({ base: { href: `${server.url}/jobs/${first}` }, edit: change }),
})) {
  test(`A job with a base ${what} bakes only what changed, to the bytes of a clean bake`, async () => {
    const before = await files(results(first));
    const response = await post(inputs());
    assert.equal(response.status, 201, await response.clone().text());
    const { jobID } = await response.json();
    const { tiles } = await successful(jobID);
    assert.equal(tiles.done - tiles.reused, stale);
    assert.deepEqual(await files(results(jobID)), await files(clean));
    assert.deepEqual(await files(results(first)), before, 'the base is as it was');
  });
}

test('What is shared takes room on the disk once, and outlives the base', async () => {
  const folder = join(work, 'copy');
  const report = await bake(edited, folder, '--reuse', results(first));
  assert.equal(report.tiles - report.reused, stale);
  const links = await Promise.all((await filesBelow(join(folder, 'tiles'))).map(async (name) => (await stat(join(folder, 'tiles', name))).nlink));
  assert.ok(links.filter((count) => count > 1).length >= report.reused / 2, `${links}`);
  const second = (await (await post({ base: first, edit: [] })).json()).jobID;
  assert.equal((await successful(second)).tiles.reused, report.tiles, 'nothing changed');
  const kept = await files(results(second));
  await rm(results(first), { recursive: true });
  assert.deepEqual(await files(results(second)), kept);
  assert.deepEqual(await files(folder), await files(clean));
});

test('A tile of the base that is damaged is baked anew', async () => {
  const base = join(work, 'damaged'), folder = join(work, 'sound');
  await bake(scene, base);
  for (const name of await filesBelow(join(base, 'tiles'))) {
    const bytes = await readFile(join(base, 'tiles', name));
    bytes[bytes.length - 1] ^= 1;
    await writeFile(join(base, 'tiles', name), bytes);
  }
  await bake(edited, folder, '--reuse', base);
  assert.deepEqual(await files(folder), await files(clean));
});

test('A base that has gone when its job comes to run costs time and nothing else', async () => {
  const base = await server.submit(scene);
  await successful(base);
  const waits = (await (await server.fetch('/processes/echo/execution', {
    method: 'POST', headers: { 'content-type': 'application/json', prefer: 'respond-async' }, body: JSON.stringify({ inputs: { echo: 1, pause: 2 } }),
  })).json()).jobID;
  const { jobID } = await (await post({ base, edit: change })).json();
  assert.equal((await server.fetch(`/jobs/${base}`, { method: 'DELETE' })).status, 200);
  await successful(waits);
  const { tiles } = await successful(jobID);
  assert.equal(tiles.reused, 0);
  assert.deepEqual(await files(results(jobID)), await files(clean));
});

test('What is wrong with a base or an edit is said at its place', async () => {
  const base = await server.submit(scene);
  await successful(base);
  await refused({ base: '0'.repeat(32), scene }, '/inputs/base', /finished bake/);
  await refused({ base: '../..', edit: [] }, '/inputs/base', /finished bake/);
  await refused({ edit: change }, '/inputs/base', /missing/);
  await refused({ base }, '/inputs/scene', /missing/);
  await refused({ base, scene, edit: change }, '/inputs/scene', /one too many/);
  await refused({ base, edit: {} }, '/inputs/edit', /JSON Patch/);
  await refused({ base, edit: Array(1001).fill(change[0]) }, '/inputs/edit', /limit is 1000/);
  await refused({ base, edit: [...change, { op: 'copy', from: '', path: '/name' }] }, '/inputs/edit/1/op', /must be one of/);
  await refused({ base, edit: [{ op: 'remove', path: '/operations/7' }] }, '/inputs/edit/0', /does not lead/);
  await refused({ base, edit: [{ op: 'move', from: '/name', path: '/title' }] }, '/inputs/edit/0/op', /must be one of/);
  await refused({ base, edit: [{ op: 'add', path: '/name/x', value: 1 }] }, '/inputs/edit/0', /does not lead/);
  await refused({ base, edit: [{ op: 'remove', path: '/name/x' }] }, '/inputs/edit/0', /does not lead/);
  await refused({ base, edit: [{ op: 'remove', path: 'name' }] }, '/inputs/edit/0', /does not lead/);
  await refused({ base, edit: [{ op: 'add', path: '/a'.repeat(65), value: 1 }] }, '/inputs/edit/0/path', /deeper than 64/);
  await refused({ base, edit: [{ op: 'add', value: 1 }] }, '/inputs/edit/0/path', /string/);
  await refused({ base, edit: [{ op: 'add', path: '/name' }] }, '/inputs/edit/0', /no value/);
  await refused({ base, edit: [7] }, '/inputs/edit/0/op', /must be one of/);
  await refused({ base, edit: [{ op: 'test', path: '/name', value: 'another' }] }, '/inputs/edit/0', /does not hold/);
  await refused({ base, edit: [{ op: 'replace', path: '', value: 7 }] }, '/inputs/edit', /no object/);
  const wrong = await post({ base, edit: [{ op: 'replace', path: '/bake/spacing', value: -1 }] });
  assert.equal(wrong.status, 422);
  assert.deepEqual((await wrong.json()).errors.map(({ pointer }) => pointer), ['/bake/spacing']);
  const file = join(root, 'scene.json');
  await writeFile(file, JSON.stringify(scene));
  const { code, stderr } = await hoodoo(['bake', file, '-o', join(work, 'none'), '--reuse', root]);
  assert.equal(code, 4, stderr);
  assert.match(stderr, /--reuse takes a bake's folder/);
  assert.ok(!(await readFile(join(work, 'none', 'tileset.json')).catch(() => null)));
});

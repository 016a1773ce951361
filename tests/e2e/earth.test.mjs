/**
 * Tiles on the Earth (EPSG:4978): each vertex lies where PROJ's own cs2cs puts it, and a datum that cannot be told is an
 * error. The DEM covers 75 x 111 km; far apart in it small parts are baked finely, since a vertex stands on steps of its
 * level.
 */
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { copyFile, readFile, readdir, writeFile } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { digests, hoodoo, makeFolder, removeFolder, testData } from './hoodoo.mjs';

const name = 'olympic_N48W125_30m_epsg4326_i16_3601.tif';
const dem = join(testData, 'dem', name);
const skip = existsSync(dem) ? false : `${dem} is not there`;
const crs = 'EPSG:32610', datum = 'EPSG:5773';
const wide = 60, spacing = 0.5;   // m

let work;
before(async () => {
  work = await makeFolder();
  if (!skip) await copyFile(dem, join(work, name));
});
after(() => removeFolder(work));

async function write(file, content) {
  await writeFile(join(work, file), JSON.stringify(content));
  return join(work, file);
}

/** A part of the world, and a ball in it so that not all of it is ground. */
const sceneAt = ([x, y], bake) => ({
  hoodoo: 1, terrains: [{ dem: name }],
  operations: [{ op: 'union', tree: { type: 'sphere', center: { xy: [x + wide / 2, y + wide / 2], ground: 2 }, radius: 6, falloff: 4 } }],
  bake: { spacing, extent: { min: [x, y], max: [x + wide, y + wide] }, profile: 'plain', ...bake },
});

async function bake(file, folder) {
  const result = await hoodoo(['bake', file, '-o', folder]);
  assert.equal(result.code, 0, result.stderr);
}

/** Vertices of every tile of the leaves, z up [m], tile by tile. */
async function vertices(folder) {
  const { tiles } = JSON.parse(await readFile(join(folder, 'bake.json'), 'utf8'));
  const all = [];
  for (const { key, content } of tiles) {
    if (!content || !key.startsWith('0/')) continue;
    const bytes = await readFile(join(folder, `tiles/${content.slice(0, 2)}/${content}.glb`));
    const length = bytes.readUInt32LE(12);
    const gltf = JSON.parse(bytes.subarray(20, 20 + length));
    const accessor = gltf.accessors[gltf.meshes[0].primitives[0].attributes.POSITION];
    const start = 28 + length + (gltf.bufferViews[accessor.bufferView].byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    const [tx, ty, tz] = gltf.nodes[0].translation;
    for (let i = 0; i < accessor.count; ++i) {
      const at = (a) => bytes.readFloatLE(start + 12 * i + 4 * a);
      all.push([at(0) + tx, -(at(2) + tz), at(1) + ty]);
    }
  }
  return all;
}

/** From the tileset's frame to EPSG:4978. */
async function geocentric(folder) {
  const { root } = JSON.parse(await readFile(join(folder, 'tileset.json'), 'utf8'));
  const m = root.transform;
  return ([x, y, z]) => [0, 1, 2].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
}

function cs2cs(points) {
  const input = points.map((p) => p.map((v) => v.toFixed(6)).join(' ')).join('\n');
  const { stdout, status, stderr } = spawnSync('cs2cs', ['-f', '%.6f', `${crs}+${datum.slice(5)}`, 'EPSG:4978'], { input, encoding: 'utf8' });
  assert.equal(status, 0, stderr);
  return stdout.trim().split('\n').map((line) => line.trim().split(/\s+/).map(Number));
}

test('Vertices lie where cs2cs puts them, to a millimetre over 50 km', { skip }, async (t) => {
  let most = 0, count = 0, first, last;
  for (const place of [[3000, 3000], [35000, 35000], [3000, 51000], [67000, 11000], [43000, 51000]]) {
    const plane = join(work, `plane${place}`), earth = join(work, `earth${place}`);
    await bake(await write('plane.json', sceneAt(place, {})), plane);
    await bake(await write('earth.json', sceneAt(place, { frame: 'ecef', vertical: datum })), earth);
    const verified = await hoodoo(['verify', earth]);
    assert.equal(verified.code, 0, verified.stdout + verified.stderr);
    const { frame } = JSON.parse(await readFile(join(plane, 'bake.json'), 'utf8'));
    assert.equal(frame.crs, crs);
    const stood = await vertices(plane), laid = (await vertices(earth)).map(await geocentric(earth));
    assert.equal(stood.length, laid.length);
    const wanted = cs2cs(stood.map(([x, y, z]) => [x + frame.origin[0], y + frame.origin[1], z]));
    wanted.forEach((p, i) => { most = Math.max(most, Math.hypot(...p.map((v, a) => v - laid[i][a]))); });
    count += stood.length;
    first ??= wanted[0];
    last = wanted[0];
  }
  const apart = Math.hypot(...first.map((v, i) => v - last[i])) / 1000;
  t.diagnostic(`${count} vertices up to ${apart.toFixed(1)} km apart, at most ${(1000 * most).toFixed(2)} mm off`);
  assert.ok(count > 10000 && apart > 50);
  assert.ok(most < 0.001, `${most} m`);
});

test('A tileset on the Earth and the same in the plane show no difference', { skip }, async () => {
  const place = [40000, 40000], bigger = { spacing: 30, extent: { min: place, max: [52000, 56000] } };
  await bake(await write('a.json', sceneAt(place, bigger)), join(work, 'a'));
  await bake(await write('b.json', sceneAt(place, { ...bigger, frame: 'ecef', vertical: datum })), join(work, 'b'));
  const same = await hoodoo(['diff', join(work, 'a'), join(work, 'b'), '--tolerance', '0.001']);
  assert.equal(same.code, 0, same.stdout + same.stderr);
  // Exports are in the scene's plane.
  const places = [];
  for (const name of ['a', 'b']) {
    const { code, stderr } = await hoodoo(['export', join(work, name), '-o', join(work, `${name}.obj`)]);
    assert.equal(code, 0, stderr);
    places.push((await readFile(join(work, `${name}.obj`), 'utf8')).split('\n').filter((line) => line.startsWith('v ')).sort());
  }
  assert.ok(places[0].length > 1000);
  assert.deepEqual(places[0], places[1]);
});

test('The same bytes again, whatever the number of threads', { skip }, async () => {
  const file = await write('again.json', sceneAt([20000, 30000], { profile: 'draco', frame: 'ecef', vertical: datum }));
  for (const threads of ['1', '2']) {
    const { code, stderr } = await hoodoo(['bake', file, '-o', join(work, `t${threads}`), '--threads', threads]);
    assert.equal(code, 0, stderr);
  }
  assert.deepEqual(await digests(join(work, 't1')), await digests(join(work, 't2')));
  assert.ok((await readdir(join(work, 't1'))).length > 2);
});

for (const [what, vertical, told] of [
  ['that the DEM does not state', undefined, /\/bake\/vertical: is missing: .*olympic.* does not say/],
  ['whose grid is missing', 'EPSG:5703', /\/bake\/vertical: .*its grid .* is missing/],
  ['that is none', 'EPSG:4326', /\/bake\/vertical: EPSG:4326 is no vertical CRS/],
]) {
  test(`A vertical datum ${what} is an error`, { skip }, async () => {
    const file = await write('refused.json', sceneAt([20000, 30000], { frame: 'ecef', vertical }));
    const { code, stderr } = await hoodoo(['bake', file, '-o', join(work, 'refused')]);
    assert.equal(code, 2);
    assert.match(stderr, told);
    assert.ok(!existsSync(join(work, 'refused')));
  });
}

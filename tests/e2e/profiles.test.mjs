/**
 * The bundled example in every encoding: the same surface, as gltf-transform reads it with Draco's and meshoptimizer's own
 * decoders, in files of very different sizes.
 */
import assert from 'node:assert/strict';
import { copyFile, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Logger, NodeIO, Verbosity } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import draco3dgltf from 'draco3dgltf';
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';
import { digests, example, hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';

await MeshoptDecoder.ready;
const io = new NodeIO()
  .setLogger(new Logger(Verbosity.ERROR))
  .registerExtensions(ALL_EXTENSIONS)
  .registerDependencies({ 'draco3d.decoder': await draco3dgltf.createDecoderModule(), 'meshopt.decoder': MeshoptDecoder });

let work;
const found = {};

before(async () => {
  work = await makeFolder();
  const made = await hoodoo(['synthesize', join(work, 'dem.tif')]);
  assert.equal(made.code, 0, made.stderr);
  await copyFile(join(example, 'scene.json'), join(work, 'scene.json'));
  for (const profile of ['draco', 'meshopt', 'plain']) {
    const scene = JSON.parse(await readFile(join(work, 'scene.json'), 'utf8'));
    scene.bake = { ...scene.bake, profile };
    await writeFile(join(work, `${profile}.json`), JSON.stringify(scene));
    await bake(profile, profile);
    found[profile] = await look(join(work, profile));
  }
});
after(() => removeFolder(work));

async function bake(scene, folder, args = []) {
  const result = await hoodoo(['bake', join(work, `${scene}.json`), '-o', join(work, folder), ...args]);
  assert.equal(result.code, 0, result.stderr);
}

/** What is in each tile: corners of its triangles by place, material and colour, sorted; normals by place. */
async function look(folder) {
  const { tiles } = JSON.parse(await readFile(join(folder, 'bake.json'), 'utf8'));
  const all = { bytes: 0, tiles: new Map(), required: new Set() };
  for (const { key, content, bytes } of tiles) {
    if (!content) continue;
    all.bytes += bytes;
    const file = await readFile(join(folder, `tiles/${content.slice(0, 2)}/${content}.glb`));
    const json = JSON.parse(file.subarray(20, 20 + file.readUInt32LE(12)));
    for (const name of json.extensionsRequired ?? []) all.required.add(name);
    const mesh = (await io.readBinary(new Uint8Array(file))).getRoot().listMeshes()[0];
    all.tiles.set(key, mesh.listPrimitives().map(readPrimitive));
  }
  return all;
}

function readPrimitive(primitive) {
  const attribute = (name) => primitive.getAttribute(name);
  const indices = primitive.getIndices().getArray(), normals = new Map();
  const corners = [];
  for (let i = 0; i < indices.length; i += 3) {
    const triangle = [0, 1, 2].map((k) => {
      const vertex = indices[i + k];
      const place = attribute('POSITION').getElement(vertex, []).join(' ');
      normals.set(place, attribute('NORMAL').getElement(vertex, []));
      return `${place} ${attribute('_FEATURE_ID_0').getElement(vertex, [])} ${attribute('COLOR_0').getElement(vertex, [])}`;
    });
    const first = triangle.indexOf([...triangle].sort()[0]);
    corners.push([0, 1, 2].map((k) => triangle[(first + k) % 3]).join(' | '));
  }
  return { corners: corners.sort(), normals };
}

for (const profile of ['draco', 'meshopt']) {
  test(`${profile} holds the triangles of plain: places to the bit, order of corners, materials, colours`, () => {
    assert.deepEqual([...found[profile].tiles.keys()], [...found.plain.tiles.keys()]);
    let largest = 0;
    for (const [key, parts] of found[profile].tiles) {
      const wanted = found.plain.tiles.get(key);
      assert.equal(parts.length, wanted.length, key);
      parts.forEach((part, i) => {
        assert.deepEqual(part.corners, wanted[i].corners, key);
        for (const [place, n] of part.normals) {
          const m = wanted[i].normals.get(place), l = Math.hypot(...n);
          largest = Math.max(largest, Math.acos(Math.min(1, (n[0] * m[0] + n[1] * m[1] + n[2] * m[2]) / l)));
        }
      });
    }
    // Vertices at one place but in two triangles that meet there alone may have other normals: none does here.
    assert.ok(largest < 0.0045, `normals are within a quarter of a degree, not ${largest}`);
  });
}

test('Each says what a reader must know, and is smaller than the last', (t) => {
  assert.deepEqual([...found.draco.required], ['KHR_draco_mesh_compression']);
  assert.deepEqual([...found.meshopt.required].sort(), ['EXT_meshopt_compression', 'KHR_mesh_quantization']);
  assert.deepEqual([...found.plain.required], []);
  t.diagnostic(['plain', 'meshopt', 'draco'].map((name) => `${name} ${found[name].bytes} bytes`).join(', '));
  assert.ok(found.plain.bytes > 2 * found.meshopt.bytes);
  assert.ok(found.meshopt.bytes > found.draco.bytes);
});

test('hoodoo verify reads each', async () => {
  for (const profile of Object.keys(found)) {
    const { code, stdout, stderr } = await hoodoo(['verify', join(work, profile)]);
    assert.equal(code, 0, stdout + stderr);
  }
});

test('meshopt gives the same bytes, whatever the number of threads', async () => {
  for (const threads of ['1', '2']) await bake('meshopt', `t${threads}`, ['--threads', threads]);
  assert.deepEqual(await digests(join(work, 't1')), await digests(join(work, 't2')));
});

test('--draco-speed trades time for bytes, not the surface', async (t) => {
  const sizes = [];
  for (const speed of ['0', '5', '10']) {
    await bake('draco', `speed${speed}`, ['--draco-speed', speed]);
    const { bytes, tiles } = await look(join(work, `speed${speed}`));
    sizes.push(bytes);
    for (const [key, parts] of tiles) {
      assert.deepEqual(parts.map(({ corners }) => corners), found.draco.tiles.get(key).map(({ corners }) => corners), key);
    }
  }
  t.diagnostic(`${sizes.join(', ')} bytes`);
  assert.ok(sizes[0] < sizes[1] && sizes[1] < sizes[2]);
  assert.equal(sizes[1], found.draco.bytes, '5 is the default');
});

test('A speed out of range is an error', async () => {
  const { code, stderr } = await hoodoo(['bake', join(work, 'draco.json'), '-o', join(work, 'none'), '--draco-speed', '11']);
  assert.equal(code, 2);
  assert.match(stderr, /--draco-speed.*11/);
});

test('A speed for a scene whose settings are no object is that scene\'s error', async () => {
  const scene = join(work, 'wrong.json');
  for (const settings of [null, 5, 'fast', [1]]) {
    await writeFile(scene, JSON.stringify({ hoodoo: 1, terrains: [{ id: 'land', dem: 'dem.tif' }], bake: settings }));
    for (const args of [[], ['--draco-speed', '3']]) {
      const { code, stderr } = await hoodoo(['bake', scene, '-o', join(work, 'none'), ...args]);
      assert.equal(code, 2, stderr);
      assert.match(stderr, /\/bake: must be an object/);
    }
  }
});

test('A speed for a scene without settings is taken', async () => {
  await writeFile(join(work, 'bare.json'), JSON.stringify({ hoodoo: 1, terrains: [{ id: 'land', dem: 'dem.tif' }] }));
  await bake('bare', 'bare', ['--draco-speed', '10']);
});

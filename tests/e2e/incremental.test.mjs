/**
 * A world of 1,024 small leaves with some dozens of brushes: what an edit bakes again, and that edits and kills in any
 * number leave the files of one calm bake, byte for byte and no more of them.
 */
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { mkdtemp, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { assertLoadable, assertNoOrphans, json } from './folder.mjs';
import { digests, hoodoo, removeFolder, seededRandom } from './hoodoo.mjs';

const seed = Number(process.env.HOODOO_SEED ?? Math.floor(Math.random() * 2 ** 31));
console.log(`seed ${seed}`);
const random = seededRandom(seed);
const leaves = 32, cells = 16, spacing = 2;          // leaves of 32 m, a world of 1,024 m
const side = leaves * cells * spacing, brushes = 48, edits = 20, kills = 20;
const between = (low, high) => low + (high - low) * random();
const pick = (list) => list[Math.floor(random() * list.length)];
let work, calm;

/** In memory where there is such a folder: thousands of files a bake, each of which a disk would wait for. */
const workFolder = () => mkdtemp(join(existsSync('/dev/shm') ? '/dev/shm' : tmpdir(), 'hoodoo-e2e-'));

/** A brush by its kind, place and size [m]. */
const operations = {
  ball: ({ x, y, size }) => ({ op: 'union', tree: { type: 'sphere', center: { xy: [x, y], ground: 2 }, radius: size, falloff: 6 } }),
  hollow: ({ x, y, size }) => ({ op: 'difference', tree: { type: 'sphere', center: { xy: [x, y], ground: 0 }, radius: size, falloff: 6 } }),
  boulder: ({ x, y, size }) => ({
    op: 'blend',
    tree: { type: 'ellipsoid', center: { xy: [x, y], ground: 0 }, radii: [size, 0.8 * size, 0.6 * size], falloff: 8,
            turbulence: { amplitude: 1.5, wavelength: 12 } },
  }),
  tunnel: ({ x, y, size }) => ({ type: 'tunnel', radius: size / 2, path: [-1, 0, 1].map((k) => ({ xy: [x + 2 * k * size, y], ground: -size })) }),
  arch: ({ x, y, size }) => ({ type: 'arch', from: { xy: [x - size, y], ground: -2 }, to: { xy: [x + size, y], ground: -2 },
                               height: size, thickness: size / 2 }),
};
const newBrush = (kind = pick(Object.keys(operations))) => {
  return { kind, x: between(40, side - 40), y: between(40, side - 40), size: between(6, 14) };
};

const firstWorld = () => ({
  dem: 1, seed: 1, wavelength: 40, color: '#8d8377',
  brushes: Array.from({ length: brushes }, (_, i) => newBrush(Object.keys(operations)[i % 5])),
});

/** The scene of a world, written beside its DEMs. */
async function write(name, world) {
  const file = join(work, `${name}.json`);
  await writeFile(file, JSON.stringify({
    hoodoo: 1, seed: world.seed,
    materials: [{ name: 'shale', color: world.color, resistance: [0, 0.5] }, { name: 'limestone', color: '#cfc6b0', resistance: [0.5, 1] }],
    terrains: [{ id: 'land', dem: `dem-${world.dem}.tif`, falloff: 8 }],
    geology: { type: 'strata', wavelength: world.wavelength, octaves: 2 },
    operations: world.brushes.map((brush) => operations[brush.kind](brush)),
    bake: { spacing, tile_cells: cells },
  }));
  return file;
}

async function bake(scene, folder) {
  let indexing = 0;
  const onStart = (child) => whenIndexing(child, () => { indexing = performance.now(); });
  const result = await hoodoo(['bake', scene, '-o', folder, '--json', '--threads', '2'], { onStart });
  assert.equal(result.code, 0, `${result.signal}: ${result.stderr}`);
  return { ...JSON.parse(result.stdout), seconds: result.seconds, indexing: performance.now() - indexing };
}

/** Calls `then` when a bake says that all its tiles are there. */
function whenIndexing(child, then) {
  let seen = '';
  child.stderr.on('data', (text) => {
    const before_ = seen;
    seen += text;
    if (/writing the index/.test(seen) && !/writing the index/.test(before_)) then();
  });
}

/** Bakes into a fresh folder, which is gone afterwards. */
async function cleanBake(scene) {
  const folder = join(work, 'clean');
  const report = await bake(scene, folder);
  const found = { files: await digests(folder), index: await json(join(folder, 'bake.json')),
                  seconds: report.seconds, indexing: report.indexing };
  await assertNoOrphans(folder);
  await removeFolder(folder);
  return found;
}

/** Keys of the tiles of an index whose slices another one does not have. */
function changed(before_, after_) {
  const slices = new Set(before_.tiles.map((tile) => tile.slice));
  return after_.tiles.filter((tile) => !slices.has(tile.slice)).map((tile) => tile.key).sort();
}

before(async () => {
  work = await workFolder();
  for (const dem of [1, 2]) {
    const made = await hoodoo(['synthesize', join(work, `dem-${dem}.tif`), '--pixels', String(side / spacing),
                               '--spacing', String(spacing), '--seed', String(dem)]);
    assert.equal(made.code, 0, made.stderr);
  }
  const world = firstWorld();
  const scene = await write('calm', world);
  calm = { world, scene, ...await cleanBake(scene) };
  assert.equal(calm.index.tiles.filter((tile) => tile.key.startsWith('0/')).length, leaves ** 2);
});
after(() => removeFolder(work));

/**
 * Tiles that a ball can touch. It acts as far as 0.5458 of its falloff beyond its surface, and a tile looks at its area,
 * a block of 16 cells around it for the owners of what it samples, and two cells more for crossings beyond those. At
 * a level whose spacing is above four radii the ball is left out.
 */
function reached(keys, { x, y, size }) {
  const radius = size + (1 - 0.4542) * 6;
  return keys.filter((key) => {
    const [level, i, j] = key.split('/').map(Number);
    const cell = spacing * 2 ** level, tile = cell * cells, margin = radius + 18 * cell;
    const near = (at, k) => at >= k * tile - margin && at <= (k + 1) * tile + margin;
    return 2 * size >= cell / 2 && near(x, i) && near(y, j);
  });
}

test('A ball that moves bakes the tiles it can touch again, before and after, and no others', async (t) => {
  const folder = join(work, 'moved');
  await bake(calm.scene, folder);
  const world = structuredClone(calm.world);
  const ball = world.brushes.find(({ kind }) => kind === 'ball'), was = { ...ball };
  [ball.x, ball.y] = [side - ball.x, side - ball.y];   // to the other side of the world
  const scene = await write('moved', world);
  const clean = await cleanBake(scene);
  const report = await bake(scene, folder);
  const keys = clean.index.tiles.map((tile) => tile.key);
  const near = [...new Set([was, ball].flatMap((place) => reached(keys, place)))].sort();
  const found = changed(calm.index, clean.index);
  for (let level = 0; level < 6; ++level) {
    const count = (list) => list.filter((key) => key.startsWith(`${level}/`)).length;
    t.diagnostic(`level ${level}: ${count(found)} of ${count(keys)} tiles have another slice, ${count(near)} are within reach`);
  }
  assert.deepEqual(found, near);
  assert.equal(report.tiles - report.reused, found.length);
  assert.deepEqual(await digests(folder), clean.files);
  await assertNoOrphans(folder);
  await removeFolder(folder);
});

/** Edits of a world in place: {what: change}. */
const changes = {
  'a brush moved': (world) => {
    const brush = pick(world.brushes);
    brush.x = Math.min(side - 40, Math.max(40, brush.x + between(-60, 60)));
    brush.y = Math.min(side - 40, Math.max(40, brush.y + between(-60, 60)));
  },
  'a brush added': (world) => { world.brushes.splice(Math.floor(random() * world.brushes.length), 0, newBrush()); },
  'a brush removed': (world) => { world.brushes.splice(Math.floor(random() * world.brushes.length), 1); },
  'a brush resized': (world) => { pick(world.brushes).size *= between(0.5, 1.5); },
  'another colour': (world) => { world.color = `#${Math.floor(random() * 0xffffff).toString(16).padStart(6, '0')}`; },
  'another seed': (world) => { world.seed += 1; },
  'another geology': (world) => { world.wavelength = between(20, 60); },
  'another DEM': (world) => { world.dem = 3 - world.dem; },
};

test(`${edits} random edits in a row leave the files of clean bakes`, async (t) => {
  const folder = join(work, 'edited');
  await bake(calm.scene, folder);
  const world = structuredClone(calm.world);
  let index = calm.index;
  // Each kind once, then mostly what one does most.
  const order = Object.keys(changes).map((what) => [random(), what]).sort(([a], [b]) => a - b).map(([, what]) => what);
  while (order.length < edits) order.push(pick(Object.keys(changes).slice(0, random() < 0.2 ? undefined : 4)));
  for (const [i, what] of order.entries()) {
    changes[what](world);
    const scene = await write(`edit-${i}`, world);
    const clean = await cleanBake(scene);
    const report = await bake(scene, folder);
    const stale = changed(index, clean.index);
    t.diagnostic(`${what}: ${stale.length} of ${report.tiles} tiles baked again`);
    assert.equal(report.tiles - report.reused, stale.length, `${what}, edit ${i}, seed ${seed}`);
    assert.deepEqual(await digests(folder), clean.files, `${what}, edit ${i}, seed ${seed}`);
    await assertNoOrphans(folder);
    index = clean.index;
  }
  await removeFolder(folder);
});

/**
 * Bakes until it is killed at a random moment, every other time of those in which errors are measured, the index is written
 * and what is stale is removed. False when it ended before that.
 */
async function killed(i, scene, folder) {
  const options = i % 2 === 0 ? { kill: { after: 1000 * calm.seconds * random(), signal: 'SIGKILL' } } : {
    onStart: (child) => whenIndexing(child, () => setTimeout(() => child.kill('SIGKILL'), calm.indexing * random())),
  };
  const result = await hoodoo(['bake', scene, '-o', folder, '--threads', '2'], options);
  if (result.signal === null) assert.equal(result.code, 0, result.stderr);
  return result.signal === 'SIGKILL';
}

test(`A first bake killed at ${kills} random moments and continued gives the files of a calm one`, async (t) => {
  let count = 0, indexed = 0;
  for (let i = 0; count < kills; ++i) {
    const folder = join(work, 'killed');
    const hit = await killed(i, calm.scene, folder);
    if (hit) ++count;
    if (existsSync(join(folder, 'tileset.json'))) {
      ++indexed;
      await assertLoadable(folder);
    }
    await bake(calm.scene, folder);
    assert.deepEqual(await digests(folder), calm.files, `attempt ${i}, seed ${seed}`);
    await removeFolder(folder);
  }
  t.diagnostic(`${count} kills, ${indexed} with an index there`);
});

test(`A bake after an edit, killed at ${kills} random moments, leaves a whole tileset and continues`, async (t) => {
  const folder = join(work, 'rebaked');
  await bake(calm.scene, folder);
  const world = structuredClone(calm.world);
  world.color = '#123456';   // in every tile
  for (let i = 0; i < 10; ++i) changes['a brush moved'](world);
  const scene = await write('rebaked', world);
  const edited = { scene, ...await cleanBake(scene) };
  // To and fro between the two: each starts from a finished bake of the other.
  let [from, to] = [calm, edited], count = 0, old = 0;
  for (let i = 0; count < kills; ++i) {
    const hit = await killed(i, to.scene, folder);
    if (hit) ++count;
    await assertLoadable(folder);
    const now = await digests(folder);
    if (now['tileset.json'] === from.files['tileset.json']) ++old;
    else assert.equal(now['tileset.json'], to.files['tileset.json'], 'one or the other');
    await bake(to.scene, folder);
    assert.deepEqual(await digests(folder), to.files, `attempt ${i}, seed ${seed}`);
    await assertNoOrphans(folder);
    [from, to] = [to, from];
  }
  t.diagnostic(`${count} kills, ${old} of them before the new index`);

  // Given up halfway: the first scene again, and nothing of the second is left.
  await hoodoo(['bake', to.scene, '-o', folder], { kill: { after: 500 * calm.seconds, signal: 'SIGKILL' } });
  await bake(from.scene, folder);
  assert.deepEqual(await digests(folder), from.files);
  await assertNoOrphans(folder);
});

/** Generators: what `hoodoo generate` lists, and that bakes with them are whole, the same anyhow they are cut, and local. */
import assert from 'node:assert/strict';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { writeDem } from './dem.mjs';
import { digests, hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';

let work;
const scene = {
  hoodoo: 1,
  name: 'worn coast',
  terrains: [{ id: 'land', dem: 'dem.tif' }],
  geology: { type: 'strata', wavelength: 14, octaves: 3 },
  operations: [
    { id: 'sea', type: 'sea_cliffs', range: 14, steps: 2, radius: 6, distance: 5 },
    { id: 'bay', op: 'difference', tree: { type: 'sphere', center: { xy: [330, 200], ground: 0 }, radius: 24, falloff: 12 } },
    { id: 'river', type: 'river_canyon', drainage: 20000, stress: 0.05, banks: 20, radius: 6, distance: 5 },
  ],
  bake: { spacing: 4 },
};

async function write(name, of) {
  const file = join(work, `${name}.json`);
  await writeFile(file, JSON.stringify(of));
  return file;
}

async function succeeds(args) {
  const result = await hoodoo(args);
  assert.equal(result.code, 0, `${args.join(' ')}: ${result.stderr}`);
  return result;
}

before(async () => {
  work = await makeFolder();
  await succeeds(['synthesize', join(work, 'dem.tif'), '--pixels', '250', '--spacing', '4']);
  await write('scene', scene);
});
after(() => removeFolder(work));

const rows = async (file) => {
  const [head, ...lines] = (await readFile(file, 'utf8')).trimEnd().split('\n');
  const keys = head.split(',');
  return lines.map((line) => Object.fromEntries(line.split(',').map((v, i) => [keys[i], v])));
};

test('Every primitive is listed, and the report counts them', async () => {
  const out = join(work, 'made');
  const { stdout } = await succeeds(['generate', join(work, 'scene.json'), '-o', out, '--explain']);
  const report = JSON.parse(await readFile(join(out, 'report.json'), 'utf8'));
  const primitives = await rows(join(out, 'primitives.csv'));
  const marks = await rows(join(out, 'marks.csv'));
  assert.deepEqual(report.generators.map((g) => [g.id, g.type]), [['sea', 'sea_cliffs'], ['river', 'river_canyon']]);
  for (const { id, counts, nodes, steps } of report.generators) {
    const own = primitives.filter((p) => p.generator === id);
    assert.ok(own.length > 50, `${id}: ${own.length}`);
    assert.equal(own.length, counts.placed);
    assert.equal(nodes, counts.placed + steps);
    assert.equal(marks.filter((m) => m.generator === id && m.kind === 'samples').length, counts.sampled);
    assert.ok(own.every((p) => p.operation === 'carve' && Number(p.radius) === 6 && Number(p.energy) > 0));
    assert.match(stdout, new RegExp(`^${id}: .*, ${nodes} nodes`, 'm'));
    assert.match(stdout, new RegExp(`^ +${counts['too weak']} too weak$`, 'm'));
  }
  assert.ok(primitives.filter((p) => p.generator === 'sea').every((p) => Math.abs(p.z) <= 14));
});

test('One thread and two list the same', async () => {
  for (const threads of ['1', '2']) {
    await succeeds(['generate', join(work, 'scene.json'), '-o', join(work, `threads${threads}`), '--threads', threads]);
  }
  assert.deepEqual(await digests(join(work, 'threads1')), await digests(join(work, 'threads2')));
});

test('The primitives do not depend on how the DEM is cut into tiles, nor on the threads', async () => {
  const land = (i, j) => {
    const valley = 60 * Math.exp(-(((j - 150 - 20 * Math.sin(i / 25)) / 22) ** 2));
    const pit = 14 * Math.exp(-(((i - 190) ** 2 + (j - 60) ** 2) / 90));
    return 90 + i / 15 - valley - pit - 84 / (1 + Math.exp((i - 60) / 4));
  };
  const all = structuredClone(scene);
  all.operations.push(
    { id: 'karst', type: 'percolation_karst', cliffs: 60, steepness: 40, radius: 5, step: 6, rho_0: 0.7, count: 60 },
    { id: 'columns', type: 'hoodoos', height: 12, radius: 3, distance: 20, slope: { high: 40, falloff: 10 } },
    { id: 'stones', type: 'scatter', density: 0.001, tree: { type: 'sphere', center: [0, 0, 0], radius: 2, falloff: 1 } });
  const listed = new Map();
  for (const tile of [64, 256, 1024]) {
    await writeDem(join(work, `tiles${tile}.tif`), 300, 4, land, { tile });
    const file = await write(`tiles${tile}`, { ...all, terrains: [{ id: 'land', dem: `tiles${tile}.tif` }] });
    for (const threads of ['1', '2']) {
      const out = join(work, `tiles${tile}-${threads}`);
      await succeeds(['generate', file, '-o', out, '--threads', threads]);
      listed.set(`tiles of ${tile}, ${threads} threads`, await digests(out));
    }
  }
  const { generators } = JSON.parse(await readFile(join(work, 'tiles64-1', 'report.json'), 'utf8'));
  assert.equal(generators.length, all.operations.filter(({ type }) => type).length);
  for (const { id, counts } of generators) assert.ok(counts.placed > 20, `${id} placed ${counts.placed}: too few to tell`);
  const [[first, expected]] = listed;
  for (const [how, found] of listed) assert.deepEqual(found, expected, `${how} is not as ${first}`);
});

test('A bake is whole, and shards of it come to the same bytes', async () => {
  const whole = join(work, 'whole'), parts = join(work, 'parts');
  await succeeds(['bake', join(work, 'scene.json'), '-o', whole]);
  await succeeds(['verify', whole]);
  for (const i of [1, 2, 3]) await succeeds(['bake', join(work, 'scene.json'), '-o', parts, '--shard', `${i}/3`]);
  assert.deepEqual(await digests(parts), await digests(whole));
});

test('The time of generation that --stats tells is that of the generators, too', async () => {
  const crowded = structuredClone(scene), bare = structuredClone(scene);
  crowded.operations = [{ ...scene.operations[0], distance: 1.5 }];
  bare.operations = [];
  const time = async (name, of) => {
    const { stdout } = await succeeds(['bake', await write(name, of), '-o', join(work, `${name}-out`), '--stats', '--json']);
    return JSON.parse(stdout).stats;
  };
  const with_ = await time('crowded', crowded), without = await time('bare', bare);
  assert.ok(with_.nodes > 1000, `${with_.nodes} nodes`);
  assert.ok(with_.generation_s > 3 * without.generation_s, `${with_.generation_s} s, and ${without.generation_s} s without`);
});

test('A generator moved by its region bakes the tiles in its reach alone', async () => {
  const before_ = structuredClone(scene), after_ = structuredClone(scene);
  before_.operations[0].region = { type: 'box', min: [0, 0, -50], max: [1000, 500, 50] };
  after_.operations[0].region = { type: 'box', min: [0, 0, -50], max: [1000, 560, 50] };
  before_.operations.length = after_.operations.length = 1;
  before_.bake.tile_cells = after_.bake.tile_cells = 32;
  const out = join(work, 'moved');
  await succeeds(['bake', await write('before', before_), '-o', out]);
  const again = JSON.parse((await succeeds(['bake', await write('after', after_), '-o', out, '--json'])).stdout);
  assert.ok(again.reused > again.planned / 2, `${again.reused} of ${again.planned} tiles were found finished`);
  assert.ok(again.reused < again.planned, 'some tile is baked again');
});

test('Water that takes more memory than there is ends with exit 3, naming the operation', async () => {
  const fine = structuredClone(scene);
  fine.operations = [{ ...scene.operations[2], pixel: 0.1 }];
  const result = await hoodoo(['generate', await write('fine', fine)]);
  assert.equal(result.code, 3, result.stderr);
  assert.match(result.stderr, /^hoodoo: \/operations\/0: elevations of \d+ x \d+ cells take \d+ MiB, the limit is \d+ MiB$/m);
});

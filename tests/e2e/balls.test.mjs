/** More balls than memory is for: read from a file, tile by tile, with the bits of balls in memory. */
import assert from 'node:assert/strict';
import { createWriteStream } from 'node:fs';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { finished } from 'node:stream/promises';
import { after, before, test } from 'node:test';
import { hoodoo, makeFolder, removeFolder, seededRandom } from './hoodoo.mjs';

const count = 1_200_000, side = 100_000;   // [m]
const allowance = 256;                     // [MiB] that a bake may take beside its --memory
let folder;

/** Balls of 20 to 60 m over the sample's land, most of them in the ground. */
async function writeBalls(file) {
  const random = seededRandom(11), out = createWriteStream(file);
  out.write('x,y,z,radius\n');
  for (let i = 0; i < count; i += 10_000) {
    const rows = Array.from({ length: 10_000 }, () =>
      `${(side * random()).toFixed(2)},${(side * random()).toFixed(2)},${(120 * random()).toFixed(2)},${(20 + 40 * random()).toFixed(2)}`);
    if (!out.write(`${rows.join('\n')}\n`)) await new Promise((next) => out.once('drain', next));
  }
  out.end();
  await finished(out);
}

before(async () => {
  folder = await makeFolder();
  const made = await hoodoo(['synthesize', join(folder, 'dem.tif'), '--pixels', '500', '--spacing', String(side / 500)]);
  assert.equal(made.code, 0, made.stderr);
  await writeBalls(join(folder, 'balls.csv'));
  const scene = {
    hoodoo: 1, terrains: [{ dem: 'dem.tif' }],
    operations: [{ op: 'union', tree: { type: 'spheres', falloff: 30, file: 'balls.csv' } }],
    bake: { spacing: 25, tile_cells: 128, levels: 3 },
  };
  await writeFile(join(folder, 'scene.json'), JSON.stringify(scene));
});
after(() => removeFolder(folder));

/** One tile baked alone. */
async function bakeOne(name, memory) {
  const out = join(folder, name);
  const shard = ['--only', '0/10/15'];
  const result = await hoodoo(['--json', 'bake', join(folder, 'scene.json'), '-o', out, ...shard,
                               '--memory', String(memory), '--threads', '2', '--progress', 'off']);
  assert.equal(result.code, 0, result.stderr);
  const { tiles } = JSON.parse(await readFile(join(out, 'bake.json'), 'utf8'));
  assert.equal(tiles.length, 1);
  return { ...result, tile: tiles[0] };
}

test('A tile of a million balls is baked in little memory, to the same bits', async (t) => {
  const disk = await bakeOne('disk', 64), memory = await bakeOne('memory', 4096);
  t.diagnostic(`peak ${disk.peak.toFixed(0)} MiB of --memory 64 in ${disk.seconds.toFixed(1)} s, ` +
               `${memory.peak.toFixed(0)} MiB of 4096 in ${memory.seconds.toFixed(1)} s`);
  assert.ok(disk.peak <= 64 + allowance, `${disk.peak} MiB`);
  assert.ok(disk.tile.triangles > 1000, `${disk.tile.triangles} triangles`);
  assert.deepEqual(disk.tile, memory.tile);
});

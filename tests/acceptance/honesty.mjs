/**
 * Is the stated geometricError the truth? Bakes eight scenes, measures every tile above the leaves against the leaves'
 * own surface (hoodoo_honesty), and prints a Markdown table; ends with 1 when a tile is farther off than it says, or
 * tiles state more than three times their distance at the median.
 *
 *     node honesty.mjs [NAME ...] [--keep DIR]
 *
 * HOODOO_HONESTY is the program, by default of the release preset.
 */
import { copyFile, mkdir, writeFile } from 'node:fs/promises';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';
import { example, hoodoo, makeFolder, removeFolder, run, testData } from '../e2e/hoodoo.mjs';
import { scenes } from './scenes.mjs';

const program = process.env.HOODOO_HONESTY ?? resolve(import.meta.dirname, '../../build/release/tests/acceptance/hoodoo_honesty');

const all = {
  ...scenes,
  'first light': async (folder) => {
    await copyFile(join(example, 'scene.json'), join(folder, 'scene.json'));
    const made = await hoodoo(['synthesize', join(folder, 'dem.tif')]);
    if (made.code !== 0) throw new Error(made.stderr);
    return {};
  },
  mountains: async (folder) => {
    const dem = 'mongon_31m_utm17s_f32.tif';
    await copyFile(join(testData, 'dem', dem), join(folder, dem));
    return { scene: { hoodoo: 1, name: 'mountains', terrains: [{ dem }], operations: [], bake: { tile_cells: 32 } } };
  },
};

const { positionals: wanted, values: options } = parseArgs({ allowPositionals: true, options: { keep: { type: 'string' } } });
const names = Object.keys(all).filter((name) => wanted.length === 0 || wanted.some((part) => name.includes(part)));
if (names.length === 0) throw new Error(`no such scene, only ${Object.keys(all).join(', ')}`);
console.log('| scene | bake | tiles above the leaves | max true / stated | median stated / true | result |');
console.log('|---|---|---|---|---|---|');
let failed = 0;
for (const name of names) {
  const folder = options.keep ? join(resolve(options.keep), name.replaceAll(' ', '-')) : await makeFolder();
  await mkdir(folder, { recursive: true });
  try {
    const { scene } = await all[name](folder);
    if (scene) await writeFile(join(folder, 'scene.json'), JSON.stringify(scene, null, 1));
    const baked = await hoodoo(['bake', join(folder, 'scene.json'), '-o', join(folder, 'tileset'), '--progress', 'off']);
    if (baked.code !== 0) throw new Error(`bake: ${baked.stderr}`);
    const { code, stdout, stderr } = await run(program, [join(folder, 'tileset')]);
    if (!stdout) throw new Error(stderr);
    const found = JSON.parse(stdout);
    failed += code === 0 ? 0 : 1;
    console.log(`| ${name} | ${baked.seconds.toFixed(1)} s | ${found.tiles} | ${found.maxTrueOverStated} | ${found.medianStatedOverTrue} | ${found.good ? 'passes' : 'fails'} |`);
  } catch (problem) {
    ++failed;
    console.log(`| ${name} | ${problem.message.trim().replaceAll('\n', ' ')} |`);
  } finally {
    if (!options.keep) await removeFolder(folder);
  }
}
process.exit(failed === 0 ? 0 : 1);

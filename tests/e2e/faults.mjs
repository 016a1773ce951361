/** What tests of faults begin with: two scenes of one world and the files of calm bakes of them, and how a bake is to end. */
import assert from 'node:assert/strict';
import { stat, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { assertLoadable } from './folder.mjs';
import { digests, hoodoo, makeFolder, synthesize, withFolder } from './hoodoo.mjs';

export const page = 4096;   // bytes, of a disk in memory

export const sceneOf = (spacing, dem = 'dem.tif') => ({
  hoodoo: 1,
  terrains: [{ id: 'land', dem, falloff: 8 }],
  operations: [{ op: 'union', tree: { type: 'sphere', center: { uv: [0.5, 0.5], ground: 0 }, radius: 30, falloff: 8 } }],
  bake: { spacing, tile_cells: 64 },
});

/** Writes a scene as NAME.json; gives the file. */
export async function write(folder, name, content) {
  const file = join(folder, `${name}.json`);
  await writeFile(file, JSON.stringify(content));
  return file;
}

export async function bake(scene, folder, args = []) {
  const result = await hoodoo(['bake', scene, '-o', folder, '--json', ...args]);
  assert.equal(result.code, 0, `${result.signal}: ${result.stderr}`);
  return JSON.parse(result.stdout);
}

/** The files of a calm bake: {name: digest}. */
export const calmBake = (scene) => withFolder(async (folder) => {
  await bake(scene, join(folder, 'out'));
  return digests(join(folder, 'out'));
});

/** A bake that ends with `code` and a message. */
export async function refused(scene, folder, code, message, args = [], options = {}) {
  const result = await hoodoo(['bake', scene, '-o', folder, ...args], options);
  assert.equal(result.code, code, `${result.signal}: ${result.stderr}`);
  assert.match(result.stderr, message);
  return result;
}

/** A folder `work` with dem.tif; `coarse` and `fine`: {scene, files: {name: digest}, pages: {name: how many}}. */
export async function makeWorld() {
  const work = await makeFolder();
  await synthesize(join(work, 'dem.tif'));
  const baked = (name, spacing) => withFolder(async (folder) => {
    const scene = await write(work, name, sceneOf(spacing));
    await bake(scene, folder);
    const files = await digests(folder);
    const pages = await Promise.all(Object.keys(files).map(async (file) => [file, Math.ceil((await stat(join(folder, file))).size / page)]));
    return { scene, files, pages: Object.fromEntries(pages) };
  });
  return { work, coarse: await baked('coarse', 16), fine: await baked('fine', 2) };
}

/** The folder holds a finished bake's files as they were, and no temporary. */
export async function assertIntact(folder, files) {
  const now = await digests(folder);
  for (const [name, digest] of Object.entries(files)) assert.equal(now[name], digest, `${name} is as it was`);
  assert.deepEqual(Object.keys(now).filter((name) => name.includes('.part')), []);
  await assertLoadable(folder);
}

/** What a finished bake's folder may hold: what its index names, and nothing else. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFile, readdir } from 'node:fs/promises';
import { basename, dirname, join, relative } from 'node:path';

export const json = async (file) => JSON.parse(await readFile(file, 'utf8'));

/** Paths of all files below `folder`, relative to it. */
export async function filesBelow(folder) {
  const entries = await readdir(folder, { recursive: true, withFileTypes: true });
  return entries.filter((entry) => !entry.isDirectory())
    .map((entry) => relative(folder, join(entry.parentPath, entry.name))).sort();
}

/** All that `tileset.json` leads to, itself too: external tilesets and tiles. */
export async function reachable(folder) {
  const found = new Set();
  const follow = async (name) => {
    if (found.has(name)) return;
    found.add(name);
    if (!name.endsWith('.json')) return;
    const waiting = [(await json(join(folder, name))).root];
    while (waiting.length > 0) {
      const tile = waiting.pop();
      waiting.push(...tile.children ?? []);
      for (const { uri } of [...tile.content ? [tile.content] : [], ...tile.contents ?? []]) {
        await follow(join(dirname(name), uri));
      }
    }
  };
  await follow('tileset.json');
  return found;
}

/**
 * All that the index of a folder names: what a viewer loads, `bake.json`, one record per slice, the chunks of the
 * elevations, and the locks by which runs take turns.
 */
export async function named(folder) {
  const bake = await json(join(folder, 'bake.json'));
  const names = await reachable(folder);
  for (const name of ['bake.json', '.hoodoo/use.lock', '.hoodoo/index.lock']) names.add(name);
  for (const { slice } of bake.tiles) names.add(`.hoodoo/tiles/${slice.slice(0, 2)}/${slice}.json`);
  for (const digest of bake.elevations) {
    const place = `.hoodoo/elevations/${digest}`;
    const { levels } = await json(join(folder, place, 'pyramid.json'));
    for (const name of ['.lock', '/pyramid.json', '/chunks.bin', ...levels.map((_, i) => `/level_${i}.f32`)]) {
      names.add(place + name);
    }
  }
  return names;
}

/** The folder of a finished bake holds what its index names, no more and no less. */
export async function assertNoOrphans(folder) {
  assert.deepEqual(await filesBelow(folder), [...await named(folder)].sort());
}

/** What `tileset.json` leads to is there, and every tile is what its name says. Gives how many files that are. */
export async function assertLoadable(folder) {
  const names = await reachable(folder);
  for (const name of names) {
    const bytes = await readFile(join(folder, name));
    if (!name.endsWith('.glb')) continue;
    assert.equal(createHash('sha256').update(bytes).digest('hex'), basename(name, '.glb'), name);
  }
  return names.size;
}

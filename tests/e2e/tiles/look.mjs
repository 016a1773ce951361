/** What a viewer needs to know of a tileset on disk. */
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';

/** Root box and transform, the files of each level from the leaves on, and the level of each file, of the tileset in `folder`. */
export async function lookInto(folder) {
  const bake = JSON.parse(await readFile(join(folder, 'bake.json'), 'utf8'));
  const levels = new Map();
  const files = [];
  for (const { key, content, contents } of bake.tiles) {
    const level = Number(key.split('/')[0]);
    for (const file of contents ?? (content ? [{ content }] : [])) {
      levels.set(`${file.content}.glb`, level);
      (files[level] ??= []).push(`tiles/${file.content.slice(0, 2)}/${file.content}.glb`);
    }
  }
  const { root } = JSON.parse(await readFile(join(folder, 'tileset.json'), 'utf8'));
  return { box: root.boundingVolume.box, files, levels, transform: root.transform };
}

/** The tree of a tileset: follows tileset.json and the external tilesets it names. */
import { readFile } from 'node:fs/promises';
import { dirname, join, relative } from 'node:path';

const readJson = async (file) => JSON.parse(await readFile(file, 'utf8'));

/**
 * Every content of the tileset in `folder`: {file, boxes: own, parent's ... root's as [center, half]}, the
 * number of tileset files, and what is wrong with the tree.
 */
export async function readTileset(folder) {
  const problems = [], contents = [], named = new Set();
  let tilesets = 0, tiles = 0;

  /** `parent`: {box, error, boxes} of the tile above; `pointer`: the tile naming this external tileset. */
  async function walk(tile, file, where, parent, pointer) {
    const say = (what) => problems.push(`${relative(folder, file)}${where}: ${what}`);
    const error = tile.geometricError;
    if (!(error >= 0 && Number.isFinite(error))) say(`has the geometricError ${error}`);
    if (tile.transform && (parent || pointer)) say('has a transform');
    if (tile.refine !== undefined && tile.refine !== 'REPLACE') say(`refines by ${tile.refine}`);
    const box = axisBox(tile.boundingVolume?.box);
    if (!box) say('has no box along the axes');
    const above = pointer ?? parent;
    // An external root repeats the tile that names it; every other tile is finer than its parent.
    if (pointer ? error > pointer.error : parent && !(error < parent.error)) {
      say(`has the geometricError ${error}, its parent ${above.error}`);
    }
    const own = { error, boxes: [box ?? [[0, 0, 0], [0, 0, 0]], ...(above?.boxes ?? [])] };
    if (tile.contents?.length > 1) say('has several contents, which most viewers do not show');
    const uris = [tile.content, ...(tile.contents ?? [])].filter(Boolean).map((c) => c.uri);
    for (const uri of uris) {
      const target = join(dirname(file), decodeURIComponent(uri));
      if (named.has(target)) say(`names ${uri} again`);
      named.add(target);
      if (uri.endsWith('.json')) await open(target, own);
      else contents.push({ file: target, boxes: own.boxes, error });
    }
    if (!uris.some((uri) => uri.endsWith('.json'))) {
      tiles += uris.length > 0 ? 1 : 0;
      if (!tile.children?.length && error !== 0) say(`is a leaf with the geometricError ${error}`);
    } else if (tile.children?.length) say('has children beside its external tileset');
    for (const [i, child] of (tile.children ?? []).entries()) {
      await walk(child, file, `${where}/children/${i}`, own, null);
    }
  }

  async function open(file, pointer) {
    ++tilesets;
    const tileset = await readJson(file);
    if (tileset.asset?.version !== '1.1') problems.push(`${relative(folder, file)}: is no 3D Tiles 1.1`);
    if (!(tileset.geometricError >= tileset.root.geometricError)) {
      problems.push(`${relative(folder, file)}: its geometricError is below its root's`);
    }
    await walk(tileset.root, file, '/root', null, pointer);
  }

  await open(join(folder, 'tileset.json'), null);
  return { contents, problems, tilesets, tiles };
}

/** [center, half size] of a box along the axes. */
function axisBox(box) {
  if (box?.length !== 12 || !box.every(Number.isFinite)) return null;
  const axes = [box.slice(3, 6), box.slice(6, 9), box.slice(9, 12)];
  if (axes.some((axis, a) => axis.some((value, b) => a !== b && value !== 0))) return null;
  return [box.slice(0, 3), axes.map((axis, a) => Math.abs(axis[a]))];
}

/** What bake.json says: the lattice [m], and each tile that has a surface, by content digest. */
export async function readBake(folder) {
  const bake = await readJson(join(folder, 'bake.json'));
  const { spacing, step, tile_cells: cells } = bake.lattice;
  const records = new Map();
  for (const tile of bake.tiles) {
    const [level, x, y] = tile.key.split('/').map(Number);
    if (tile.content) records.set(tile.content, { ...tile, key: { level, x, y }, name: tile.key });
  }
  return { spacing, step, cells, records };
}

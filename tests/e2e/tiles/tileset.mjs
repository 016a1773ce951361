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
    const listed = [tile.content, ...(tile.contents ?? [])].filter(Boolean);
    const uris = listed.map((c) => c.uri);
    if (tile.contents && (tile.content || tile.contents.length < 2)) say('has contents where it should have one');
    for (const { uri, boundingVolume } of listed) {
      const target = join(dirname(file), decodeURIComponent(uri));
      if (named.has(target)) say(`names ${uri} again`);
      named.add(target);
      if (uri.endsWith('.json')) await open(target, own);
      else contents.push({ file: target, boxes: boundingVolume ? [axisBox(boundingVolume.box), ...own.boxes] : own.boxes, error });
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

/** bake.json in either form: one document, or a header and then one line per planned tile. */
export async function readIndex(folder) {
  const text = await readFile(join(folder, 'bake.json'), 'utf8');
  const end = text.indexOf('\n');
  const first = text.slice(0, end < 0 ? undefined : end);
  if (!first.startsWith('{') || !first.endsWith('}') || first.includes('"tiles":')) return JSON.parse(text);
  const lines = text.slice(end + 1).split('\n').filter(Boolean).map((line) => JSON.parse(line));
  return { ...JSON.parse(first), tiles: lines.filter(({ missing }) => !missing),
           missing: lines.filter(({ missing }) => missing).map(({ key }) => key) };
}

/**
 * What bake.json says: the lattice [m], by how many levels each level is sampled finer, and each tile that has a
 * surface, by content digest. A slab of a tile has the tile's record with its own counts; the world's edges are the
 * first one's.
 */
export async function readBake(folder) {
  const bake = await readIndex(folder);
  const { spacing, step, tile_cells: cells, finer = [] } = bake.lattice;
  const records = new Map();
  for (const tile of bake.tiles) {
    const [level, x, y] = tile.key.split('/').map(Number);
    const files = tile.contents ?? (tile.content ? [tile] : []);
    files.forEach((file, i) => records.set(file.content, {
      ...tile, ...file, key: { level, x, y }, name: tile.key, slabs: files.length, world_edges: i === 0 ? tile.world_edges : 0,
    }));
  }
  return { spacing, step, cells, finer, records };
}

/** A small tileset made here, sound unless told otherwise, for the test of the checker. */
import { createHash } from 'node:crypto';
import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';

const cells = 16, spacing = 1, step = 1 / 256;

/** The ground: a hill over 2 x 2 tiles. `s` is the lattice's spacing; heights are whole steps of it. */
const height = (x, y, s) => Math.round((8 + 3 * Math.sin(x / 5) * Math.cos(y / 7)) / (step * s)) * step * s;
const normal = (x, y) => {
  const n = [-0.1 * Math.sin(x), -0.1 * Math.cos(y), 1], length = Math.hypot(...n);
  return n.map((v) => v / length);
};

/** One tile's surface and skirt of its eastern border, z up, metres from the tile's corner. */
function ground({ level, x, y }) {
  const s = spacing * 2 ** level, west = x * cells * s, south = y * cells * s;
  const surface = { points: [], normals: [], ids: [], triangles: [] };
  const at = (i, j) => i + j * (cells + 1);
  for (let j = 0; j <= cells; ++j) {
    for (let i = 0; i <= cells; ++i) {
      surface.points.push([i * s, j * s, height(west + i * s, south + j * s, s)]);
      surface.normals.push(normal(west + i * s, south + j * s));
      surface.ids.push(1);
      if (i < cells && j < cells) {
        surface.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
      }
    }
  }
  const skirt = { points: [], normals: [], ids: [], triangles: [] };
  for (let j = 0; j <= cells; ++j) {
    const [px, py, pz] = surface.points[at(cells, j)];
    skirt.points.push([px, py, pz], [px, py, pz - s]);
    skirt.normals.push([1, 0, 0], [1, 0, 0]);
    skirt.ids.push(0, 0);
    if (j < cells) skirt.triangles.push([2 * j, 2 * j + 1, 2 * j + 3], [2 * j, 2 * j + 3, 2 * j + 2]);
  }
  return { origin: [west, south, 0], surface, skirt };
}

const bounds = (points) => [0, 1, 2].map((a) => [Math.min(...points.map((p) => p[a])), Math.max(...points.map((p) => p[a]))]);

/** A plain binary glTF with the extensions hoodoo writes. */
function toGlb({ origin, surface, skirt }) {
  const chunks = [], json = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], meshes: [{ primitives: [] }], accessors: [],
    bufferViews: [], nodes: [{ mesh: 0, translation: [origin[0], origin[2], -origin[1]] }],
    extensionsUsed: ['EXT_mesh_features', 'EXT_structural_metadata'],
  };
  let size = 0;
  const view = (array, extra = {}) => {
    const bytes = Buffer.alloc(Math.ceil(array.byteLength / 8) * 8);
    Buffer.from(array.buffer, array.byteOffset, array.byteLength).copy(bytes);
    json.bufferViews.push({ buffer: 0, byteOffset: size, byteLength: array.byteLength, ...extra });
    chunks.push(bytes);
    size += bytes.length;
    return json.bufferViews.length - 1;
  };
  const accessor = (array, type, componentType, width, target, extra) => {
    json.accessors.push({ bufferView: view(array, { target }), type, componentType, count: array.length / width, ...extra });
    return json.accessors.length - 1;
  };
  const up = ([x, y, z]) => [x, z, -y];
  for (const part of [surface, skirt]) {
    const points = part.points.map(up), box = bounds(points);
    const primitive = {
      indices: accessor(Uint32Array.from(part.triangles.flat()), 'SCALAR', 5125, 1, 34963),
      attributes: {
        POSITION: accessor(Float32Array.from(points.flat()), 'VEC3', 5126, 3, 34962,
                           { min: box.map((b) => b[0]), max: box.map((b) => b[1]) }),
        NORMAL: accessor(Float32Array.from(part.normals.map(up).flat()), 'VEC3', 5126, 3, 34962),
        _FEATURE_ID_0: accessor(Float32Array.from(part.ids), 'SCALAR', 5126, 1, 34962),
      },
      extensions: {
        EXT_mesh_features: { featureIds: [{ featureCount: new Set(part.ids).size, attribute: 0, propertyTable: 0 }] },
      },
    };
    if (part === skirt) primitive.extras = { hoodoo: { role: 'skirt' } };
    json.meshes[0].primitives.push(primitive);
  }
  json.extensions = {
    EXT_structural_metadata: {
      schema: { id: 's', classes: { material: { properties: { name: { type: 'STRING' } } } } },
      propertyTables: [{
        class: 'material', count: 2,
        properties: { name: { values: view(Buffer.from('skirtrock')), stringOffsets: view(Uint32Array.of(0, 5, 9)) } },
      }],
    },
  };
  json.buffers = [{ byteLength: size }];
  let text = JSON.stringify(json);
  text += ' '.repeat((4 - (text.length % 4)) % 4);
  const header = Buffer.alloc(20), binary = Buffer.alloc(8);
  header.write('glTF');
  header.writeUInt32LE(2, 4);
  header.writeUInt32LE(28 + text.length + size, 8);
  header.writeUInt32LE(text.length, 12);
  header.write('JSON', 16);
  binary.writeUInt32LE(size, 0);
  binary.write('BIN\0', 4);
  return Buffer.concat([header, Buffer.from(text), binary, ...chunks]);
}

/**
 * Writes two levels of 2 x 2 tiles into `folder`. `spoil.tile(key, content)` may change a tile's content before
 * it is written, `spoil.tree(tileset)` and `spoil.bake(bake)` the index.
 */
export async function makeTileset(folder, spoil = {}) {
  await mkdir(join(folder, 'tiles'), { recursive: true });
  const bake = { lattice: { spacing, step, tile_cells: cells }, tiles: [] };
  const write = async (level, x, y, geometricError, children) => {
    const key = `${level}/${x}/${y}`, content = ground({ level, x, y });
    const box = bounds([...content.surface.points, ...content.skirt.points]
      .map((p) => p.map((v, a) => v + content.origin[a])));
    spoil.tile?.(key, content);
    const bytes = toGlb(content), digest = createHash('sha256').update(bytes).digest('hex');
    await writeFile(join(folder, 'tiles', `${digest}.glb`), bytes);
    const { surface, skirt, origin } = content, all = bounds([...surface.points, ...skirt.points]);
    bake.tiles.push({
      key, content: digest, bytes: bytes.length, vertices: surface.points.length + skirt.points.length,
      triangles: surface.triangles.length, skirt_triangles: skirt.triangles.length,
      world_edges: level === 0 ? 2 * cells : 4 * cells, materials: { rock: surface.triangles.length },
      box: [0, 1].flatMap((end) => all.map((b, a) => b[end] + origin[a])),
    });
    return { key, geometricError, box, content: { uri: `tiles/${digest}.glb` }, ...children };
  };
  const leaves = [];
  for (const [x, y] of [[0, 0], [1, 0], [0, 1], [1, 1]]) leaves.push(await write(0, x, y, 0));
  const root = await write(1, 0, 0, 4, { children: leaves });
  root.box = bounds([root, ...leaves].flatMap((t) => [t.box.map((b) => b[0]), t.box.map((b) => b[1])]));
  const finish = ({ key, box, ...tile }) => {
    const [center, half] = [box.map(([l, h]) => (l + h) / 2), box.map(([l, h]) => (h - l) / 2)];
    tile.boundingVolume = { box: [...center, half[0], 0, 0, 0, half[1], 0, 0, 0, half[2]] };
    tile.children = tile.children?.map(finish);
    return tile;
  };
  const tileset = { asset: { version: '1.1' }, geometricError: 100, root: { ...finish(root), refine: 'REPLACE' } };
  spoil.tree?.(tileset);
  spoil.bake?.(bake);
  await writeFile(join(folder, 'tileset.json'), JSON.stringify(tileset));
  await writeFile(join(folder, 'bake.json'), JSON.stringify(bake));
}

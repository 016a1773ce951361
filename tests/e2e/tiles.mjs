/**
 * Checks a finished tileset with tools that hoodoo did not write: gltf-validator, gltf-transform, draco3d.
 *
 *     node tiles.mjs DIR [--workers N]
 *
 * Prints one line of JSON with what was counted and found; exits with 1 when anything is wrong.
 */
import { basename, relative, resolve } from 'node:path';
import { parseArgs } from 'node:util';
import { pathToFileURL } from 'node:url';
import { Pool } from './tiles/pool.mjs';
import { readBake, readTileset } from './tiles/tileset.mjs';
import { Level } from './tiles/weld.mjs';

const mostProblems = 50;   // in words; the rest is counted

/** What must not be there in a welded level, in words. */
const faults = {
  degenerate: 'triangles without area',
  duplicate: 'triangles that repeat another',
  overused: 'edges with more than two faces',
  turned: 'edges whose two faces are turned against each other',
  pinched: 'vertices where the surface touches itself',
  openOffLattice: "open edges that lie in no plane of the lattice, so not on the world's edge",
  cracks: 'lattice columns between two tiles with an open edge on both sides',
  positionMismatches: 'border vertices without a partner in the neighbouring tile',
  normalMismatches: 'border vertices whose partner has another normal',
};

/** Checks the tileset in `folder`; `workers` threads decode. */
export async function check(folder, { workers } = {}) {
  const { spacing, step, cells, finer, records } = await readBake(folder);
  const { contents, problems, tilesets, tiles } = await readTileset(folder);
  const total = {
    tiles, tilesets, contents: contents.length, bytes: 0, vertices: 0, triangles: 0, skirtTriangles: 0,
    validatorIssues: 0, borderVertices: 0, openEdges: 0, openInside: 0, euler: {}, materials: {},
  };
  for (const name of Object.keys(faults)) total[name] = 0;

  const levels = new Map(), listed = new Set();
  for (const content of contents) {
    const digest = basename(content.file, '.glb'), record = records.get(digest);
    listed.add(digest);
    if (!record) problems.push(`${relative(folder, content.file)}: bake.json does not know it`);
    else levels.set(record.key.level, [...(levels.get(record.key.level) ?? []), { ...content, record }]);
  }
  for (const [digest, { name }] of records) {
    if (!listed.has(digest)) problems.push(`bake.json: tile ${name} is in no tileset`);
  }

  const pool = new Pool(workers);
  try {
    for (const [number, members] of [...levels].sort(([a], [b]) => a - b)) {
      const by = finer[number] ?? 0, scale = 2 ** (number - by);
      const lattice = { spacing: spacing * scale, step: step * scale, cells: cells * 2 ** by };
      const level = new Level(Math.round(spacing / step), lattice.cells);
      const materials = new Map();   // of tiles in slabs, by name
      await Promise.all(members.map(async ({ file, boxes, record }) => {
        const result = await pool.run({ file, boxes, key: record.key, ...lattice });
        const name = `${relative(folder, file)} (${record.name})`;
        if (result.failed) {
          problems.push(`${name}: ${result.failed}`);
          return;
        }
        problems.push(...[...result.problems, ...against(record, result)].map((what) => `${name}: ${what}`));
        addTo(total, result);
        level.add(result);
        if (record.slabs > 1) addMaterials(materials, record, result);
      }));
      for (const [name, { found, stated }] of materials) {
        problems.push(...differences(found, stated).map((what) => `tile ${name}: ${what}`));
      }
      const worldEdges = members.reduce((sum, { record }) => sum + record.world_edges, 0);
      report(number, level.finish(), worldEdges, total, problems);
    }
  } finally {
    await pool.close();
  }
  total.problemCount = problems.length;
  total.problems = problems.slice(0, mostProblems);
  return total;
}

/** Where bake.json says other than the file. */
function against(record, result) {
  const box = [...result.box.low, ...result.box.high];
  const counted = {
    bytes: result.bytes, triangles: result.triangles.length / 3, skirt_triangles: result.skirtTriangles,
    vertices: result.steps.length / 3 + result.skirtVertices,
  };
  const differing = Object.keys(counted).filter((name) => record[name] !== counted[name])
    .map((name) => `has ${counted[name]} ${name}, bake.json says ${record[name]}`);
  if (box.some((value, i) => value !== record.box[i])) differing.push(`fills [${box}], bake.json says [${record.box}]`);
  return record.slabs > 1 ? differing : [...differing, ...differences(result.materials, record.materials)];
}

/** Where triangles by material are others than stated. */
function differences(found, stated) {
  return [...new Set([...Object.keys(stated), ...Object.keys(found)])].filter((name) => found[name] !== stated[name])
    .map((name) => `has ${found[name]} triangles of ${name}, bake.json says ${stated[name]}`);
}

/** bake.json counts those of a tile, not of its slabs. */
function addMaterials(materials, record, result) {
  const sum = materials.get(record.name) ?? { found: {}, stated: record.materials };
  for (const [name, count] of Object.entries(result.materials)) sum.found[name] = (sum.found[name] ?? 0) + count;
  materials.set(record.name, sum);
}

function addTo(total, result) {
  total.bytes += result.bytes;
  total.vertices += result.steps.length / 3 + result.skirtVertices;
  total.triangles += result.triangles.length / 3;
  total.skirtTriangles += result.skirtTriangles;
  total.validatorIssues += result.validator;
  for (const [name, count] of Object.entries(result.materials)) {
    total.materials[name] = (total.materials[name] ?? 0) + count;
  }
}

function report(number, found, worldEdges, total, problems) {
  for (const [name, what] of Object.entries(faults)) {
    total[name] += found[name];
    if (found[name] > 0) problems.push(`level ${number}: ${found[name]} ${what}`);
  }
  // Each tile knows the world's edge from the elevations alone, whatever its neighbours are.
  if (found.openEdges !== worldEdges) {
    problems.push(`level ${number}: ${found.openEdges} open edges, ${worldEdges} of them the world's by bake.json`);
  }
  total.borderVertices += found.borderVertices;
  total.openEdges += found.openEdges;
  total.openInside += found.openInside;
  total.euler[number] = found.euler;
  (total.components ??= {})[number] = found.components;
  (total.rims ??= {})[number] = found.openLoops;
}

if (process.argv[1] && import.meta.url === pathToFileURL(resolve(process.argv[1])).href) {
  const { positionals, values } = parseArgs({ allowPositionals: true, options: { workers: { type: 'string' } } });
  if (positionals.length !== 1) {
    console.error('usage: node tiles.mjs DIR [--workers N]');
    process.exit(2);
  }
  const found = await check(positionals[0], { workers: values.workers && Number(values.workers) });
  console.log(JSON.stringify(found));
  process.exit(found.problemCount === 0 ? 0 : 1);
}

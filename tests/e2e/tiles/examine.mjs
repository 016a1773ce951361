/** A worker: reads one content of a tile and checks all that can be checked without its neighbours. */
import { parentPort } from 'node:worker_threads';
import { basename } from 'node:path';
import { readContent } from './content.mjs';

const boxSlack = 1e-9;   // of a box's half axis: the rounding of centre plus and minus half

parentPort?.on('message', async ({ ticket, job }) => {
  try {
    const { result, transfer } = await examine(job);
    parentPort.postMessage({ ticket, result }, transfer);
  } catch (error) {
    parentPort.postMessage({ ticket, result: { failed: error.message } });
  }
});

/**
 * `job`: {file, key: {level, x, y}, spacing [m], step [m], cells, boxes: of the tile and its ancestors}.
 * Gives counts and problems, and the surface in whole steps of the scene frame (z up).
 */
export async function examine(job) {
  const content = await readContent(job.file);
  const problems = content.issues.slice();
  const validator = problems.filter((p) => p.startsWith('gltf-validator')).length;
  if (basename(job.file, '.glb') !== content.digest) problems.push('is not named by its SHA-256');

  const size = Math.round(job.cells * job.spacing / job.step);
  const area = { west: job.key.x * size, east: (job.key.x + 1) * size, south: job.key.y * size, north: (job.key.y + 1) * size };
  const box = { low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] };
  const surfaces = content.parts.filter((part) => !part.skirt);
  if (surfaces.length !== 1) problems.push(`has ${surfaces.length} surfaces`);
  const steps = new Map();
  for (const part of content.parts) {
    steps.set(part, toSteps(part, job.step, box, problems));
    checkMaterials(part, content.materials.length, problems);
  }
  for (const [level, [center, half]] of job.boxes.entries()) checkBox(box, center, half, level, problems);

  const surface = surfaces[0];
  const result = {
    problems, validator, bytes: content.bytes, digest: content.digest, box,
    skirtTriangles: 0, skirtVertices: 0, materials: {},
    x: job.key.x, y: job.key.y, steps: new Int32Array(), triangles: new Uint32Array(),
  };
  for (const part of content.parts.filter((p) => p.skirt)) {
    result.skirtTriangles += part.triangles.length / 3;
    result.skirtVertices += part.positions.length / 3;
    checkSkirt(steps.get(part), part.triangles, area, problems);
  }
  if (surface) {
    result.steps = steps.get(surface);
    result.triangles = surface.triangles;
    for (let i = 0; i < surface.triangles.length; i += 3) {
      const name = content.materials[surface.ids[surface.triangles[i]]] ?? '?';
      result.materials[name] = (result.materials[name] ?? 0) + 1;
    }
  }
  result.borders = bordersOf(result.steps, surface, area, problems);
  const transfer = new Set([result.steps.buffer, result.triangles.buffer]);
  for (const side of Object.values(result.borders)) {
    transfer.add(side.vertices.buffer).add(side.normals.buffer);
  }
  return { result, transfer: [...transfer] };
}

/** Vertices in whole steps, z up; widens `box` [m]. */
function toSteps({ positions, translation }, step, box, problems) {
  const steps = new Int32Array(positions.length);
  let off = 0;
  for (let i = 0; i < positions.length; i += 3) {
    const x = translation[0] + positions[i], y = translation[1] + positions[i + 1], z = translation[2] + positions[i + 2];
    const at = [x, -z, y];
    for (let a = 0; a < 3; ++a) {
      const whole = at[a] / step;   // exact: a step is a power of two
      if (!Number.isInteger(whole)) ++off;
      steps[i + a] = whole;
      if (at[a] < box.low[a]) box.low[a] = at[a];
      if (at[a] > box.high[a]) box.high[a] = at[a];
    }
  }
  if (off > 0) problems.push(`${off} coordinates are no multiple of the step ${step}`);
  return steps;
}

/** The content lies in the box of its tile (level 0 of `boxes`) and of every ancestor. */
function checkBox(box, center, half, level, problems) {
  for (let a = 0; a < 3; ++a) {
    const slack = boxSlack * (Math.abs(center[a]) + half[a] + 1);
    if (box.low[a] < center[a] - half[a] - slack || box.high[a] > center[a] + half[a] + slack) {
      const whose = level === 0 ? "its tile's box" : `the box of the tile ${level} above`;
      problems.push(`leaves ${whose} along ${'xyz'[a]}: [${box.low[a]}, ${box.high[a]}] in ` +
                    `[${center[a] - half[a]}, ${center[a] + half[a]}]`);
    }
  }
}

/** One known id per triangle, and the stated number of different ones. */
function checkMaterials({ ids, triangles, features, skirt }, table, problems) {
  const what = skirt ? 'skirt' : 'surface';
  let mixed = 0, unknown = 0;
  const seen = new Set();
  for (let i = 0; i < triangles.length; i += 3) {
    const id = ids[triangles[i]];
    if (ids[triangles[i + 1]] !== id || ids[triangles[i + 2]] !== id) ++mixed;
    if (!(id < table)) ++unknown;
    seen.add(id);
  }
  if (mixed > 0) problems.push(`${mixed} triangles of the ${what} have more than one material`);
  if (unknown > 0) problems.push(`${unknown} triangles of the ${what} have a material that no table lists`);
  if (features?.propertyTable !== 0 || features?.attribute !== 0) problems.push(`the ${what} names no materials`);
  if (features?.featureCount !== seen.size) {
    problems.push(`the ${what} states ${features?.featureCount} materials and has ${seen.size}`);
  }
}

/** Each triangle of a skirt lies in one border plane of its tile and faces out of it. */
function checkSkirt(steps, triangles, area, problems) {
  const planes = [[0, area.west, -1], [0, area.east, 1], [1, area.south, -1], [1, area.north, 1]];
  let off = 0, inward = 0;
  for (let i = 0; i < triangles.length; i += 3) {
    const corner = (n, a) => steps[3 * triangles[i + n] + a];
    const holds = planes.filter(([axis, value]) => [0, 1, 2].every((n) => corner(n, axis) === value));
    if (holds.length === 0) {
      ++off;
      continue;
    }
    const [axis, , out] = holds[0], u = (axis + 1) % 3, v = (axis + 2) % 3;
    const area2 = (corner(1, u) - corner(0, u)) * (corner(2, v) - corner(0, v)) -
                  (corner(1, v) - corner(0, v)) * (corner(2, u) - corner(0, u));
    if (area2 * out <= 0) ++inward;
  }
  if (off > 0) problems.push(`${off} triangles of the skirt leave the tile's border planes`);
  if (inward > 0) problems.push(`${inward} triangles of the skirt do not face out of the tile`);
}

/** The surface's vertices in each border plane, with the bits of their normals. */
function bordersOf(steps, surface, area, problems) {
  const normals = surface ? new Uint32Array(surface.normals.buffer) : new Uint32Array();
  const used = new Uint8Array(steps.length / 3);
  for (const vertex of surface?.triangles ?? []) used[vertex] = 1;
  const found = { west: [], east: [], south: [], north: [] };
  let outside = 0;
  for (let i = 0; i < used.length; ++i) {
    const x = steps[3 * i], y = steps[3 * i + 1];
    if (x < area.west || x > area.east || y < area.south || y > area.north) ++outside;
    if (!used[i]) continue;
    if (x === area.west) found.west.push(i);
    if (x === area.east) found.east.push(i);
    if (y === area.south) found.south.push(i);
    if (y === area.north) found.north.push(i);
  }
  if (outside > 0) problems.push(`${outside} vertices of the surface lie outside the tile's area`);
  return Object.fromEntries(Object.entries(found).map(([side, vertices]) => {
    const bits = new Uint32Array(3 * vertices.length);
    vertices.forEach((v, i) => bits.set(normals.subarray(3 * v, 3 * v + 3), 3 * i));
    return [side, { vertices: Uint32Array.from(vertices), normals: bits }];
  }));
}

/** hoodoo probe --explain: what it says at points of a small scene, against values worked out by hand. */
import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';

// A ball high over the sea, and a layer of hard rock through it.
const scene = {
  hoodoo: 1,
  materials: [{ name: 'soft', resistance: [0, 0.5] }, { name: 'hard', resistance: [0.5, 1] }, { name: 'ore', resistance: [1, 1] }],
  terrains: [{ id: 'land', dem: 'dem.tif', falloff: 8 }],
  geology: { type: 'plane', point: [0, 0, 200], normal: [0, 0, 1], falloff: 10, energy: 0.8 },
  operations: [
    { id: 'ball', op: 'union', tree: { type: 'sphere', center: [72, 72, 200], radius: 10, falloff: 8 } },
    { id: 'vein', op: 'blend', material: 'ore', tree: { type: 'point', center: [20, 20, 300], radius: 4.542, energy: 0.75 } },
  ],
  bake: { spacing: 1 },
};
const g = (r, R) => (r < R ? (1 - (r / R) ** 2) ** 3 : 0);
const slope = (r, R) => (r < R ? (-6 * r / R ** 2) * (1 - (r / R) ** 2) ** 2 : 0);
const shift = 0.4542 * 8;   // the ball's surface lies where F = 1/2

/** What each point has: F, its gradient, rho, the material, and what reaches the block around it beside the layer, which has no end. */
const expected = [
  { what: 'the middle of the ball', at: [72, 72, 200], field: 1, gradient: [0, 0, 0], resistance: 0.8,
    material: 'hard', nodes: ['union ball', '  sphere'] },
  { what: 'its surface in the east', at: [82, 72, 200], field: 0.5, gradient: [slope(shift, 8), 0, 0],
    resistance: 0.8, material: 'hard', nodes: ['union ball', '  sphere'] },
  { what: 'a point above it', at: [72, 72, 212], field: g(shift + 2, 8), gradient: [0, 0, slope(shift + 2, 8)],
    resistance: 0, material: 'soft', nodes: ['union ball', '  sphere'] },
  { what: 'half way through the layer', at: [72, 72, 205], field: 1, gradient: [0, 0, 0], resistance: 0.8 * 0.75 ** 3,
    material: 'soft', nodes: ['union ball', '  sphere'] },
  { what: 'beside the vein', at: [20, 25, 300], field: 0.75 * g(5, 10), gradient: [0, 0.75 * slope(5, 10), 0], resistance: 0,
    material: 'ore', nodes: ['blend vein', '  point'] },
  { what: 'air that nothing reaches', at: [20, 100, 300], field: 0, gradient: [0, 0, 0], resistance: 0, material: 'soft', nodes: [] },
  { what: 'rock deep below the sea', at: [20, 100, -200], field: 1, gradient: [0, 0, 0], resistance: 0, material: 'soft', nodes: ['terrain land'] },
];
const near = (found, wanted, what) => assert.ok(Math.abs(found - wanted) < 1e-4, `${what}: ${found}, not ${wanted}`);

let folder, lines;

before(async () => {
  folder = await makeFolder();
  const made = await hoodoo(['synthesize', join(folder, 'dem.tif'), '--pixels', '64', '--spacing', '2']);
  assert.equal(made.code, 0, made.stderr);
  await writeFile(join(folder, 'scene.json'), JSON.stringify(scene));
  await writeFile(join(folder, 'points.csv'), `x,y,z\n${expected.map(({ at }) => at.join(',')).join('\n')}\n`);
  const found = await hoodoo(['probe', join(folder, 'scene.json'), '--points', join(folder, 'points.csv'), '--explain']);
  assert.equal(found.code, 0, found.stderr);
  lines = found.stdout.trimEnd().split('\n');
});
after(() => removeFolder(folder));

/** The row of the n-th point, and the lines of its explanation. */
function answer(n) {
  const rows = lines.flatMap((line, i) => (i > 0 && !line.startsWith('#') ? [i] : []));
  assert.equal(rows.length, expected.length);
  const row = lines[rows[n]].split(',');
  return { row, nodes: lines.slice(rows[n] + 1, rows[n + 1]).map((line) => line.slice(2)) };
}

test('Its columns have names', () => {
  assert.equal(lines[0], 'x,y,z,field,gx,gy,gz,resistance,material');
});

expected.forEach(({ what, at, field, gradient, resistance, material, nodes }, n) => {
  test(`It knows ${what}`, () => {
    const { row, nodes: found } = answer(n);
    assert.deepEqual(row.slice(0, 3).map(Number), at);
    near(Number(row[3]), field, 'F');
    gradient.forEach((wanted, axis) => near(Number(row[4 + axis]), wanted, `gradient ${'xyz'[axis]}`));
    near(Number(row[7]), resistance, 'rho');
    assert.equal(row[8], material);
    assert.deepEqual(found, [...nodes, 'geology', '  plane']);
  });
});

test('It names the rock of a stratum where that prevails, moved by what moves the geology', async () => {
  const file = join(folder, 'strata.json'), points = join(folder, 'strata.csv');
  const seam = { type: 'stratum', name: 'seam', child: { type: 'plane', point: [0, 0, -200], normal: [0, 0, 1], falloff: 10, energy: 0.3 } };
  await writeFile(file, JSON.stringify({
    ...scene,
    materials: [{ name: 'rock' }, { name: 'coal', stratum: 'seam' }],
    geology: { type: 'fault', by: [0, 0, 40], child: { type: 'blend', children: [seam, { type: 'strata', wavelength: 7 }] },
               domain: { type: 'half_space', point: [60, 0, 0], normal: [-1, 0, 0], falloff: 0.1 } },
    operations: [],
  }));
  // Half of its peak lies at 4.542 m from the seam, which stands 40 m higher beyond x = 60.
  const at = [[20, 20, -200], [20, 20, -195.5], [20, 20, -195.4], [100, 20, -200], [100, 20, -160], [100, 20, -164.5]];
  await writeFile(points, `x,y,z\n${at.map((p) => p.join(',')).join('\n')}\n`);
  const found = await hoodoo(['probe', file, '--points', points]);
  assert.equal(found.code, 0, found.stderr);
  const rocks = found.stdout.trimEnd().split('\n').slice(1).map((line) => line.split(',')[8]);
  assert.deepEqual(rocks, ['coal', 'coal', 'rock', 'rock', 'coal', 'coal']);
});

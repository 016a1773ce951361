/**
 * The five scenes of Table 1 of Paris, Galin, Peytavie, Guérin and Gain 2019, of the same extents, grids' steps and kinds: made
 * on the coast of `hoodoo synthesize`, the canyon in gorges of its own, generated and baked with --stats, and printed beside the
 * paper's numbers. Run by hand; all five take some minutes and 1 GB of disk:
 *
 *     node table1.mjs DIR [NAME ...] [--nodes]
 *
 * DIR takes DEMs, scenes and tilesets; --nodes only counts what generators make. Goals: nodes within a fifth of the paper's;
 * generation in a fifth of its seconds; at most 0.8 of its memory; t0/t and #C0/#C at least its ratios. Exit 0 where all hold.
 * Of a block of 16 x 16 x 16 points those count whose row of sixteen along z a primitive reaches; the others have their elevations
 * alone. The last column is what the paper's bounds of columns would leave to ask.
 * The paper's times are of a Core i7 of 4 GHz, ours of the processor at hand; the grids differ in height, as the coast does.
 */
import { existsSync } from 'node:fs';
import { mkdir, writeFile } from 'node:fs/promises';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';
import { writeDem } from '../e2e/dem.mjs';
import { hoodoo } from '../e2e/hoodoo.mjs';

const { positionals, values: options } = parseArgs({ allowPositionals: true, options: { nodes: { type: 'boolean', default: false } } });
if (positionals.length === 0) throw new Error('usage: node table1.mjs DIR [NAME ...] [--nodes]');
const folder = resolve(positionals[0]), names = positionals.slice(1);

const beds = (wavelength, seed) => ({
  type: 'blend',
  children: [
    { type: 'warp', amplitude: wavelength / 6, wavelength: 3 * wavelength, child: { type: 'strata', wavelength, octaves: 3, seed, energy: 2 } },
    { type: 'expression', formula: '-0.5' },
  ],
});

/** Numbers in [0, 1) that are the same in every run. */
function* chances() {
  for (let state = 1; ;) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    yield state / 2 ** 32;
  }
}

/** A cave behind two doors under a skylight, by strokes of a few hundred points each. */
function strokes(count) {
  const chance = chances(), between = (a, b) => a + (b - a) * chance.next().value;
  const chamber = () => {
    const turn = between(0, 6.2832), up = between(-0.2, 0.9), out = 34 * Math.sqrt(1 - up * up);
    return [430 + out * Math.cos(turn), 200 + out * Math.sin(turn), 6 + 26 * up];
  };
  const door = (y) => () => [between(300, 420), y + between(-9, 9), between(0, 14)];
  const skylight = () => [430 + between(-9, 9), 200 + between(-9, 9), between(28, 130)];
  const notch = () => [between(330, 372), between(110, 490), between(-2, 10)];
  const plateau = () => [between(400, 590), between(110, 490), between(100, 124)];
  const kinds = [chamber, door(176), door(224), skylight, notch, plateau], each = Math.ceil(count / kinds.length);
  return kinds.map((place, k) => {
    const energy = place === plateau ? 0.12 : -0.9;
    return { id: `stroke-${k}`, op: 'blend', tree: { type: 'points', balls: Array.from({ length: each }, () => [...place(), 2.5, energy]) } };
  });
}

/**
 * Gorges as deep as the paper's grid of its canyon is high: a river that winds through a plateau, and four that join it. What
 * #C0/#C can be is bounded by how much air and rock lies over and under the surface, and the coast has a third of that. Pixels of
 * 1 m, 1,100 a side, from the north-west.
 */
function gorges(i, j) {
  const x = i, y = 1100 - j, river = (at) => 550 + 110 * Math.sin(at / 95) + 40 * Math.sin(at / 41 + 1);
  const off = (from, curve) => Math.abs(from) / Math.hypot(1, curve);
  const slope = (110 / 95) * Math.cos(x / 95) + (40 / 41) * Math.cos(x / 41 + 1);
  const ways = [[off(y - river(x), slope), 100 - x / 60]];   // how far the bed is, and its height
  [[190, 1], [460, -1], [700, 1], [940, -1]].forEach(([mouth, side], k) => {
    const bed = mouth + 30 * Math.sin(y / 60 + k), up = side * (y - river(mouth));
    if (up > 0) ways.push([off(x - bed, Math.cos(y / 60 + k) / 2), 100 - mouth / 60 + up / 8]);
  });
  const rough = 3 * Math.sin(x / 17 + y / 29) + 2 * Math.sin(y / 11 - x / 37);
  const heights = ways.map(([away, bed]) => {
    const talus = 2.4 * Math.min(Math.max(away - 14, 0), 25), wall = Math.min(Math.max((away - 39) / 32, 0), 1);
    return bed + talus + (620 - bed - talus) * wall + Math.max(away - 71, 0) / 15 + rough * (0.2 + 0.8 * wall);
  });
  return Math.min(...heights);
}

/**
 * A plateau that breaks off, as high above the valley as the paper's grid of its karst, with dolines along the rim. Pixels of 4 m,
 * 1,300 a side, from the north-west.
 */
function scarp(i, j) {
  const x = 4 * i, y = 5200 - 4 * j;
  const back = 3000 + 260 * Math.sin(y / 620) + 70 * Math.sin(y / 170 + 1) - x;   // from the rim
  const rough = 6 * Math.sin(x / 57 + y / 91) + 4 * Math.sin(y / 37 - x / 83);
  if (back < 0) {
    const cliff = Math.min(-back / 260, 1), talus = Math.min(Math.max((-back - 260) / 900, 0), 1);
    return 1420 - 780 * cliff - 560 * talus * (2 - talus) + rough * (1 + cliff);
  }
  let height = 1420 + 110 * Math.min(back / 3000, 1) + rough;
  for (const [cx, cy, radius, depth] of dolines) {
    const from = Math.hypot(x - cx, y - cy) / radius;
    if (from < 1) height -= depth * (1 - from * from) ** 2;
  }
  return height;
}
const dolines = (() => {
  const chance = chances(), between = (a, b) => a + (b - a) * chance.next().value;
  return Array.from({ length: 70 }, () => [between(2300, 2900), between(1500, 3500), between(30, 70), between(12, 30)]);
})();

const scenes = {
  Sea: {
    paper: { figure: 11, size: 6, covered: 0.01, nodes: 50693, generation: 5.5, memory: 3.0, grid: '2,000^2 x 33', t: 13.3, t0: 91.5, calls: 9, calls0: 210 },
    dem: { pixels: 1500, spacing: 4, seed: 1 }, spacing: 3, geology: beds(26, 4),
    operations: [{ id: 'waves', type: 'sea_cliffs', sea_level: 0, range: 8, steps: 3, radius: 6, distance: 1.8, energy: 2.4 }],
  },
  Karst: {
    paper: { figure: 17, size: 5.2, covered: 0.02, nodes: 165773, generation: 6.2, memory: 9.9, grid: '1,520^2 x 447', t: 14.2, t0: 188.4, calls: 14, calls0: 1000 },
    dem: { pixels: 1300, spacing: 4, height: scarp }, spacing: 5200 / 1520, geology: beds(40, 9),
    operations: [{
      id: 'karst', type: 'percolation_karst', cliffs: 50, radius: 5, step: 3, exclusion: 3.5, min_sink_depth: 3, count: 2000, length: 1200, depth: 700, rho_0: 0.6, upward: 0.15,
      region: { type: 'polygon', points: [[2400, 1850], [3300, 1850], [3300, 3050], [2400, 3050]], feather: 0 },
    }],
  },
  Canyon: {
    paper: { figure: 15, size: 1.1, covered: 0.2, nodes: 137043, generation: 6.8, memory: 9.3, grid: '1,000^2 x 546', t: 32.6, t0: 159.0, calls: 30, calls0: 569 },
    dem: { pixels: 1100, spacing: 1, height: gorges }, spacing: 1.1, geology: beds(20, 6),
    operations: [{ id: 'river', type: 'river_canyon', steps: 2, radius: 3, distance: 1.9, energy: 2.4, banks: 40, flood: 80, percentile: 75, stress: 0.1, drainage: 5e3, pixel: 4 }],
  },
  Hoodoo: {
    paper: { figure: 19, size: 0.35, covered: 0.05, nodes: 55619, generation: 2.1, memory: 5.5, grid: '650^2 x 245', t: 2.9, t0: 15.8, calls: 4, calls0: 111 },
    dem: { pixels: 800, spacing: 1, seed: 5 }, spacing: 350 / 650, geology: beds(12, 3), extent: [[380, 260], [730, 610]],
    operations: [[430, 300], [480, 480], [600, 330], [640, 520]].map(([x, y], k) => ({
      id: `block-${k}`, type: 'hoodoos', preset: 'hoodoo', height: 14, radius: 0.7, distance: 2,
      region: { type: 'polygon', points: [[x, y], [x + 40, y], [x + 40, y + 40], [x, y + 40]], feather: 0 },
    })),
  },
  Benagil: {
    paper: { figure: 25, size: 0.4, covered: 0.35, nodes: 13264, generation: null, memory: 1.3, grid: '550^2 x 87', t: 2.7, t0: 3.9, calls: 8, calls0: 20 },
    dem: { pixels: 600, spacing: 1, seed: 1 }, spacing: 400 / 550, geology: beds(9, 3), extent: [[200, 100], [600, 500]],
    operations: strokes(13264),
  },
};

async function run(args) {
  const result = await hoodoo(args);
  if (result.code !== 0) throw new Error(`hoodoo ${args.join(' ')}: exit ${result.code ?? result.signal}: ${result.stderr.trim()}`);
  return result;
}

async function write(name, { dem, spacing, extent, geology, operations }) {
  const file = join(folder, `${name}.tif`), scene = join(folder, `${name}.json`);
  if (dem.height) await writeDem(file, dem.pixels, dem.spacing, dem.height);
  else if (!existsSync(file)) await run(['synthesize', file, '--pixels', `${dem.pixels}`, '--spacing', `${dem.spacing}`, '--seed', `${dem.seed}`]);
  const bake = { spacing, ...(extent && { extent: { min: extent[0], max: extent[1] } }) };
  await writeFile(scene, JSON.stringify({ hoodoo: 1, name, seed: 1, terrains: [{ id: 'land', dem: `${name}.tif` }], geology, operations, bake }));
  return scene;
}

const failures = [];
/** Both numbers, and whether ours keeps the goal. */
function cell(name, what, ours, paper, holds, digits = 2) {
  if (!holds) failures.push(`${name}: ${what}`);
  const shown = (v) => (v >= 1000 ? Math.round(v).toLocaleString('en') : v.toFixed(digits));
  return `${shown(ours)} / ${shown(paper)}${holds ? '' : ' !'}`;
}

async function measure(name, scene) {
  const file = await write(name, scene), { paper } = scene;
  if (options.nodes) {
    const { nodes, bytes } = JSON.parse((await run(['--json', 'generate', file])).stdout);
    if (paper.generation === null) return;   // made by hand
    console.log(`| ${name} | ${cell(name, '#N', nodes, paper.nodes, Math.abs(nodes / paper.nodes - 1) <= 0.2)} | ${bytes} |`);
    return;
  }
  const baked = await run(['--json', 'bake', file, '-o', join(folder, name), '--stats', '--force', '--progress', 'off']);
  const s = JSON.parse(baked.stdout).stats, mega = 1e6;
  const speed = s.t0_s / s.t_s, fewer = s.calls0 / s.calls;
  const paperSpeed = paper.t0 / paper.t, paperFewer = paper.calls0 / paper.calls;
  const fields = [
    `${name} (${paper.figure})`, `${paper.size} x ${paper.size}`,
    `${s.covered.toFixed(3)} / ${paper.covered}`,
    cell(name, '#N', s.nodes, paper.nodes, Math.abs(s.nodes / paper.nodes - 1) <= 0.2),
    paper.generation ? cell(name, 'generation', s.generation_s, paper.generation, s.generation_s <= paper.generation / 5) : `${s.generation_s.toFixed(2)} / -`,
    cell(name, 'memory', s.memory_bytes / mega, paper.memory, s.memory_bytes / mega <= 0.8 * paper.memory),
    `${s.grid.join(' x ')} / ${paper.grid}`,
    `${s.t_s.toFixed(1)} / ${paper.t}`, `${s.t0_s.toFixed(0)} / ${paper.t0}`,
    cell(name, 't0/t', speed, paperSpeed, speed >= paperSpeed, 1),
    `${(s.calls / mega).toFixed(1)} / ${paper.calls}`, `${(s.calls0 / mega).toFixed(0)} / ${paper.calls0}`,
    cell(name, '#C0/#C', fewer, paperFewer, fewer >= paperFewer, 1),
    (s.calls0 / s.bounded_calls).toFixed(1),
  ];
  console.log(`| ${fields.join(' | ')} |`);
}

await mkdir(folder, { recursive: true });
console.log('Ours / the paper\'s; ! where a goal is missed.\n');
console.log(options.nodes ? '| scene | #N | bytes |\n|---|---|---|'
  : '| scene | km | a | #N | generation [s] | memory [MB] | grid | t [s] | t0 [s] | t0/t | #C [M] | #C0 [M] | #C0/#C | #C0/points in bounds of columns |\n|' + '---|'.repeat(14));
for (const [name, scene] of Object.entries(scenes)) {
  if (names.length === 0 || names.includes(name)) await measure(name, scene);
}
if (failures.length > 0) console.log(`\nMissed: ${failures.join(', ')}`);
process.exitCode = failures.length > 0 ? 1 : 0;

/**
 * Measures that a bake's memory does not depend on its world: sample DEMs of rising size are planned and baked, the
 * smallest whole, the others over a region in their middle. Prints a Markdown table, and fails where a run's peak
 * resident size exceeds --memory by more than 256 MiB, where a plan takes more than 64 bytes a tile, or where the
 * largest world takes over 5 % more than the one before. Run by hand; it needs about 12 GB of disk:
 *
 *     node memory.mjs DIR [--pixels 4096,16384,40000] [--region PIXELS] [--memory MiB] [--threads N]
 *
 * DIR takes DEMs and tilesets; DEMs that are there are used again, all else in it is removed.
 */
import { existsSync } from 'node:fs';
import { mkdir, rm, writeFile } from 'node:fs/promises';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';
import { hoodoo } from '../e2e/hoodoo.mjs';

const allowance = 256;        // [MiB]
const mostPerTile = 64;       // [bytes] of plan
const mostGrowth = 1.05;      // from one world to a larger one
const spacing = 2;            // [m]

const { positionals, values: options } = parseArgs({
  allowPositionals: true,
  options: {
    pixels: { type: 'string', default: '4096,16384,40000' }, region: { type: 'string', default: '4096' },
    memory: { type: 'string', default: '1024' }, threads: { type: 'string', default: '2' },
  },
});
if (positionals.length !== 1) throw new Error('usage: node memory.mjs DIR [options]');
const folder = resolve(positionals[0]);
const budget = Number(options.memory) + allowance;

async function run(args) {
  const result = await hoodoo(args);
  if (result.code !== 0) throw new Error(`hoodoo ${args.join(' ')}: exit ${result.code ?? result.signal}: ${result.stderr.trim()}`);
  return result;
}

async function demOf(pixels) {
  const file = join(folder, `dem${pixels}.tif`);
  if (!existsSync(file)) await run(['synthesize', file, '--pixels', String(pixels), '--spacing', String(spacing)]);
  return file;
}

/** The whole world, or `region` pixels in its middle. */
async function sceneOf(pixels, region) {
  const bake = {};
  if (region < pixels) {
    const [low, high] = [-1, 1].map((sign) => ((pixels + sign * region) / 2) * spacing);
    bake.extent = { min: [low, low], max: [high, high] };
  }
  const file = join(folder, `scene-${pixels}-${region}.json`);
  await writeFile(file, JSON.stringify({ hoodoo: 1, terrains: [{ dem: await demOf(pixels) }], bake }));
  return file;
}

const count = new Intl.NumberFormat('en').format;
const failures = [];
function expect(holds, what) {
  if (!holds) failures.push(what);
}

function print(name, result, tiles, plan) {
  console.log(`| ${name} | ${count(tiles)} | ${plan ? `${count(plan)} (${(plan / tiles).toFixed(1)} a tile)` : ''} | ` +
              `${result.seconds.toFixed(0)} s | ${result.processor.toFixed(0)} s | ${result.peak.toFixed(0)} MiB |`);
  expect(result.peak <= budget, `${name}: ${result.peak.toFixed(0)} MiB, the bound is ${budget}`);
}

const shared = ['--memory', options.memory, '--threads', options.threads, '--progress', 'off'];
/** Peaks [MiB] of planning a world and of baking its region. */
async function measure(pixels) {
  const region = Math.min(pixels, Number(options.region));
  const tiles = join(folder, `tiles${pixels}`);
  await rm(tiles, { recursive: true, force: true });
  const whole = await sceneOf(pixels, pixels);
  const planned = await run(['--json', 'bake', whole, '-o', tiles, '--plan', ...shared]);
  const plan = JSON.parse(planned.stdout);
  print(`${pixels}: ingest and plan`, planned, plan.planned, plan.plan_bytes);
  expect(plan.plan_bytes <= mostPerTile * plan.planned, `${pixels}: ${plan.plan_bytes / plan.planned} bytes of plan a tile`);
  const again = await run(['--json', 'bake', whole, '-o', tiles, '--plan', ...shared]);
  print(`${pixels}: plan alone`, again, plan.planned, plan.plan_bytes);
  const scene = region < pixels ? await sceneOf(pixels, region) : whole;
  const baked = await run(['--json', 'bake', scene, '-o', tiles, ...shared]);
  const report = JSON.parse(baked.stdout);
  expect(report.complete, `${pixels}: the bake is not complete`);
  print(`${pixels}: ${region < pixels ? `bake of ${region} x ${region} pixels` : 'whole bake'}`, baked, report.tiles);
  await rm(tiles, { recursive: true, force: true });
  return { planned: planned.peak, baked: baked.peak };
}

await mkdir(folder, { recursive: true });
console.log('| pixels a side | tiles | plan [bytes] | time | of processors | peak memory |');
console.log('|---|---|---|---|---|---|');
const peaks = [];
for (const pixels of options.pixels.split(',').map(Number)) peaks.push(await measure(pixels));
const [before, last] = peaks.slice(-2);
if (last) {
  for (const key of ['planned', 'baked']) {
    expect(last[key] <= mostGrowth * before[key], `${key}: the largest world took ${(last[key] / before[key]).toFixed(3)} times the memory of the one before`);
  }
}
for (const failure of failures) console.error(failure);
process.exitCode = failures.length === 0 ? 0 : 1;

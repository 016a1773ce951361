/**
 * What a second thread is worth: a bake of some hundred tiles with one thread and with two, in turns, medians of the
 * rounds. Work (user and system time) may grow by a tenth at most, and the clock must show 1.6 times the speed. Run by
 * hand on a machine with nothing else to do:
 *
 *     node scaling.mjs [--pixels N] [--rounds N] [--folder DIR] [--scene FILE]
 *
 * The scene is an example's terrain of N x N pixels with caves and arches all over, or FILE. Folders are in memory
 * unless DIR says otherwise. Exit 0: both hold; 1: one does not; 2: others were at work, so that nothing can be said.
 */
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { mkdtemp, writeFile } from 'node:fs/promises';
import { availableParallelism, tmpdir } from 'node:os';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { digests, hoodoo, removeFolder } from '../e2e/hoodoo.mjs';

const mostWork = 1.1, leastSpeed = 1.6;
const mostOthers = 0.03;   // of the processors' time, taken by other programs
const leastTiles = 200, spacing = 2, ticksPerSecond = 100;

const { values: options } = parseArgs({
  options: {
    pixels: { type: 'string', default: '1664' }, rounds: { type: 'string', default: '3' }, scene: { type: 'string' },
    folder: { type: 'string', default: existsSync('/dev/shm') ? '/dev/shm' : tmpdir() },
  },
});

/** Seconds that all processors together have been busy. */
function busy() {
  const [user, nice, system, , , irq, softirq] = readFileSync('/proc/stat', 'utf8').split('\n')[0].split(/ +/).slice(1).map(Number);
  return (user + nice + system + irq + softirq) / ticksPerSecond;
}

/** A terrain of so many pixels with a feature every 200 m, tunnels, caves and arches in turn. */
async function makeScene(work, pixels) {
  const made = await hoodoo(['synthesize', join(work, 'dem.tif'), '--pixels', String(pixels), '--spacing', String(spacing)]);
  assert.equal(made.code, 0, made.stderr);
  const size = pixels * spacing, operations = [];
  const kinds = [
    (x, y) => ({ type: 'tunnel', radius: 8, path: [-40, 0, 40].map((d) => ({ xy: [x + d, y], ground: -14 })) }),
    (x, y) => ({ type: 'cave', entrance: { xy: [x, y], ground: 0 }, direction: [0.3, 0.2, -1], depth: 40, radius: 9 }),
    (x, y) => ({ type: 'arch', from: { xy: [x - 30, y], ground: -2 }, to: { xy: [x + 30, y], ground: -2 }, height: 40, thickness: 14 }),
  ];
  for (let y = 100; y < size - 100; y += 200) {
    for (let x = 100; x < size - 100; x += 200) operations.push(kinds[operations.length % kinds.length](x, y));
  }
  const file = join(work, 'scene.json');
  await writeFile(file, JSON.stringify({
    hoodoo: 1, terrains: [{ id: 'land', dem: 'dem.tif' }], geology: { type: 'strata', wavelength: 30, octaves: 3 },
    materials: [{ name: 'shale', color: '#8d8377', resistance: [0, 0.5] }, { name: 'limestone', color: '#cfc6b0', resistance: [0.5, 1] }],
    operations,
  }));
  return file;
}

async function measure(scene, out, threads) {
  const from = busy(), start = performance.now();
  const result = await hoodoo(['bake', scene, '-o', out, '--json', '--progress', 'off', '--threads', String(threads)]);
  if (result.code !== 0) throw new Error(`bake: exit ${result.code ?? result.signal}: ${result.stderr}`);
  const seconds = (performance.now() - start) / 1000;
  const others = Math.max(0, busy() - from - result.processor) / (seconds * availableParallelism());
  return { threads, seconds, processor: result.processor, peak: result.peak, others, ...JSON.parse(result.stdout) };
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

/** Bakes in turns and prints a row for each. */
async function rounds(work) {
  const scene = options.scene ?? await makeScene(work, Number(options.pixels));
  const out = join(work, 'out'), runs = [];
  let bytes;
  console.log('| threads | clock | user + system | by others | peak memory | tiles |');
  console.log('|---|---|---|---|---|---|');
  for (let round = 0; round < Number(options.rounds); ++round) {
    for (const threads of round % 2 === 0 ? [1, 2] : [2, 1]) {
      const run = await measure(scene, out, threads);
      runs.push(run);
      console.log(`| ${threads} | ${run.seconds.toFixed(2)} s | ${run.processor.toFixed(2)} s | ${(100 * run.others).toFixed(1)} % | ` +
                  `${run.peak.toFixed(0)} MiB | ${run.tiles} |`);
      const found = await digests(out);
      assert.deepEqual(found, bytes ??= found, 'the same bytes');
      await removeFolder(out);
    }
  }
  return runs;
}

/** Prints the verdict, gives the exit code. */
function judge(runs) {
  const of = (threads, what) => median(runs.filter((run) => run.threads === threads).map((run) => run[what]));
  const work = of(2, 'processor') / of(1, 'processor'), speed = of(1, 'seconds') / of(2, 'seconds');
  console.log(`medians: ${work.toFixed(3)} times the work (at most ${mostWork}), ${speed.toFixed(2)} times the speed (at least ${leastSpeed})`);
  if (runs[0].tiles < leastTiles) throw new Error(`${runs[0].tiles} tiles are too few: at least ${leastTiles}`);
  if (work <= mostWork && speed >= leastSpeed) return 0;
  const others = median(runs.map((run) => run.others));
  if (others <= mostOthers && availableParallelism() >= 2) return 1;
  console.log(`others took ${(100 * others).toFixed(1)} % of ${availableParallelism()} processors (load ` +
              `${readFileSync('/proc/loadavg', 'utf8').split(' ')[0]}): nothing can be said`);
  return 2;
}

const work = await mkdtemp(join(options.folder, 'hoodoo-scaling-'));
try {
  process.exitCode = judge(await rounds(work));
} finally {
  await removeFolder(work);
}

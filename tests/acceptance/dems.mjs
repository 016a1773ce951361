/**
 * Bakes an arch, a tunnel and a cave into every DEM of the test data at the DEM's own resolution, checks the
 * tilesets with `hoodoo verify` and with others' tools, and prints a Markdown table. Run by hand:
 *
 *     node dems.mjs [NAME ...] [--keep DIR] [--threads N] [--memory MiB]
 *
 * NAME picks DEMs by a part of their file name; --keep leaves scenes and tilesets in DIR. On the node of
 * tests/e2e, which also has the other tools.
 */
import { mkdir, readdir, writeFile } from 'node:fs/promises';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';
import { hoodoo, makeFolder, removeFolder, run, testData } from '../e2e/hoodoo.mjs';

const metresPerDegree = 111_320;
const checker = resolve(import.meta.dirname, '../e2e/tiles.mjs');

/** Ground size of a pixel and of the whole raster [m], near enough to place features by. */
function sizeOf(info) {
  const [, dx, , north, , dy] = info.transform;
  const degrees = Math.abs(dx) < 0.05;   // no DEM here has pixels of centimetres
  const latitude = degrees ? north + (dy * info.height) / 2 : 0;
  const unit = degrees ? metresPerDegree : info.unit;
  const pixel = [Math.abs(dx) * unit * Math.cos((latitude * Math.PI) / 180), Math.abs(dy) * unit];
  return { spacing: Math.min(...pixel), width: pixel[0] * info.width, height: pixel[1] * info.height };
}

/**
 * A scene whose features stand around (u, v) of the DEM: a rib of rock 12 cells thick over 48 cells; a tunnel 13
 * cells wide that goes down, under 8 cells of rock and up again; a shaft 12 cells wide that ends in a chamber.
 * They follow the ground, so that they fit any relief. Offsets and sizes in cells.
 */
function sceneAround(u, v, dem, { spacing: s, width, height }) {
  const at = (x, y, dz) => ({ uv: [u + (x * s) / width, v + (y * s) / height], ground: dz * s });
  const depths = [9, -3, -15, -15, -15, -15, -15, -3, 9];
  return {
    hoodoo: 1, name: `arch, tunnel and cave in ${dem}`, seed: 7,
    materials: [
      { name: 'shale', color: '#8d8377', resistance: [0, 0.45], friction: 0.6 },
      { name: 'limestone', color: '#cfc6b0', resistance: [0.45, 1], friction: 0.8 },
    ],
    terrains: [{ id: 'land', dem }],
    geology: {
      type: 'blend',
      children: [
        { type: 'strata', wavelength: 8 * s, octaves: 3 },
        { type: 'plane', point: at(0, 0, -20), normal: [0, 0, 1], falloff: 12 * s, energy: -0.3 },
      ],
    },
    operations: [
      { id: 'arch', type: 'arch', from: at(-24, -20, -2), to: at(24, -20, -2), height: 40 * s, thickness: 12 * s },
      { id: 'tunnel', type: 'tunnel', path: depths.map((dz, i) => at(-32 + 8 * i, 8, dz)), radius: 6.5 * s },
      { id: 'cave', type: 'cave', entrance: at(0, 32, 0), direction: [0, 0.2, -1], depth: 30 * s, radius: 6 * s },
    ],
  };
}

/** Places to try, from the middle outward. */
const places = () => {
  const steps = [-4, -3, -2, -1, 0, 1, 2, 3, 4].map((i) => 0.5 + 0.09 * i);
  return steps.flatMap((u) => steps.map((v) => [u, v]))
    .sort(([a, b], [c, d]) => Math.hypot(a - 0.5, b - 0.5) - Math.hypot(c - 0.5, d - 0.5));
};

/** Bakes at the first place where no feature stands over a hole. */
async function bakeSomewhere(dem, folder, options) {
  const info = await hoodoo(['--json', 'info', dem]);
  if (info.code !== 0) throw new Error(info.stderr);
  const size = sizeOf(JSON.parse(info.stdout)), file = join(folder, 'scene.json');
  for (const [u, v] of places()) {
    await writeFile(file, JSON.stringify(sceneAround(u, v, dem, size), null, 1));
    const args = ['--json', 'bake', file, '-o', join(folder, 'tiles'), '--threads', options.threads,
                  '--memory', options.memory, '--progress', 'off'];
    const baked = await hoodoo(args);
    if (baked.code === 2 && /no terrain has an elevation/.test(baked.stderr)) continue;
    if (baked.code !== 0) throw new Error(`bake: exit ${baked.code ?? baked.signal}: ${baked.stderr.trim()}`);
    return { ...baked, ...JSON.parse(baked.stdout) };
  }
  throw new Error('found no place without a hole');
}

const count = new Intl.NumberFormat('en').format;

/** One row of the table, and whether all is well. */
async function examine(name, dem, folder, options) {
  const baked = await bakeSomewhere(dem, folder, options);
  const tiles = join(folder, 'tiles');
  const verify = await hoodoo(['verify', tiles]);
  const others = await run(process.execPath, [checker, tiles]);
  const found = others.stdout ? JSON.parse(others.stdout)
    : { problems: [others.stderr], problemCount: 1 };
  if (verify.code !== 0) console.error(`${name}: hoodoo verify:\n${(verify.stdout + verify.stderr).slice(0, 2000)}`);
  if (others.code !== 0) console.error(`${name}: others:\n${found.problems.slice(0, 20).join('\n')}`);
  const ok = verify.code === 0 && others.code === 0 && baked.complete;
  const cells = [
    name, `${baked.seconds.toFixed(1)} s`, `${baked.processor.toFixed(1)} s`, `${baked.peak.toFixed(0)} MiB`, count(baked.tiles),
    count(found.triangles ?? 0), count(found.bytes ?? 0),
    `${found.euler?.[0]} in ${found.components?.[0]}`,
    `${verify.code === 0 ? 'passes' : `exit ${verify.code ?? verify.signal}`}, ${verify.seconds.toFixed(1)} s`,
    others.code === 0
      ? `0 errors, 0 warnings, ${count(found.borderVertices)} border vertices equal, ${others.seconds.toFixed(1)} s`
      : `${count(found.problemCount)} problems`,
  ];
  return { ok, row: `| ${cells.join(' | ')} |` };
}

const { positionals: wanted, values: options } = parseArgs({
  allowPositionals: true,
  options: {
    keep: { type: 'string' }, threads: { type: 'string', default: '2' }, memory: { type: 'string', default: '1024' },
  },
});
const source = join(testData, 'dem');
const names = (await readdir(source)).filter((name) => name.endsWith('.tif'))
  .filter((name) => wanted.length === 0 || wanted.some((part) => name.includes(part))).sort();
if (names.length === 0) throw new Error(`no such DEM in ${source}`);

console.log('| DEM | bake | of processors | peak memory | tiles | triangles | bytes | Euler of leaves in pieces | verify | others\' tools |');
console.log('|---|---|---|---|---|---|---|---|---|---|');
let failed = 0;
for (const name of names) {
  const short = name.replace('.tif', '');
  const folder = options.keep ? join(resolve(options.keep), short) : await makeFolder();
  await mkdir(folder, { recursive: true });
  try {
    const { ok, row } = await examine(short, join(source, name), folder, options);
    console.log(row);
    failed += ok ? 0 : 1;
  } catch (error) {
    console.log(`| ${short} | ${error.message.replaceAll('\n', ' ').slice(0, 300)} | | | | | | | |`);
    ++failed;
  } finally {
    if (!options.keep) await removeFolder(folder);
  }
}
process.exitCode = failed === 0 ? 0 : 1;

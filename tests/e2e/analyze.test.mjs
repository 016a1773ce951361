/** `hoodoo analyze`: rasters in the place of their DEM, and the fault for what cannot be. */
import assert from 'node:assert/strict';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { hoodoo, makeFolder, removeFolder, withFolder } from './hoodoo.mjs';

let work, dem;

before(async () => {
  work = await makeFolder();
  dem = join(work, 'dem.tif');
  const made = await hoodoo(['synthesize', dem, '--pixels', '300']);
  assert.equal(made.code, 0, made.stderr);
});
after(() => removeFolder(work));

const info = async (file) => JSON.parse((await hoodoo(['info', file, '--json'])).stdout);

test('Every raster lies where the DEM does', async () => {
  const names = { '--fill': 'f.tif', '--area': 'a.tif', '--slope': 's.tif', '--power': 'p.tif' };
  const args = Object.entries(names).flatMap(([flag, name]) => [flag, join(work, name)]);
  const result = await hoodoo(['analyze', dem, ...args, '--sinks', join(work, 'sinks.csv'), '--json']);
  assert.equal(result.code, 0, result.stderr);
  const report = JSON.parse(result.stdout);
  assert.equal(report.written.length, 5);
  const place = await info(dem);
  for (const name of Object.values(names)) {
    const found = await info(join(work, name));
    assert.deepEqual(found.transform, place.transform, name);
    assert.equal(found.crs, place.crs, name);
    assert.equal(found.sample, 'float32', name);
    assert.equal(found.layout, 'tiled 256 x 256', name);
    assert.equal(found.compression, 'deflate', name);
  }
  const [, dx, , , , dy] = place.transform;
  const area = Math.abs(dx * dy) * place.width * place.height * (place.unit ?? 1) ** 2;
  assert.ok(Math.abs(report.outflow_m2 - area) < 1e-9 * area, `${report.outflow_m2} of ${area} m2 leave`);
  const lines = (await readFile(join(work, 'sinks.csv'), 'utf8')).trimEnd().split('\n');
  assert.equal(lines[0], 'i,j,elevation,depth,area');
  assert.equal(lines.length - 1, report.sinks);
});

test('The coast: how open it lies and how far the sea is, with exact percentiles', async () => {
  const access = join(work, 'c.tif'), distance = join(work, 'd.tif');
  const asked = ['--access', access, '--access-radius', '80', '--sea-distance', distance, '--percentiles', '0,50,90,100'];
  const grid = await info(dem);
  const level = (await hoodoo(['analyze', dem, '--fill', join(work, 'x.tif'), '--percentiles', '25', '--json'])).stdout;
  const sea = JSON.parse(level).percentiles[join(work, 'x.tif')][0].value;
  const result = await hoodoo(['analyze', dem, ...asked, '--sea-level', `${sea}`, '--json']);
  assert.equal(result.code, 0, result.stderr);
  const report = JSON.parse(result.stdout);
  assert.deepEqual(report.written, [access, distance]);
  for (const name of report.written) {
    const found = await info(name);
    assert.deepEqual(found.transform, grid.transform, name);
    assert.equal(found.layout, 'tiled 256 x 256', name);
    assert.equal(found.compression, 'deflate', name);
  }
  const values = (name) => report.percentiles[name].map((entry) => entry.value);
  assert.deepEqual(report.percentiles[access].map((entry) => entry.percent), [0, 50, 90, 100]);
  const open = values(access), far = values(distance);
  assert.ok(open[0] > 0 && open[0] < open[1] && open[3] <= 1, `${open}`);
  assert.equal(far[0], 0, 'the sea itself');
  assert.ok(far[1] > 0 && far[1] < far[2] && far[2] < far[3], `${far}`);
  assert.match((await hoodoo(['analyze', dem, ...asked, '--sea-level', `${sea}`])).stdout, /d\.tif\n {2}0 %: 0\n {2}50 %: /);
});

test('What is filled has no sink, and is filled already', async () => {
  const filled = join(work, 'filled.tif'), again = join(work, 'again.tif');
  assert.equal((await hoodoo(['analyze', dem, '--fill', filled])).code, 0);
  const result = await hoodoo(['analyze', filled, '--fill', again, '--sinks', join(work, 'none.csv'), '--json']);
  assert.equal(JSON.parse(result.stdout).sinks, 0);
  assert.ok((await readFile(again)).equals(await readFile(filled)));
});

test('The same bytes again', async () => {
  const files = [join(work, 'one.tif'), join(work, 'two.tif')];
  for (const file of files) assert.equal((await hoodoo(['analyze', dem, '--area', file])).code, 0);
  assert.ok((await readFile(files[0])).equals(await readFile(files[1])));
});

test('In little memory, part by part, the same bytes', () => withFolder(async (folder) => {
  const large = join(folder, 'large.tif');
  assert.equal((await hoodoo(['synthesize', large, '--pixels', '2400'])).code, 0);
  const flags = ['--fill', '--area', '--slope', '--power', '--sea-distance'];
  const names = (memory) => flags.map((flag) => join(folder, `${flag.slice(2)}-${memory}.tif`));
  const outflow = [];
  for (const memory of ['64', '1024']) {
    const args = flags.flatMap((flag, n) => [flag, names(memory)[n]]);
    const sinks = join(folder, `sinks-${memory}.csv`);
    const result = await hoodoo(['analyze', large, ...args, '--sinks', sinks, '--sea-level', '1', '--memory', memory, '--json']);
    assert.equal(result.code, 0, result.stderr);
    const report = JSON.parse(result.stdout);
    assert.ok(report.sinks > 0);
    outflow.push([report.outflow_m2, await readFile(sinks, 'utf8')]);
  }
  assert.deepEqual(outflow[0], outflow[1]);
  for (const n of flags.keys()) assert.ok((await readFile(names('64')[n])).equals(await readFile(names('1024')[n])), flags[n]);
}));

for (const [what, args, code, message] of [
  ['Nothing to write', [], 2, /needs one of --fill/],
  ['A sea that is nowhere', ['--sea-distance', 'x.tif', '--sea-level', '-9000'], 2, /at or below the sea level of -9000 m/],
  ['A percentile beyond all', ['--fill', 'x.tif', '--percentiles', '50,101'], 2, /--percentiles.*101/],
  ['An exponent out of range', ['--area', 'x.tif', '--exponent', '11'], 2, /--exponent.*11/],
  ['An unknown routing', ['--area', 'x.tif', '--routing', 'd16'], 2, /--routing.*d16/],
]) {
  test(`${what} is refused with exit ${code}`, () => withFolder(async (folder) => {
    const result = await hoodoo(['analyze', dem, ...args], { cwd: folder });
    assert.equal(result.code, code, result.stderr);
    assert.match(result.stderr, message);
  }));
}

test('A file that is no DEM is refused', () => withFolder(async (folder) => {
  const file = join(folder, 'text.tif');
  await writeFile(file, 'no raster');
  const result = await hoodoo(['analyze', file, '--fill', join(folder, 'x.tif')]);
  assert.equal(result.code, 2);
  assert.match(result.stderr, /text\.tif/);
}));

/**
 * The bundled example in parts: shards in processes of their own, merging and a shared cache give the same bytes as
 * one bake. It has smaller tiles here, so that there is something to share out.
 */
import assert from 'node:assert/strict';
import { chmod, copyFile, mkdir, readFile, readdir, writeFile } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { digests, exampleScene, hoodoo, makeFolder, removeFolder, seededRandom, withFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const seed = Number(process.env.HOODOO_SEED ?? Math.floor(Math.random() * 2 ** 31));
const nobody = 65534;   // a user without rights
const cells = 32, spacing = 4;
let work, scene, original, reference, expected;

before(async () => {
  work = await makeFolder();
  const made = await hoodoo(['synthesize', join(work, 'dem.tif')]);
  assert.equal(made.code, 0, made.stderr);
  original = await exampleScene();
  original.bake = { spacing, tile_cells: cells };
  scene = await write('scene', original);
  reference = join(work, 'reference');
  await bake(scene, reference);
  expected = await digests(reference);
});
after(() => removeFolder(work));

/** Writes a scene beside the DEM. */
async function write(name, content) {
  const file = join(work, `${name}.json`);
  await writeFile(file, JSON.stringify(content));
  return file;
}

/** Bakes, demands success, gives the report. */
async function bake(file, folder, args = [], options = {}) {
  const result = await hoodoo(['bake', file, '-o', folder, '--json', ...args], options);
  assert.equal(result.code, 0, `bake ${args.join(' ')} ended with ${result.code ?? result.signal}: ${result.stderr}`);
  return JSON.parse(result.stdout);
}

const merge = (parts, folder, args = []) => hoodoo(['merge', ...parts, '-o', folder, ...args]);
const index = async (folder) => JSON.parse(await readFile(join(folder, 'bake.json'), 'utf8'));
const shards = (count) => Array.from({ length: count }, (_, i) => `${i + 1}/${count}`);
const clone = (content) => structuredClone(content);

/** The original with one brush moved. */
function moved(id, by) {
  const content = clone(original);
  const center = content.operations.find((operation) => operation.id === id).tree.center;
  center.xy = center.xy.map((value, axis) => value + by[axis]);
  return content;
}

for (const count of [1, 3, 8]) {
  test(`${count} shards, all at once in one folder, give the bytes of one bake`, () => withFolder(async (folder) => {
    const out = join(folder, 'out');
    const reports = await Promise.all(shards(count).map((shard) => bake(scene, out, ['--shard', shard, '--threads', '1'])));
    assert.ok(reports.some((report) => report.complete), 'the last one finds it complete');
    assert.deepEqual(await digests(out), expected);
  }));

  test(`${count} shards in folders of their own, merged, give the bytes of one bake`, () => withFolder(async (folder) => {
    const parts = shards(count).map((shard) => join(folder, `part-${shard.replace('/', '-of-')}`));
    const reports = await Promise.all(shards(count).map((shard, i) => bake(scene, parts[i], ['--shard', shard, '--threads', '1'])));
    const tiles = reports.map((report) => report.tiles);
    assert.ok(Math.max(...tiles) - Math.min(...tiles) <= 1, `uneven: ${tiles}`);
    const out = join(folder, 'out');
    const merged = await merge(parts, out, ['--json']);
    assert.equal(merged.code, 0, merged.stderr);
    assert.equal(JSON.parse(merged.stdout).tiles, tiles.reduce((a, b) => a + b));
    assert.deepEqual(await digests(out), expected);
    const verified = await hoodoo(['verify', out]);
    assert.equal(verified.code, 0, verified.stdout);
  }));
}

test('A merge that lacks a shard names its tiles, ends with exit 1, and goes on from there', () => withFolder(async (folder) => {
  const parts = shards(3).map((_, i) => join(folder, `part-${i}`));
  await Promise.all(shards(3).map((shard, i) => bake(scene, parts[i], ['--shard', shard, '--threads', '1'])));
  const missing = (await index(parts[1])).tiles.map((tile) => tile.key);
  const out = join(folder, 'out');
  const first = await merge([parts[0], parts[2]], out);
  assert.equal(first.code, 1, first.stderr);
  assert.deepEqual([...first.stderr.matchAll(/tile (\S+) is missing/g)].map(([, key]) => key).sort(), missing.sort());
  assert.equal((await index(out)).complete, false);
  const second = await merge([parts[1]], out, ['--json']);
  assert.equal(second.code, 0, second.stderr);
  assert.equal(JSON.parse(second.stdout).copied, missing.length);
  assert.deepEqual(await digests(out), expected);
}));

test('A shard alone leaves what a plain bake continues', () => withFolder(async (folder) => {
  const part = await bake(scene, folder, ['--shard', '2/3']);
  assert.equal(part.complete, false);
  const rest = await bake(scene, folder);
  assert.equal(rest.reused, part.tiles);
  assert.deepEqual(await digests(folder), expected);
}));

test('Shards killed and started again give the bytes of one bake', () => withFolder(async (folder) => {
  console.log(`seed ${seed}`);
  const random = seededRandom(seed);
  const start = performance.now();
  await bake(scene, join(folder, 'timed'), ['--shard', '1/3', '--threads', '1']);
  const milliseconds = performance.now() - start;
  const out = join(folder, 'out');
  await Promise.all(shards(3).map((shard) => hoodoo(['bake', scene, '-o', out, '--shard', shard, '--threads', '1'],
                                                    { kill: { after: 3 * milliseconds * random(), signal: 'SIGKILL' } })));
  await Promise.all(shards(3).map((shard) => bake(scene, out, ['--shard', shard, '--threads', '1'])));
  assert.deepEqual(await digests(out), expected);
}));

test('Shards of different scenes are not merged, and the message says what differs', () => withFolder(async (folder) => {
  const [a, b, c] = ['a', 'b', 'c'].map((name) => join(folder, name));
  await bake(scene, a, ['--shard', '1/8']);
  await bake(await write('moved', moved('ledge', [6, 0])), b, ['--shard', '2/8']);
  const fine = clone(original);
  fine.bake.spacing = 8;
  await bake(await write('coarse', fine), c, ['--shard', '2/8']);
  for (const [other, message] of [[b, /another scene.*operations/], [c, /spacing is 8 m, not 4 m/]]) {
    const result = await merge([a, other], join(folder, 'out'));
    assert.equal(result.code, 2, result.stderr);
    assert.match(result.stderr, message);
    assert.ok(!existsSync(join(folder, 'out')), 'nothing is written');
  }
  const nothing = await merge([a, join(folder, 'nowhere')], join(folder, 'out'));
  assert.equal(nothing.code, 4, nothing.stderr);
  assert.match(nothing.stderr, /nowhere: has no bake\.json/);
}));

for (const shard of ['9/8', '0/8', 'x', '1', '1/0', '1/2/3', '-1/4']) {
  test(`--shard ${shard} is refused with exit 2`, () => withFolder(async (folder) => {
    const result = await hoodoo(['bake', scene, '-o', join(folder, 'out'), `--shard=${shard}`]);
    assert.equal(result.code, 2, result.stderr);
    assert.match(result.stderr, /--shard: must be i\/N/);
    assert.ok(!existsSync(join(folder, 'out')));
  }));
}

test('--shard with --only, and merge of nothing, are refused with exit 2', () => withFolder(async (folder) => {
  assert.equal((await hoodoo(['bake', scene, '-o', folder, '--shard', '1/2', '--only', '0/0/0'])).code, 2);
  assert.equal((await hoodoo(['merge', '-o', folder])).code, 2);
  assert.equal((await hoodoo(['merge', reference])).code, 2);
}));

test('A second bake with a cache bakes no tile; damaged entries are missed and replaced', () => withFolder(async (folder) => {
  const cache = join(folder, 'cache'), args = ['--cache', cache];
  const first = await bake(scene, join(folder, 'first'), args);
  assert.equal(first.cached, 0);
  const second = await bake(scene, join(folder, 'second'), args);
  assert.deepEqual([second.cached, second.reused], [second.tiles, 0]);
  assert.deepEqual(await digests(join(folder, 'first')), expected);
  assert.deepEqual(await digests(join(folder, 'second')), expected);

  const whole = await digests(cache);
  const names = Object.keys(whole);
  assert.equal(names.length, first.tiles);
  console.log(`seed ${seed}`);
  const random = seededRandom(seed + 2);
  const file = join(cache, names[Math.floor(random() * names.length)]);
  const bytes = await readFile(file);
  bytes[Math.floor(random() * bytes.length)] ^= 1 << Math.floor(random() * 8);
  await writeFile(file, bytes);
  const third = await bake(scene, join(folder, 'third'), args);
  assert.equal(third.cached, third.tiles - 1);
  assert.deepEqual(await digests(join(folder, 'third')), expected);
  assert.deepEqual(await digests(cache), whole, 'the entry is replaced');
}));

test('Shards that write to one cache at once leave it whole', () => withFolder(async (folder) => {
  const cache = join(folder, 'cache');
  // Every process bakes everything, so that all of them write the same entries.
  await Promise.all([1, 2, 3].map((i) => bake(scene, join(folder, `${i}`), ['--cache', cache, '--threads', '1'])));
  const report = await bake(scene, join(folder, 'last'), ['--cache', cache]);
  assert.equal(report.cached, report.tiles);
  for (const name of ['1', '2', '3', 'last']) assert.deepEqual(await digests(join(folder, name)), expected);
  assert.ok(Object.keys(await digests(cache)).every((name) => name.endsWith('.tile')), 'no leftovers');
}));

test('Jobs of a server and bakes share a cache', () => withFolder(async (folder) => {
  const cache = join(folder, 'cache'), data = join(folder, 'data');
  const first = await bake(scene, join(folder, 'first'), ['--cache', cache, '--shard', '1/2']);
  const server = await Server.start({ data, roots: [work], args: ['--cache', cache] });
  try {
    const id = await server.submit(original);
    const job = (await server.follow(id)).at(-1);
    assert.equal(job.status, 'successful', JSON.stringify(job));
    assert.equal(job.tiles.cached, first.tiles);
    assert.deepEqual(await digests(join(data, 'jobs', id, 'out')), expected);
  } finally {
    await server.stop();
  }
  const last = await bake(scene, join(folder, 'last'), ['--cache', cache]);
  assert.equal(last.cached, last.tiles, 'what the job baked is there, too');
}));

test('The summary tells of tiles from the cache', () => withFolder(async (folder) => {
  const cache = join(folder, 'cache');
  await bake(scene, join(folder, 'first'), ['--cache', cache]);
  const result = await hoodoo(['bake', scene, '-o', join(folder, 'second'), '--cache', cache]);
  assert.match(result.stdout, /\(0 found finished, \d+ from the cache\)/);
}));

test('A cache that may only be read is used, with a warning', (t) => withFolder(async (folder) => {
  const asRoot = process.getuid() === 0;
  // Root may write anywhere, so another user runs the command, on copies that it can read.
  const options = asRoot ? { uid: nobody } : {};
  const cache = join(folder, 'cache'), source = join(folder, 'source');
  await bake(scene, join(folder, 'first'), ['--cache', cache]);
  const names = await readdir(cache, { recursive: true, withFileTypes: true });
  const removed = names.find((entry) => entry.isFile());
  await removeFolder(join(removed.parentPath, removed.name));
  for (const entry of names.filter((entry_) => entry_.isDirectory())) await chmod(join(entry.parentPath, entry.name), 0o555);
  await chmod(cache, 0o555);
  await mkdir(source);
  for (const name of ['scene.json', 'dem.tif']) await copyFile(join(work, name), join(source, name));
  await mkdir(join(folder, 'out'));
  for (const name of [folder, join(folder, 'out')]) await chmod(name, 0o777);
  const report = await bake(join(source, 'scene.json'), join(folder, 'out'), ['--cache', cache], options);
  await chmod(cache, 0o755);
  for (const entry of names.filter((entry_) => entry_.isDirectory())) await chmod(join(entry.parentPath, entry.name), 0o755);
  assert.equal(report.cached, report.tiles - 1);
  assert.ok(report.warnings.some((text) => /the cache is not written: .*Permission denied/.test(text)), report.warnings.join());
  assert.deepEqual(await digests(join(folder, 'out')), expected);
}));

test('A cache that is no folder is a warning', () => withFolder(async (folder) => {
  await writeFile(join(folder, 'cache'), 'in the way');
  const result = await hoodoo(['bake', scene, '-o', join(folder, 'out'), '--cache', join(folder, 'cache')]);
  assert.equal(result.code, 0, result.stderr);
  assert.match(result.stderr, /hoodoo: warning: the cache is not written/);
  assert.deepEqual(await digests(join(folder, 'out')), expected);
}));

/** The bundled example through the command: sound by others' tools, and the same bytes however it is baked. */
import assert from 'node:assert/strict';
import { copyFile, mkdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { digests, example, hoodoo, makeFolder, removeFolder, run, seededRandom, withFolder } from './hoodoo.mjs';
import { check } from './tiles.mjs';

const seed = Number(process.env.HOODOO_SEED ?? Math.floor(Math.random() * 2 ** 31));
let work, scene, reference, expected, seconds;

/** Bakes and demands success. */
async function bake(folder, args = [], options = {}) {
  const result = await hoodoo(['bake', scene, '-o', folder, ...args], options);
  assert.equal(result.code, 0, `bake ${args.join(' ')} ended with ${result.code ?? result.signal}: ${result.stderr}`);
  return result;
}

/** The folder holds the bytes of the reference, file for file. */
async function assertSame(folder) {
  assert.deepEqual(await digests(folder), expected);
}

before(async () => {
  work = await makeFolder();
  const source = join(work, 'source');
  await mkdir(source);
  scene = join(source, 'scene.json');
  await copyFile(join(example, 'scene.json'), scene);
  const made = await hoodoo(['synthesize', join(source, 'dem.tif')]);
  assert.equal(made.code, 0, made.stderr);
  reference = join(work, 'reference');
  seconds = (await bake(reference, ['--threads', '2'])).seconds;
  expected = await digests(reference);
});
after(() => removeFolder(work));

test('--stats tells the columns of the paper\'s Table 1 and changes no file', async () => {
  const { stats } = JSON.parse((await bake(reference, ['--stats', '--json'])).stdout);
  assert.ok(stats.covered > 0 && stats.covered < 1, `covered ${stats.covered}`);
  assert.ok(Number.isInteger(stats.nodes) && stats.nodes > 0);
  assert.ok(stats.memory_bytes >= stats.nodes * 44 && stats.generation_s >= 0 && stats.t_s > 0);
  assert.equal(stats.calls0, stats.grid.reduce((points, cells) => points * (cells + 1), 1));
  assert.ok(stats.calls > 0 && stats.bounded_calls > 0 && stats.bounded_calls < stats.calls0);
  assert.ok(stats.t0_s > 0 && stats.t0_columns_measured > 0);
  assert.ok(stats.tiles_measured > 0 && stats.tiles_measured <= stats.tiles);
  const text = (await bake(reference, ['--stats'])).stdout;
  for (const column of ['a', '#N', 'gen', 'mem', 'grid', 't', 't0', '#C', '#C0']) {
    assert.ok(text.split('\n').some((line) => line.startsWith(`${column} `)), `${column} in ${text}`);
  }
  await assertSame(reference);
});

test('The example has no problem in the eyes of gltf-validator, gltf-transform and draco3d', async (t) => {
  const found = await check(reference);
  t.diagnostic(JSON.stringify(found));
  assert.deepEqual(found.problems, []);
  assert.equal(found.validatorIssues, 0);
  assert.equal(found.openInside, 0, "the example has no hole, so the surface ends only at the world's border");
  assert.ok(found.borderVertices > 0);
});

test('hoodoo verify agrees', async () => {
  const result = await hoodoo(['verify', reference]);
  assert.equal(result.code, 0, result.stdout + result.stderr);
});

test('hoodoo check finds no problem in the example', async () => {
  const result = await hoodoo(['check', scene]);
  assert.equal(result.code, 0, result.stdout + result.stderr);
});

for (const threads of [1, 2, 5]) {
  test(`The example has the same bytes on ${threads} thread${threads > 1 ? 's' : ''}`, () => withFolder(async (folder) => {
    await bake(folder, ['--threads', String(threads)]);
    await assertSame(folder);
  }));
}

test('The example has the same bytes within another memory budget', () => withFolder(async (folder) => {
  await bake(folder, ['--memory', '256']);
  await assertSame(folder);
}));

test('Baking again changes no byte and bakes no tile', () => withFolder(async (folder) => {
  await bake(folder);
  const again = JSON.parse((await bake(folder, ['--json'])).stdout);
  assert.equal(again.reused, again.tiles);
  await assertSame(folder);
}));

test('Tile by tile, in any order, gives the same bytes', () => withFolder(async (folder) => {
  console.log(`seed ${seed}`);
  const random = seededRandom(seed);
  const bake_ = JSON.parse(await readFile(join(reference, 'bake.json'), 'utf8'));
  const keys = bake_.tiles.map((tile) => tile.key)
    .map((key) => [random(), key]).sort(([a], [b]) => a - b).map(([, key]) => key);
  assert.ok(keys.length > 4);
  for (const key of keys) await bake(folder, ['--only', key]);
  await assertSame(folder);
}));

test('Ctrl-C ends with exit 130, and the same command continues', () => withFolder(async (folder) => {
  for (const part of [0.15, 0.5]) {
    const result = await hoodoo(['bake', scene, '-o', folder, '--threads', '1', '--force'],
                                { kill: { after: 1000 * seconds * part, signal: 'SIGINT' } });
    assert.equal(result.signal, null, 'it ends by itself');
    assert.equal(result.code, 130, result.stderr);
    assert.match(result.stderr, /continues/);
  }
  await bake(folder);
  await assertSame(folder);
}));

test("With glibc's AVX2 and FMA dispatch held down, the bytes are the same", () => withFolder(async (folder) => {
  await bake(folder, [], { env: { GLIBC_TUNABLES: 'glibc.cpu.hwcaps=-AVX2,-FMA' } });
  await assertSame(folder);
}));

test('glibc understands the tunable that holds AVX2 and FMA down', async (t) => {
  const loader = '/lib64/ld-linux-x86-64.so.2';
  const active = async (env) => {
    const { stdout } = await run(loader, ['--list-diagnostics'], { env });
    return [0, 1].map((leaf) => [...stdout.matchAll(
      new RegExp(`cpu_features\\.features\\[0x${leaf}\\]\\.active\\[0x([12])\\]=0x([0-9a-f]+)`, 'g'))]
      .map(([, register, value]) => [register, parseInt(value, 16)]));
  };
  const bit = (found, leaf, register, position) => {
    const word = found[leaf].find(([name]) => name === register);
    return word ? (word[1] >>> position) & 1 : undefined;
  };
  const plain = await active({}), held = await active({ GLIBC_TUNABLES: 'glibc.cpu.hwcaps=-AVX2,-FMA' });
  if (bit(plain, 0, '2', 12) !== 1 || bit(plain, 1, '1', 5) !== 1) {
    t.skip('this processor has no AVX2 and FMA, or this glibc does not say');
    return;
  }
  assert.equal(bit(held, 0, '2', 12), 0, 'FMA');
  assert.equal(bit(held, 1, '1', 5), 0, 'AVX2');
});

for (const target of ['avx2', 'sse4', 'ssse3']) {
  test(`Held to ${target}, the bytes are the same`, () => withFolder(async (folder) => {
    await bake(folder, [], { env: { HOODOO_SIMD: target } });
    await assertSame(folder);
  }));
}

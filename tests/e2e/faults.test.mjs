/**
 * Disks that are full or may not be written, damaged caches and elevations, DEMs that change while they are read: each
 * ends with its exit code and a message that names the file, the tileset from before stays whole, and the next run gives the
 * bytes of a calm one.
 *
 * HOODOO_FULL_DISK=1 fills a disk of 64 MiB, too, by a bake that takes minutes.
 */
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { chmod, copyFile, mkdir, open, readFile, readdir, rename, rm, stat, truncate, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { writeDem } from './dem.mjs';
import { assertLoadable, assertNoOrphans, filesBelow } from './folder.mjs';
import { digests, hoodoo, makeFolder, removeFolder, run, seededRandom, withFolder } from './hoodoo.mjs';

const seed = Number(process.env.HOODOO_SEED ?? Math.floor(Math.random() * 2 ** 31));
console.log(`seed ${seed}`);
const random = seededRandom(seed);
const nobody = 65534;   // a user without rights
const asRoot = process.getuid() === 0;
const page = 4096;
let work, coarse, fine;   // scenes of one world, each with the files of a calm bake of it

const sceneOf = (spacing, dem = 'dem.tif') => ({
  hoodoo: 1,
  terrains: [{ id: 'land', dem, falloff: 8 }],
  operations: [{ op: 'union', tree: { type: 'sphere', center: { uv: [0.5, 0.5], ground: 0 }, radius: 30, falloff: 8 } }],
  bake: { spacing, tile_cells: 64 },
});

async function write(name, content, folder = work) {
  const file = join(folder, `${name}.json`);
  await writeFile(file, JSON.stringify(content));
  return file;
}

async function bake(scene, folder, args = []) {
  const result = await hoodoo(['bake', scene, '-o', folder, '--json', ...args]);
  assert.equal(result.code, 0, `${result.signal}: ${result.stderr}`);
  return JSON.parse(result.stdout);
}

/** The files of a calm bake: {name: digest}. */
const calmBake = (scene) => withFolder(async (folder) => {
  await bake(scene, join(folder, 'out'));
  return digests(join(folder, 'out'));
});

async function refused(scene, folder, code, message, args = [], options = {}) {
  const result = await hoodoo(['bake', scene, '-o', folder, ...args], options);
  assert.equal(result.code, code, `${result.signal}: ${result.stderr}`);
  assert.match(result.stderr, message);
  return result;
}

before(async () => {
  work = await makeFolder();
  const made = await hoodoo(['synthesize', join(work, 'dem.tif')]);
  assert.equal(made.code, 0, made.stderr);
  coarse = { scene: await write('coarse', sceneOf(16)) };
  fine = { scene: await write('fine', sceneOf(2)) };
  for (const one of [coarse, fine]) {
    await withFolder(async (folder) => {
      await bake(one.scene, folder);
      one.files = await digests(folder);
      one.pages = Object.fromEntries(await Promise.all(Object.keys(one.files).map(
        async (name) => [name, Math.ceil((await stat(join(folder, name))).size / page)])));
    });
  }
});
after(() => removeFolder(work));

/** The folder holds a finished bake's files as they were, and no temporary. */
async function assertIntact(folder, files) {
  const now = await digests(folder);
  for (const [name, digest] of Object.entries(files)) assert.equal(now[name], digest, `${name} is as it was`);
  assert.deepEqual(Object.keys(now).filter((name) => name.includes('.part')), []);
  await assertLoadable(folder);
}

/** Calls `use(folder)` with a disk of its own of so many pages; skips where mounting is not allowed. */
async function withDisk(t, pages, use) {
  const disk = join(work, 'disk');
  await mkdir(disk, { recursive: true });
  const mounted = await run('mount', ['-t', 'tmpfs', '-o', `size=${pages * page}`, 'tmpfs', disk]).catch((error) => ({ code: 1, stderr: error.message }));
  if (mounted.code !== 0) return t.skip(`no disk may be mounted here: ${mounted.stderr.trim()}`);
  const resize = async (to) => {
    const result = await run('mount', ['-o', `remount,size=${to * page}`, disk]);
    assert.equal(result.code, 0, result.stderr);
  };
  try {
    return await use(join(disk, 'out'), resize);
  } finally {
    await run('umount', [disk]);
  }
}

const sum = (numbers) => numbers.reduce((a, b) => a + b, 0);
const pagesOf = (...all) => sum(Object.values(Object.assign({}, ...all)));

/** What a bake of `fine` over one of `coarse` takes before its index, and the index. */
function takes() {
  const index = fine.pages['bake.json'] + fine.pages['tileset.json'];
  const both = pagesOf(coarse.pages, fine.pages) - fine.pages['bake.json'] - fine.pages['tileset.json'];
  return { before: pagesOf(coarse.pages), files: both + coarse.pages['bake.json'] + coarse.pages['tileset.json'], index };
}

for (const part of [0, 0.1, 0.5, 0.9, 'all but the index', "all but the index's last page"]) {
  test(`A disk that is full, with room for ${typeof part === 'number' ? `${100 * part} %` : part}, ends with exit 4`, async (t) => {
    const { before: had, files, index } = takes();
    const room = part === 'all but the index' ? files + fine.pages['bake.json']
      : typeof part === 'string' ? files + index - 1 : had + Math.floor(part * (files - had));
    await withDisk(t, 2 * (files + index), async (out, resize) => {
      await bake(coarse.scene, out);
      assert.deepEqual(await digests(out), coarse.files);
      await resize(room);
      await refused(fine.scene, out, 4, /^hoodoo: \S+disk\/out\/.*: No space left on device$/m);
      await assertIntact(out, coarse.files);
      await resize(2 * (files + index));
      await bake(fine.scene, out);
      assert.deepEqual(await digests(out), fine.files);
      await assertNoOrphans(out);
    });
  });
}

test('A first bake on a disk without room for the elevations ends with exit 4, and goes on when there is some', async (t) => {
  await withDisk(t, 256, async (out, resize) => {
    await refused(fine.scene, out, 4, /^hoodoo: \S+disk\/out\/.*: No space left on device$/m);
    await resize(2 * (takes().files + takes().index));
    await bake(fine.scene, out);
    assert.deepEqual(await digests(out), fine.files);
  });
});

test('A disk of 64 MiB, filled by a large bake', async (t) => {
  if (!process.env.HOODOO_FULL_DISK) return t.skip('set HOODOO_FULL_DISK=1');
  const made = await hoodoo(['synthesize', join(work, 'large.tif'), '--pixels', '2560']);
  assert.equal(made.code, 0, made.stderr);
  // The first is a corner of the second, so that they share elevations and only tiles find no room.
  const whole = sceneOf(4, 'large.tif'), corner = structuredClone(whole);
  whole.bake.profile = 'plain';
  corner.bake.extent = { min: [0, 0], max: [512, 512] };
  corner.operations = [];
  const small = await write('corner', corner), large = await write('large', whole);
  const [before_, expected] = [await calmBake(small), await calmBake(large)];
  const mebibyte = 2 ** 20 / page;
  await withDisk(t, 64 * mebibyte, async (out, resize) => {
    await bake(small, out);
    const { stderr } = await refused(large, out, 4, /^hoodoo: \S+disk\/out\/.*: No space left on device$/m);
    t.diagnostic(stderr.trim().split('\n').at(-1));
    await assertIntact(out, before_);
    await resize(512 * mebibyte);
    const report = await bake(large, out);
    t.diagnostic(`${report.tiles} tiles, ${report.reused} of them from before; ${report.bytes} bytes of tiles`);
    assert.ok(report.reused > 0);
    assert.deepEqual(await digests(out), expected);
    await assertNoOrphans(out);
  });
});

test('A folder on a disk that may only be read ends with exit 4', async (t) => {
  const place = join(work, 'bound');
  await bake(coarse.scene, place);
  const bound = await run('mount', ['--bind', place, place]).catch((error) => ({ code: 1, stderr: error.message }));
  if (bound.code !== 0) return t.skip(`nothing may be mounted here: ${bound.stderr.trim()}`);
  try {
    assert.equal((await run('mount', ['-o', 'remount,ro,bind', place])).code, 0);
    await refused(fine.scene, place, 4, /bound.*Read-only file system/);
    await refused(coarse.scene, join(place, 'new'), 4, /bound.*Read-only file system/);
    await assertIntact(place, coarse.files);
  } finally {
    await run('umount', [place]);
  }
  await bake(fine.scene, place);
  assert.deepEqual(await digests(place), fine.files);
});

test('A folder of another user ends with exit 4', async (t) => {
  if (!asRoot) return t.skip('only root can be another user');
  await withFolder(async (folder) => {
    for (const name of ['dem.tif', 'fine.json']) await copyFile(join(work, name), join(folder, name));
    const place = join(folder, 'theirs');
    await bake(coarse.scene, place);
    await chmod(folder, 0o755);
    const scene = join(folder, 'fine.json');
    await refused(scene, place, 4, /theirs.*Permission denied/, [], { uid: nobody });
    await refused(scene, join(folder, 'new'), 4, /new.*Permission denied/, [], { uid: nobody });
    await assertIntact(place, coarse.files);
    assert.ok(!existsSync(join(folder, 'new')));
  });
});

const flip = async (file, at) => {
  const bytes = await readFile(file);
  bytes[at(bytes)] ^= 1 << Math.floor(random() * 8);
  await writeFile(file, bytes);
};

/** Where a cache's entry is damaged: its heading, its record, its tile. */
const damages = {
  'the first byte flipped': (file) => flip(file, () => 0),
  'a byte of the digest flipped': (file) => flip(file, (bytes) => bytes.indexOf(10) - 1 - Math.floor(64 * random())),
  'a byte of the record flipped': (file) => flip(file, (bytes) => {
    const from = bytes.indexOf(10) + 1;
    return from + Math.floor(random() * (bytes.indexOf(10, from) - from));
  }),
  'a byte of the tile flipped': (file) => flip(file, (bytes) => {
    const from = bytes.indexOf(10, bytes.indexOf(10) + 1) + 1;
    return from + Math.floor(random() * (bytes.length - from));
  }),
  'the last byte flipped': (file) => flip(file, (bytes) => bytes.length - 1),
  'cut in half': async (file) => truncate(file, Math.floor((await stat(file)).size / 2)),
  'emptied': (file) => truncate(file, 0),
};

test('A cache with every entry damaged is missed, changes no byte, and is made good', () => withFolder(async (folder) => {
  const cache = join(folder, 'cache'), args = ['--cache', cache];
  const first = await bake(coarse.scene, join(folder, 'first'), args);
  const whole = await digests(cache);
  assert.equal(Object.keys(whole).length, first.tiles);
  for (const [what, damage] of Object.entries(damages)) {
    for (const name of Object.keys(whole)) await damage(join(cache, name));
    const out = join(folder, 'again');
    const report = await bake(coarse.scene, out, args);
    assert.equal(report.cached, 0, `${what}, seed ${seed}`);
    assert.deepEqual(await digests(out), coarse.files, what);
    assert.deepEqual(await digests(cache), whole, what);
    await removeFolder(out);
  }
  assert.equal((await bake(coarse.scene, join(folder, 'last'), args)).cached, first.tiles);
}));

/** Options of a run that is halted when its messages match, until `change` is done. */
function halted(pattern, change) {
  let seen = '', met = false;
  const done = { met: () => met };
  done.options = {
    onStart: (child) => child.stderr.on('data', async (text) => {
      seen += text;
      if (met || !pattern.test(seen)) return;
      met = true;
      child.kill('SIGSTOP');
      try {
        await change();
      } catch (error) {
        done.error = error;
      }
      child.kill('SIGCONT');
    }),
  };
  return done;
}

/** A run that is halted once, with `change` in the meantime. */
async function changedWhile(pattern, change, scene, folder, args = []) {
  const halt = halted(pattern, change);
  const result = await hoodoo(['bake', scene, '-o', folder, ...args], halt.options);
  assert.ok(halt.met(), `not halted: ${result.stderr}`);
  assert.equal(halt.error, undefined);
  return result;
}

const side = 3000;
const hills = (bump) => (i, j) => 200 + 40 * Math.sin(i / 90) * Math.cos(j / 70) + (j > side / 2 ? bump : 0);
const anew = { spacing: 32, dem: 'land.tif' };

/** Ways in which a DEM changes while it is read, and what a run after that says. */
const changesOfDem = {
  'rewritten in place': async (file, other) => {
    const handle = await open(file, 'r+');
    await handle.write(await readFile(other));
    await handle.close();
  },
  'replaced by another': (file, other) => rename(other, file),
  'cut short': (file) => truncate(file, 2_000_000),
  'removed': (file) => rm(file),
};

test('A DEM that changes while it is read ends with exit 4, and nothing of it is kept', () => withFolder(async (folder) => {
  const scene = await write('scene', sceneOf(anew.spacing, anew.dem), folder), file = join(folder, anew.dem);
  const [one, two] = ['one.tif', 'two.tif'].map((name) => join(folder, name));
  await writeDem(one, side, 2, hills(0));
  await writeDem(two, side, 2, hills(7));
  await copyFile(two, file);
  const expected = { one: null, two: await calmBake(scene) };
  await copyFile(one, file);
  expected.one = await calmBake(scene);
  assert.notDeepEqual(expected.one, expected.two);
  const out = join(folder, 'out');
  for (const [what, change] of Object.entries(changesOfDem)) {
    let result, reading = false;
    // Halted too late, it has read all of it, and nothing is changed: another try.
    for (let i = 0; i < 5 && !reading; ++i) {
      await removeFolder(out);
      await bake(coarse.scene, out);   // the tileset from before
      await copyFile(one, file);
      const other = join(folder, 'other.tif');
      await copyFile(two, other);
      result = await changedWhile(/elevations \[/, async () => {
        reading = (await filesBelow(join(out, '.hoodoo/elevations'))).some((name) => /part.*level_0/.test(name));
        if (reading) await change(file, other);
      }, scene, out, ['--threads', '1']);
    }
    assert.ok(reading, 'halted while it is read');
    assert.equal(result.code, 4, `${what}: ${result.stderr}`);
    assert.match(result.stderr, /land\.tif.*changed while it was read/, what);
    await assertIntact(out, coarse.files);
    const kept = (await readdir(join(out, '.hoodoo/elevations'))).filter((name) => !name.endsWith('.lock'));
    assert.equal(kept.length, 1, `${what}: only those from before are kept`);
  }

  // The next run reads what is there then.
  await refused(scene, out, 4, /\/terrains\/0\/dem: no file "land\.tif"/);
  await copyFile(two, file);
  await bake(scene, out);
  assert.deepEqual(await digests(out), expected.two);

  // Between two runs it may change as it likes.
  await copyFile(one, file);
  await bake(scene, out);
  assert.deepEqual(await digests(out), expected.one);
  await assertNoOrphans(out);

  // And once its elevations are taken over, the bake needs it no more.
  const late = join(folder, 'late');
  const result = await changedWhile(/tiles \[/, () => truncate(file, 0), scene, late);
  assert.equal(result.code, 0, result.stderr);
  assert.deepEqual(await digests(late), expected.one);
  await refused(scene, late, 2, /land\.tif/);
  await assertIntact(late, expected.one);
}));

test('A DEM that is cut short ends with exit 2, naming it and what is missing', () => withFolder(async (folder) => {
  const scene = await write('scene', sceneOf(8, anew.dem), folder), file = join(folder, anew.dem);
  const out = join(folder, 'out');
  await writeDem(file, 600, 2, hills(0));
  const { size } = await stat(file);
  await bake(coarse.scene, out);
  for (const left of [size - 1, Math.floor(size / 2), 3000]) {
    await truncate(file, left);
    await refused(scene, out, 2, /land\.tif.*is cut short.*rows \d+ to \d+/);
  }
  for (const left of [100, 8, 1, 0]) {
    await truncate(file, left);
    await refused(scene, out, 2, /land\.tif/);
  }
  await assertIntact(out, coarse.files);
}));

/** The folder of the elevations in a bake's folder. */
async function elevationsIn(folder) {
  const place = join(folder, '.hoodoo/elevations');
  const names = (await readdir(place)).filter((name) => existsSync(join(place, name, 'pyramid.json')));
  return names.map((name) => join(place, name));
}

/** Flips a bit in every chunk of every level. */
async function spoil(folder) {
  for (const place of await elevationsIn(folder)) {
    for (const name of (await readdir(place)).filter((name_) => name_.endsWith('.f32'))) {
      const file = join(place, name), bytes = await readFile(file), chunk = 4 * 256 * 256;
      for (let at = Math.floor(random() * chunk); at < bytes.length; at += chunk) bytes[at] ^= 1 << Math.floor(random() * 8);
      const handle = await open(file, 'r+');   // in place, as a disk would
      await handle.write(bytes, 0, bytes.length, 0);
      await handle.close();
    }
  }
}

test('Elevations damaged while they are read end with exit 4; the next run makes them anew', () => withFolder(async (folder) => {
  const out = join(folder, 'out');
  await bake(coarse.scene, out);
  const before_ = Object.entries(coarse.files).filter(([name]) => !name.startsWith('.hoodoo/elevations'));
  const result = await changedWhile(/tiles \[/, () => spoil(out), fine.scene, out);
  assert.equal(result.code, 4, result.stderr);
  assert.match(result.stderr, /elevations.*level_\d+\.f32.*chunk \d+ is damaged.*the next run/);
  await assertIntact(out, Object.fromEntries(before_));
  await bake(fine.scene, out);
  assert.deepEqual(await digests(out), fine.files);
  await assertNoOrphans(out);
}));

test('Elevations removed while they are read are made anew by the next run at the latest', () => withFolder(async (folder) => {
  const out = join(folder, 'out');
  await bake(coarse.scene, out);
  const result = await changedWhile(/tiles \[/, () => removeFolder(join(out, '.hoodoo/elevations')), fine.scene, out);
  assert.ok([0, 4].includes(result.code), result.stderr);
  await assertLoadable(out);
  await bake(fine.scene, out);
  assert.deepEqual(await digests(out), fine.files);
}));

/** What may be wrong with elevations from an earlier run. */
const wrong = {
  'a byte of the index flipped': (place) => flip(join(place, 'pyramid.json'), (bytes) => bytes.indexOf('"width"') + 10),
  'the index cut short': (place) => truncate(join(place, 'pyramid.json'), 100),
  'a byte of the table of chunks flipped': (place) => flip(join(place, 'chunks.bin'), (bytes) => Math.floor(random() * bytes.length)),
  'the table of chunks missing': (place) => rm(join(place, 'chunks.bin')),
  'a level missing': (place) => rm(join(place, 'level_0.f32')),
};

for (const [what, damage] of Object.entries(wrong)) {
  test(`Elevations with ${what} are made anew`, () => withFolder(async (folder) => {
    const out = join(folder, 'out');
    await bake(fine.scene, out, ['--only', '0/0/0']);
    for (const place of await elevationsIn(out)) await damage(place);
    await bake(fine.scene, out);
    assert.deepEqual(await digests(out), fine.files);
  }));
}

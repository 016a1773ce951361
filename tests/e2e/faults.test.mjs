/**
 * Damaged caches and elevations, DEMs that change while they are read: each ends with its exit code and a message that names the file,
 * the tileset from before stays whole, and the next run gives the bytes of a calm one. Disks: disks.test.mjs.
 */
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { copyFile, open, readFile, readdir, rename, rm, stat, truncate, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { writeDem } from './dem.mjs';
import { assertIntact, bake, calmBake, makeWorld, refused, sceneOf, write } from './faults.mjs';
import { assertLoadable, assertNoOrphans, filesBelow } from './folder.mjs';
import { digests, hoodoo, removeFolder, seededRandom, withFolder } from './hoodoo.mjs';

const seed = Number(process.env.HOODOO_SEED ?? Math.floor(Math.random() * 2 ** 31));
console.log(`seed ${seed}`);
const random = seededRandom(seed);
let work, coarse, fine;

before(async () => { ({ work, coarse, fine } = await makeWorld()); });
after(() => removeFolder(work));

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
  const scene = await write(folder, 'scene', sceneOf(anew.spacing, anew.dem)), file = join(folder, anew.dem);
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
  const scene = await write(folder, 'scene', sceneOf(8, anew.dem)), file = join(folder, anew.dem);
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

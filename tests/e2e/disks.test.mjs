/**
 * Disks that are full or may not be written: a bake ends with its exit code and a message that names the file, the tileset from before
 * stays whole, and the next run gives the bytes of a calm one.
 *
 * HOODOO_FULL_DISK=1 fills a disk of 64 MiB, too, by a bake that takes minutes.
 */
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { chmod, copyFile, mkdir } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { assertIntact, bake, calmBake, makeWorld, page, refused, sceneOf, write } from './faults.mjs';
import { assertNoOrphans } from './folder.mjs';
import { digests, removeFolder, run, synthesize, withFolder } from './hoodoo.mjs';

const nobody = 65534;   // a user without rights
const asRoot = process.getuid() === 0;
let work, coarse, fine;

before(async () => { ({ work, coarse, fine } = await makeWorld()); });
after(() => removeFolder(work));

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
  await synthesize(join(work, 'large.tif'), '--pixels', '2560');
  // The first is a corner of the second, so that they share elevations and only tiles find no room.
  const whole = sceneOf(4, 'large.tif'), corner = structuredClone(whole);
  whole.bake.profile = 'plain';
  corner.bake.extent = { min: [0, 0], max: [512, 512] };
  corner.operations = [];
  const small = await write(work, 'corner', corner), large = await write(work, 'large', whole);
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

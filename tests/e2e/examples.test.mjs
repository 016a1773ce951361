/** The bundled examples through the command: each is a scene without a problem, and bakes to a sound tileset. */
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { copyFile, stat } from 'node:fs/promises';
import { basename, join } from 'node:path';
import { test } from 'node:test';
import { examples, hoodoo, withFolder } from './hoodoo.mjs';

const most = { 'picture.png': 300e3, 'dem.tif': 150e3 };   // bytes

/** Calls `use` with a copy of the example's scene beside its DEM, the sample one where it brings none. */
function withExample(folder, use) {
  return withFolder(async (copy) => {
    const scene = join(copy, 'scene.json'), dem = join(copy, 'dem.tif');
    await copyFile(join(folder, 'scene.json'), scene);
    if (existsSync(join(folder, 'dem.tif'))) await copyFile(join(folder, 'dem.tif'), dem);
    else assert.equal((await hoodoo(['synthesize', dem])).code, 0);
    return use(scene, join(copy, 'out'));
  });
}

for (const folder of examples()) {
  const name = basename(folder);
  test(`${name} has neither a problem nor an oddity`, () => withExample(folder, async (scene) => {
    const result = await hoodoo(['--json', 'check', scene]);
    assert.equal(result.code, 0, result.stdout + result.stderr);
    assert.deepEqual(JSON.parse(result.stdout), { problems: [], warnings: [] });
  }));

  test(`${name} bakes to a tileset that verifies`, () => withExample(folder, async (scene, out) => {
    const baked = await hoodoo(['bake', scene, '-o', out]);
    assert.equal(baked.code, 0, baked.stderr);
    const verified = await hoodoo(['verify', out]);
    assert.equal(verified.code, 0, verified.stdout + verified.stderr);
  }));

  // The first one makes its DEM when it is set up, and its picture is that of the front page.
  if (name !== 'first-light') {
    test(`${name} has a picture and a DEM that are small`, async () => {
      for (const [file, bytes] of Object.entries(most)) {
        const { size } = await stat(join(folder, file));
        assert.ok(size < bytes, `${file} has ${size} bytes`);
      }
    });
  }
}

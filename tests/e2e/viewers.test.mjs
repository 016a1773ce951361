/**
 * Two viewers, three.js with 3d-tiles-renderer (our own) and CesiumJS, draw tilesets with several levels on screen. What
 * the welded meshes of those levels cover, both cover without a hole; and they agree on the silhouette.
 *
 * At the silhouette's edge a coarser level may lie off the leaves by the error on screen that was asked for, and a pixel.
 * Farther inside no background shows, and at any depth none where all levels on screen have surface.
 */
import assert from 'node:assert/strict';
import { copyFile, mkdir, writeFile } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { compare, holes, launch, openPage, readMask, serveFolders, settle } from './browser.mjs';
import { example, hoodoo, makeFolder, removeFolder, testData } from './hoodoo.mjs';
import { lookInto } from './tiles/look.mjs';

const fov = 50;          // degrees, as in the viewer
const error = 6;         // pixels on screen
const most = 0.005;      // share of the silhouette by which the viewers may differ

/** An arch over a tunnel at (u, v) of a DEM, `s` metres a cell. */
function sceneAt(dem, u, v, s, [width, height], bake = {}) {
  const at = (x, y, dz) => ({ uv: [u + (x * s) / width, v + (y * s) / height], ground: dz * s });
  return {
    hoodoo: 1, name: dem, terrains: [{ dem }], bake,
    operations: [
      { type: 'arch', from: at(-24, -16, -2), to: at(24, -16, -2), height: 36 * s, thickness: 12 * s },
      { type: 'tunnel', path: [9, -3, -15, -15, -15, -3, 9].map((dz, i) => at(-24 + 8 * i, 10, dz)), radius: 6.5 * s },
    ],
  };
}

/** Sea cliffs whose tiles are all written as several slabs of z. */
const slabs = { tile_triangles: 1000, tile_cells: 64 };

/** What to draw: a scene, and cameras as parts of the world's box, z from its floor in its longer side. */
const worlds = [
  {
    name: 'the example',
    scene: async (folder) => {
      await copyFile(join(example, 'scene.json'), join(folder, 'scene.json'));
      const made = await hoodoo(['synthesize', join(folder, 'dem.tif')]);
      assert.equal(made.code, 0, made.stderr);
    },
    cameras: { 'from its corner': [[-0.1, -0.15, 0.35], [0.45, 0.5, 0.02]], 'near the ground': [[0.12, 0.1, 0.28], [0.6, 0.8, 0.05]] },
  },
  {
    name: 'sea cliffs with a hole', dem: 'seacliff_aoi4_1m_utm10n_f32_nodata.tif',
    scene: (folder, dem) => writeFile(join(folder, 'scene.json'), JSON.stringify(sceneAt(dem, 0.75, 0.5, 1, [427, 721]))),
    cameras: { whole: [[-0.3, -0.5, 0.7], [0.5, 0.5, 0.05]], 'along the cliff': [[0.3, 0.05, 0.2], [0.6, 0.9, 0.05]] },
  },
  {
    name: 'the same in slabs', dem: 'seacliff_aoi4_1m_utm10n_f32_nodata.tif',
    scene: (folder, dem) => writeFile(join(folder, 'scene.json'), JSON.stringify(sceneAt(dem, 0.75, 0.5, 1, [427, 721], slabs))),
    cameras: { whole: [[-0.3, -0.5, 0.7], [0.5, 0.5, 0.05]] },
  },
  {
    name: 'canyons in Zion', dem: 'zion_90m_epsg4326_u16.tif',
    scene: (folder, dem) => writeFile(join(folder, 'scene.json'), JSON.stringify(sceneAt(dem, 0.5, 0.5, 75, [34000, 42000]))),
    cameras: { whole: [[-0.3, -0.5, 0.6], [0.5, 0.5, 0.02]], 'over the rim': [[0.1, 0.1, 0.12], [0.7, 0.8, 0.03]] },
  },
  {
    name: 'the same by meshopt', dem: 'zion_90m_epsg4326_u16.tif',
    scene: (folder, dem) => writeFile(join(folder, 'scene.json'), JSON.stringify(
      sceneAt(dem, 0.5, 0.5, 75, [34000, 42000], { profile: 'meshopt' }))),
    cameras: { 'over the rim': [[0.1, 0.1, 0.12], [0.7, 0.8, 0.03]] },
  },
  {
    name: 'the same on the Earth', dem: 'zion_90m_epsg4326_u16.tif',
    scene: (folder, dem) => writeFile(join(folder, 'scene.json'), JSON.stringify(
      sceneAt(dem, 0.5, 0.5, 75, [34000, 42000], { frame: 'ecef', vertical: 'EPSG:5773' }))),
    cameras: { whole: [[-0.3, -0.5, 0.6], [0.5, 0.5, 0.02]] },
  },
];

let browser;
before(async () => { browser = await launch(); });
after(() => browser?.close());

/** A point by parts of the box of 3D Tiles: centre, then half axes. */
function pointIn(box, [u, v, w]) {
  const [x, y, z, hx, , , , hy, , , , hz] = box;
  return [x + (2 * u - 1) * hx, y + (2 * v - 1) * hy, z - hz + w * 2 * Math.max(hx, hy)];
}

async function drawByThree(server, camera, { skirts = true } = {}) {
  const page = await openPage(browser, server.url);
  const list = (point) => point.join(',');
  await page.goto(`${server.url}/viewer/?tileset=/tileset/tileset.json&noui&bg=magenta&err=${error}` +
                  `&cam=${list(camera.position)}&at=${list(camera.target)}`);
  await settle(page);
  if (!skirts) {
    await page.evaluate(() => globalThis.hoodoo.terrain.setLook({ skirts: false }));
    await settle(page);
  }
  const { shown, errors } = await page.evaluate(() => ({
    shown: globalThis.hoodoo.terrain.visibleTiles.map(({ tile }) => tile.content.uri), errors: globalThis.hoodoo.errors,
  }));
  const mask = await readMask(page);
  await page.end();
  return { mask, shown, problems: [...page.problems, ...errors] };
}

async function drawByCesium(server, camera) {
  const page = await openPage(browser, server.url);
  await page.goto(`${server.url}/pages/cesium.html`);
  await page.waitForFunction(() => globalThis.drawTileset);
  const middle = await page.evaluate(([url, pixels]) => globalThis.loadTileset(url, pixels), [`${server.url}/tileset/tileset.json`, error]);
  const { shown, errors } = await page.evaluate((view) => globalThis.drawTileset(view), camera);
  const mask = await readMask(page);
  await page.end();
  return { mask, shown, problems: [...page.problems, ...errors], middle };
}

/** Longitude and latitude of a geographic DEM's middle, by its own georeference. */
async function middleOf(dem) {
  const { stdout } = await hoodoo(['info', dem, '--json']);
  const { transform, width, height } = JSON.parse(stdout);
  return [transform[0] + (transform[1] * width) / 2, transform[3] + (transform[5] * height) / 2];
}

for (const world of worlds) {
  const dem = world.dem && join(testData, 'dem', world.dem);
  const skip = dem && !existsSync(dem) ? `${dem} is not there` : false;
  describe(world.name, { skip }, () => {
    let work, server, known, unsplit;
    const meshes = new Map();   // numbers by level

    before(async () => {
      work = await makeFolder();
      await mkdir(join(work, 'scene'));
      if (dem) await copyFile(dem, join(work, 'scene', world.dem));
      await world.scene(join(work, 'scene'), world.dem);
      const baked = await hoodoo(['bake', join(work, 'scene/scene.json'), '-o', join(work, 'tileset')]);
      assert.equal(baked.code, 0, baked.stderr);
      known = await lookInto(join(work, 'tileset'));
      server = await serveFolders({ '/tileset/': join(work, 'tileset') });
      unsplit = await openPage(browser, server.url);
      await unsplit.goto(`${server.url}/pages/unsplit.html`);
      await unsplit.waitForFunction(() => globalThis.loadMesh);
    });
    after(async () => {
      await unsplit?.end();
      await server?.close();
      if (work) await removeFolder(work);
    });

    const cameraAt = ([from, to]) => {
      const { box } = known;
      const size = 2 * Math.max(box[3], box[7]);
      return { position: pointIn(box, from), target: pointIn(box, to), fov, near: size / 2000, far: 10 * size };
    };
    const levelsOf = (shown) => new Set(shown.map((file) => known.levels.get(/([0-9a-f]+\.glb)(\?|$)/.exec(file)[1])));

    /** What the leaves cover, then what each other of `levels` does. */
    const drawUnsplit = async (camera, levels) => {
      const masks = [];
      for (const level of new Set([0, ...levels])) {
        if (!meshes.has(level)) {
          const files = known.files[level];
          const mesh = await unsplit.evaluate((urls) => globalThis.loadMesh(urls), files.map((file) => `/tileset/${file}`));
          assert.ok(files.length === 1 || mesh.welded < mesh.vertices, 'neighbours share vertices to the bit');
          meshes.set(level, mesh.number);
        }
        await unsplit.evaluate(([number, view]) => globalThis.drawMesh(number, view), [meshes.get(level), camera]);
        masks.push(await readMask(unsplit));
      }
      assert.deepEqual(unsplit.problems, []);
      return masks;
    };

    for (const [name, view] of Object.entries(world.cameras)) {
      test(`${name}: no background inside what the leaves cover, and the same silhouette`, async (t) => {
        const camera = cameraAt(view);
        const drawn = { three: await drawByThree(server, camera), cesium: await drawByCesium(server, camera) };
        for (const [viewer, { mask, shown, problems }] of Object.entries(drawn)) {
          assert.deepEqual(problems, [], viewer);
          const onScreen = levelsOf(shown);
          assert.ok(onScreen.size > 1, `${viewer} shows several levels at once, not ${[...onScreen]}`);
          const solids = await drawUnsplit(camera, onScreen);
          assert.deepEqual([mask.width, mask.height], [solids[0].width, solids[0].height], viewer);
          const found = holes(mask, solids, error + 1);
          t.diagnostic(`${viewer}: ${shown.length} tiles of levels ${[...onScreen].sort()}, holes ${JSON.stringify(found)}`);
          assert.deepEqual(found, { deep: 0, cracks: 0 }, viewer);
        }
        if (known.transform) {
          const [longitude, latitude, height] = drawn.cesium.middle, [x, y] = await middleOf(dem);
          const off = 111_320 * Math.hypot((longitude - x) * Math.cos((y * Math.PI) / 180), latitude - y);
          t.diagnostic(`its middle lies ${off.toFixed(0)} m from the DEM's, ${height.toFixed(0)} m high`);
          assert.ok(off < 300, 'CesiumJS shows it at the place of the DEM');   // its box leans by the grid's convergence
          assert.ok(height > 500 && height < 4000, 'at its height');
        }
        const { covered, share } = compare(drawn.three.mask, drawn.cesium.mask);
        t.diagnostic(`${covered} pixels covered, the viewers differ by ${(100 * share).toFixed(3)} %`);
        assert.ok(covered > 0.1 * drawn.three.mask.bits.length, 'the terrain is in the picture');
        assert.ok(share <= most, `the silhouettes differ by ${100 * share} %`);
      });
    }

    test('The measure sees the cracks between levels that skirts close', async (t) => {
      let found = 0;
      for (const view of Object.values(world.cameras)) {
        const camera = cameraAt(view);
        const { mask, shown } = await drawByThree(server, camera, { skirts: false });
        found += holes(mask, await drawUnsplit(camera, levelsOf(shown)), error + 1).cracks;
      }
      t.diagnostic(`${found} pixels without skirts`);
      assert.ok(found > 0);
    });
  });
}

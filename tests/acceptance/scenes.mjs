/**
 * Scenes whose features stand on borders and corners of tiles, on the DEM that `hoodoo synthesize` writes and on one of
 * the test data. Lengths in metres.
 */
import { existsSync } from 'node:fs';
import { copyFile, cp, readFile, writeFile } from 'node:fs/promises';
import { basename, join } from 'node:path';
import { examples, hoodoo, testData } from '../e2e/hoodoo.mjs';

/** Heights of the ground at [[x, y], ...], from the field itself: by halving, to a centimetre. */
async function groundAt(folder, dem, places) {
  const file = join(folder, 'bare.json'), table = join(folder, 'points.csv');
  await writeFile(file, JSON.stringify({ hoodoo: 1, name: 'bare', terrains: [{ dem }], operations: [] }));
  const low = places.map(() => -200), high = places.map(() => 600);
  for (let round = 0; round < 17; ++round) {
    const middle = low.map((z, i) => (z + high[i]) / 2);
    await writeFile(table, `x,y,z\n${places.map(([x, y], i) => `${x},${y},${middle[i]}`).join('\n')}\n`);
    const { code, stdout, stderr } = await hoodoo(['probe', file, '--points', table]);
    if (code !== 0) throw new Error(stderr);
    stdout.trim().split('\n').slice(1).forEach((line, i) => {
      if (Number(line.split(',')[3]) > 0.5) low[i] = middle[i];
      else high[i] = middle[i];
    });
  }
  return low;
}

/** The synthetic coast, 2 m a pixel: sea in the west, a plateau in the east. Tiles of 32 cells: corners every 64 m. */
async function onTheCoast(folder, places, operations, bake = {}) {
  const made = await hoodoo(['synthesize', join(folder, 'dem.tif')]);
  if (made.code !== 0) throw new Error(made.stderr);
  const ground = await groundAt(folder, 'dem.tif', places);
  const { list, inside = [] } = operations(ground);
  return {
    inside,
    scene: {
      hoodoo: 1, name: 'coast', seed: 3, terrains: [{ dem: 'dem.tif' }], operations: list,
      geology: { type: 'strata', wavelength: 30, octaves: 3 },
      bake: { tile_cells: 32, extent: { min: [192, 192], max: [832, 832] }, ...bake },
    },
  };
}

const difference = (tree) => ({ op: 'difference', tree });
const union = (tree) => ({ op: 'union', tree });
const capsule = (from, to, radius) => ({ type: 'capsule', from, to, radius, falloff: radius });
const sphere = (center, radius) => ({ type: 'sphere', center, radius, falloff: radius });

/**
 * Each makes its files in a folder and gives {scene, inside: [[eye, target], ...] of cameras within caves}.
 * `levels` to be seen at once are asked of those of several.
 */
export const scenes = {
  'caves through four tiles': (folder) => {
    const [x, y] = [576, 512];
    return onTheCoast(folder, [[x, y]], ([top]) => {
      const z = top - 34;
      return {
        list: [
          difference(capsule([x - 110, y, z], [x + 110, y, z], 9)),
          difference(capsule([x, y - 110, z], [x, y + 60, z + 6], 9)),
          difference(sphere([x, y, z], 20)),
          difference(capsule([x + 64, y, z], [x + 64, y - 10, z + 60], 6)),
          union(capsule([x - 12, y - 12, z - 26], [x - 12, y - 12, z + 26], 2.5)),
        ],
        inside: [
          [[x + 6, y + 6, z], [x + 60, y, z]], [[x + 6, y + 6, z], [x - 60, y + 1, z]], [[x + 6, y + 6, z], [x, y + 50, z + 4]],
          [[x + 6, y + 6, z], [x, y - 60, z - 3]], [[x + 6, y + 6, z], [x + 10, y + 12, z + 40]], [[x + 6, y + 6, z], [x - 8, y - 9, z - 15]],
          [[x + 90, y, z], [x, y, z]], [[x, y - 90, z], [x, y, z]],
        ],
      };
    });
  },
  'arches over tile corners': (folder) => {
    const corners = [[576, 512], [640, 384], [512, 640]];
    return onTheCoast(folder, corners, (tops) => ({
      list: corners.map(([x, y], i) => ({
        type: 'arch', from: [x - 34, y - 30, tops[i] - 4], to: [x + 34, y + 30, tops[i] - 4], height: 44, thickness: 9,
      })),
      inside: corners.map(([x, y], i) => [[x - 12, y + 14, tops[i] + 12], [x + 30, y - 34, tops[i] + 14]]),
    }));
  },
  'tall tiles in slabs': (folder) => {
    const [x, y] = [576, 512];
    return onTheCoast(folder, [[x, y]], ([top]) => ({
      list: [
        ...[[0, 0], [26, 8], [-22, 20], [10, -28]].map(([dx, dy]) => (
          union(capsule([x + dx, y + dy, top - 10], [x + dx, y + dy, top + 120 + 2 * dx], 8)))),
        difference(capsule([x - 40, y - 40, top + 20], [x - 40, y - 40, top - 90], 14)),
        difference(capsule([x - 40, y - 40, top - 80], [x + 60, y + 40, top - 80], 10)),
      ],
      inside: [
        [[x - 40, y - 40, top - 60], [x - 38, y - 41, top + 40]], [[x - 30, y - 33, top - 80], [x + 60, y + 40, top - 80]],
        [[x + 40, y + 24, top - 80], [x - 40, y - 40, top - 78]],
      ],
    }), { tile_triangles: 1000 });
  },
  'undercut cliffs': (folder) => onTheCoast(folder, [[320, 420]], () => ({
    list: [
      { type: 'curve', op: 'carve', points: [[338, 300, 13], [332, 372, 13], [322, 396, 13], [318, 442, 13], [302, 500, 13]], radius: 20,
        turbulence: { amplitude: 4, wavelength: 30, seed: 6 } },
      { type: 'cave', op: 'carve', entrance: [334, 520, 14], direction: [1, 0.15, 0.05], depth: 76, radius: 17, chamber_radius: 26 },
    ],
    inside: [[[384, 527, 18], [440, 535, 22]], [[384, 527, 18], [340, 520, 15]]],
  })),
  'a hole in the DEM': async (folder) => {
    const dem = 'seacliff_aoi4_1m_utm10n_f32_nodata.tif';
    await copyFile(join(testData, 'dem', dem), join(folder, dem));
    const [top] = await groundAt(folder, dem, [[320, 352]]);
    const z = top - 12;
    return {
      inside: [[[316, 352, z], [280, 352, z]], [[324, 352, z], [352, 352, z]]],
      scene: {
        hoodoo: 1, name: 'hole', terrains: [{ dem }], bake: { tile_cells: 64 },
        operations: [
          difference(capsule([270, 352, z], [370, 352, z], 6)), difference(capsule([320, 300, z + 20], [320, 410, z], 6)),
          { type: 'arch', from: [300, 330, top - 4], to: [340, 374, top - 4], height: 30, thickness: 7 },
        ],
      },
    };
  },
  'floating islands': (folder) => {
    const [x, y] = [576, 512];
    const island = (dx, dy, dz, r) => union({
      type: 'ellipsoid', center: [x + dx, y + dy, 210 + dz], radii: [r, r, 0.4 * r], falloff: 0.4 * r,
      turbulence: { amplitude: 5, wavelength: 28, seed: 9 },
    });
    return onTheCoast(folder, [[x, y]], () => ({
      list: [
        island(0, 0, 0, 60), island(-130, 66, 30, 36), island(128, -64, -10, 30), island(64, 128, 20, 44),
        difference(capsule([x - 70, y, 210], [x + 70, y + 4, 210], 8)),
      ],
      inside: [[[x + 10, y, 210], [x + 80, y + 4, 210]], [[x - 10, y, 210], [x - 80, y, 210]]],
    }));
  },
};

/** The bundled examples, by name. */
export const gallery = Object.fromEntries(examples().map((from) => [basename(from), async (folder) => {
  await cp(from, folder, { recursive: true });
  if (!existsSync(join(folder, 'dem.tif'))) {
    const made = await hoodoo(['synthesize', join(folder, 'dem.tif')]);
    if (made.code !== 0) throw new Error(made.stderr);
  }
  return { scene: JSON.parse(await readFile(join(folder, 'scene.json'), 'utf8')), inside: [] };
}]));

/** hoodoo diff: two bakes of a ball high over the land, which moves by 2 m; and what cannot be compared. */
import assert from 'node:assert/strict';
import { cp, open, readFile, rm, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';

const moved = 2;   // m
let work;

/** Bakes the land with a ball high over it into `name`; tiles of 64 m. */
async function bake(name, { center = [95, 96, 200], radius = 10 }, spacing = 1) {
  const scene = join(work, `${name}.json`);
  await writeFile(scene, JSON.stringify({
    hoodoo: 1,
    terrains: [{ id: 'land', dem: 'dem.tif', falloff: 8 }],
    operations: [{ id: 'ball', op: 'union', tree: { type: 'sphere', center, radius, falloff: 8 } }],
    bake: { spacing, tile_cells: 64 },
  }));
  const result = await hoodoo(['bake', scene, '-o', join(work, name)]);
  assert.equal(result.code, 0, result.stderr);
}

const diff = (first, second, ...args) => hoodoo(['diff', join(work, first), join(work, second), ...args]);

async function diffJson(first, second, ...args) {
  const result = await diff(first, second, '--json', ...args);
  return { code: result.code, found: JSON.parse(result.stdout) };
}

/** A copy of the bake `a`, changed. */
async function changed(name, change) {
  await cp(join(work, 'a'), join(work, name), { recursive: true });
  await change(join(work, name), JSON.parse(await readFile(join(work, name, 'bake.json'), 'utf8')));
}

/** Could not be compared: exit 2, and a message. */
async function refused(name, message) {
  for (const pair of [['b', name], [name, 'b']]) {
    const result = await diff(...pair);
    assert.equal(result.code, 2, result.stdout + result.stderr);
    assert.match(result.stderr, /^hoodoo: /);
    assert.match(result.stderr, message);
    assert.equal(result.stdout, '');
  }
}

before(async () => {
  work = await makeFolder();
  const made = await hoodoo(['synthesize', join(work, 'dem.tif'), '--pixels', '96', '--spacing', '2']);
  assert.equal(made.code, 0, made.stderr);
  await bake('a', {});
  await bake('b', { center: [95 + moved, 96, 200] });
  await bake('same', {});
  await bake('border', { center: [127, 96, 200] });
  await bake('over', { center: [127 + moved, 96, 200] });
  await bake('coarse', {}, 1.5);
});
after(() => removeFolder(work));

test('The same scene baked twice is the same, and no tile is read', async () => {
  const { code, found } = await diffJson('a', 'same');
  assert.equal(code, 0);
  assert.equal(found.same, true);
  assert.equal(found.read, 0);
  assert.equal(found.equal, found.compared);
  assert.ok(found.compared > 9);
  assert.deepEqual(found.tiles, []);
});

test('A ball that moved by 2 m is found in its tiles and no others, by 2 m', async () => {
  const { code, found } = await diffJson('a', 'b');
  assert.equal(code, 1);
  assert.equal(found.same, false);
  assert.deepEqual(found.tiles.map((tile) => tile.key).sort(), ['0/1/1', '1/0/0', '2/0/0']);
  const leaf = found.tiles.find((tile) => tile.key === '0/1/1');
  assert.ok(Math.abs(leaf.largest - moved) < 0.05 * moved, `${leaf.largest} m`);
  assert.ok(leaf.mean > 0 && leaf.mean < leaf.largest);
  assert.equal(found.largest, leaf.largest);
});

/** Keys of the tiles that a ball's surface, before or after, stands over. */
function under(...balls) {
  const keys = [];
  for (let level = 0; level < 3; ++level) {
    const side = 64 * 2 ** level;
    for (let i = 0; i * side < 192; ++i) {
      for (let j = 0; j * side < 192; ++j) {
        const off = (at, k) => Math.max(k * side - at, 0, at - (k + 1) * side);
        if (balls.some(({ center: [x, y], radius }) => Math.hypot(off(x, i), off(y, j)) < radius)) keys.push(`${level}/${i}/${j}`);
      }
    }
  }
  return keys.sort();
}

/** From a ball of radius 10 m at (95, 96, 200): how far the surfaces are apart then [m]. */
const changes = {
  'moved by 3 m east and 4 m south': [{ center: [98, 92, 200] }, 5],
  'moved up by 3 m': [{ center: [95, 96, 203] }, 3],
  'moved by more than its size into the next tile': [{ center: [95, 120, 200] }, 24],
  'grown by 3 m': [{ radius: 13 }, 3],
  'shrunk by 4 m': [{ radius: 6 }, 4],
};

for (const [what, [after_, distance]] of Object.entries(changes)) {
  test(`A ball ${what} is found under it before and after, ${distance} m off`, async (t) => {
    const first = { center: [95, 96, 200], radius: 10 };
    await bake('changed', after_);
    for (const pair of [['a', 'changed'], ['changed', 'a']]) {
      const { code, found } = await diffJson(...pair);
      assert.equal(code, 1);
      assert.deepEqual(found.tiles.map((tile) => tile.key).sort(), under(first, { ...first, ...after_ }));
      t.diagnostic(`${found.largest} m`);
      assert.ok(Math.abs(found.largest - distance) < 0.05 * distance, `${found.largest} m, not ${distance} m`);
    }
    assert.equal((await diff('a', 'changed', '--tolerance', String(1.06 * distance))).code, 0);
    assert.equal((await diff('a', 'changed', '--tolerance', String(0.94 * distance))).code, 1);
  });
}

test('A ball that moves over a border is as far from where it was as any', async () => {
  const { code, found } = await diffJson('border', 'over');
  assert.equal(code, 1);
  assert.deepEqual(found.tiles.map((tile) => tile.key).sort(), ['0/1/1', '0/2/1', '1/0/0', '1/1/0', '2/0/0']);
  for (const tile of found.tiles.filter(({ key }) => key.startsWith('0/'))) {
    assert.ok(Math.abs(tile.largest - moved) < 0.05 * moved, `${tile.key}: ${tile.largest} m`);
  }
});

test('Within a tolerance above the distance they are the same, below it they are not', async () => {
  assert.equal((await diff('a', 'b', '--tolerance', '2.2')).code, 0);
  assert.equal((await diff('a', 'b', '--tolerance', '1.8')).code, 1);
});

test('The text begins with the worst tile and ends with the verdict', async () => {
  const { code, stdout } = await diff('a', 'b');
  assert.equal(code, 1);
  const lines = stdout.trimEnd().split('\n');
  assert.match(lines[0], /^0\/1\/1 +largest (2|1\.9\d*|2\.0\d*) m, mean /);
  assert.match(lines.at(-2), /^3 of \d+ tiles differ, 0 added, 0 gone; largest distance between leaves /);
  assert.equal(lines.at(-1), 'different');
});

test('Bakes of another spacing are compared by region, by distance alone', async () => {
  const { code, found } = await diffJson('a', 'coarse');
  assert.equal(code, 1);
  assert.equal(found.by, 'region');
  assert.deepEqual(found.spacings, [1, 1.5]);
  assert.equal(found.compared, 9);
  assert.ok(found.largest > 0 && found.largest < 1.5, `${found.largest} m`);
  for (const tile of found.tiles) assert.ok(!('material' in tile) && !('normal' in tile));
  assert.equal((await diff('a', 'coarse', '--tolerance', '1.5')).code, 0);
  assert.match((await diff('coarse', 'b')).stdout, /spacing 1.5 m and 1 m.*by distance alone.*second bake/);
  // The scene's origin is a multiple of its spacing, and the ball is placed from there.
  const origin = async (name) => JSON.parse(await readFile(join(work, name, 'bake.json'), 'utf8')).frame.origin;
  const [from, to] = [await origin('coarse'), await origin('b')];
  const distance = Math.hypot(moved + to[0] - from[0], to[1] - from[1]);
  const ball = (await diffJson('coarse', 'b', '--tolerance', '1.5')).found;
  assert.deepEqual(ball.tiles.filter((tile) => tile.beyond).map((tile) => tile.key), ['0/1/1']);
  assert.ok(Math.abs(ball.largest - distance) < 0.05 * distance, `${ball.largest} m, not ${distance} m`);
});

test('The JSON has the documented keys', async () => {
  const { found } = await diffJson('a', 'b');
  assert.deepEqual(Object.keys(found).sort(), ['added', 'beyond', 'by', 'changed', 'compared', 'equal', 'gone', 'largest',
                                               'levels', 'mean', 'read', 'same', 'spacings', 'tiles', 'tolerance']);
  assert.deepEqual(Object.keys(found.tiles[0]).sort(), ['beyond', 'change', 'key', 'largest', 'material', 'mean', 'normal']);
  assert.deepEqual(Object.keys(found.levels[0]).sort(), ['changed', 'largest', 'level', 'mean']);
});

test('The page shows the worst tiles and refers to nothing outside', async () => {
  const file = join(work, 'page.html');
  assert.equal((await diff('a', 'b', '--html', file)).code, 1);
  const page = await readFile(file, 'utf8');
  const pictures = [...page.matchAll(/<img [^>]*src="([^"]*)"/g)].map(([, source]) => source);
  assert.equal(pictures.length, 6, 'three tiles, before and after');
  for (const source of pictures) {
    assert.match(source, /^data:image\/png;base64,/);
    const bytes = Buffer.from(source.slice(source.indexOf(',') + 1), 'base64');
    assert.equal(bytes.subarray(1, 4).toString(), 'PNG');
  }
  const rest = page.replaceAll(/src="data:[^"]*"/g, '');
  assert.doesNotMatch(rest, /<script|<link|src=|href=|url\(|@import|https?:/i);
  assert.match(rest, /<td>0\/1\/1<\/td>/);
});

test('A folder without a bake cannot be compared', async () => {
  await refused('nowhere', /nowhere: is no folder/);
  await refused('dem.tif', /dem\.tif: is no folder/);
  await refused('.', /holds no bake/);
});

test('A bake that is not finished cannot be compared', async () => {
  const part = await hoodoo(['bake', join(work, 'a.json'), '-o', join(work, 'part'), '--only', '0/0/0']);
  assert.equal(part.code, 0, part.stderr);
  await refused('part', /part: holds a bake that is not finished/);
});

test('A bake with a missing tile cannot be compared', async () => {
  let name;
  await changed('missing', async (folder, bake_) => {
    name = bake_.tiles.find((tile) => tile.key === '0/0/0').uri;
    await rm(join(folder, name));
  });
  await refused('missing', /missing\/tiles.*: tile 0\/0\/0 is missing/);
});

test('A bake with a damaged tile cannot be compared', async () => {
  await changed('damaged', async (folder, bake_) => {
    const file = await open(join(folder, bake_.tiles.find((tile) => tile.key === '0/1/1').uri), 'r+');
    await file.write('damage', 1000);
    await file.close();
  });
  await refused('damaged', /damaged\/tiles.*: its content is not what its name says/);
});

test('A bake with a damaged index cannot be compared', async () => {
  await changed('index', (folder) => writeFile(join(folder, 'bake.json'), '{"hoodoo": 1, "complete": true'));
  await refused('index', /index\/bake\.json/);
});

test('Bakes in other frames cannot be compared', async () => {
  await changed('frame', (folder, bake_) => {
    bake_.frame.crs = 'EPSG:32633';
    return writeFile(join(folder, 'bake.json'), JSON.stringify(bake_));
  });
  await refused('frame', /another frame.*EPSG:32633/);
});

test('Errors as JSON have the exit code', async () => {
  const result = await diff('a', 'nowhere', '--json');
  assert.equal(result.code, 2);
  assert.equal(JSON.parse(result.stderr).exit, 2);
});

test('A tolerance that is no distance is refused', async () => {
  for (const tolerance of ['-1', 'nan', 'far']) {
    assert.equal((await diff('a', 'same', `--tolerance=${tolerance}`)).code, 2, tolerance);
  }
});

/** Wrong scenes through the command: each is refused at once, with the fault's exit code and where it lies. */
import assert from 'node:assert/strict';
import { open, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';

// A sanitizer has its own pace.
const most = process.env.HOODOO_SANITIZED ? 30 : 1;   // seconds
let folder;

before(async () => {
  folder = await makeFolder();
  // 100 km, so that a fine grid over it is out of reach.
  const made = await hoodoo(['synthesize', join(folder, 'dem.tif'), '--pixels', '500', '--spacing', '200']);
  assert.equal(made.code, 0, made.stderr);
});
after(() => removeFolder(folder));

const scene = (more) => ({ hoodoo: 1, terrains: [{ id: 'land', dem: 'dem.tif' }], ...more });
const sphere = (more) => ({ type: 'sphere', center: [0, 0, 0], radius: 3, falloff: 2, ...more });
const operations = (...trees) => scene({ operations: trees.map((tree) => ({ op: 'union', tree })) });

/** Writes `content` as a scene and gives it to the subcommand. */
async function refused(subcommand, content) {
  const file = join(folder, 'scene.json');
  if (typeof content === 'function') await content(file);
  else await writeFile(file, typeof content === 'string' ? content : JSON.stringify(content));
  const output = subcommand === 'bake' ? ['-o', join(folder, 'out')] : [];
  const result = await hoodoo([subcommand, file, ...output], { limit: 30_000 });
  assert.equal(result.signal, null, `ended by ${result.signal}`);
  return result;
}

/** name: [scene, exit code of bake, what the message says]. */
const wrong = {
  'An unknown key': [scene({ bogus: 1 }), 2, /\/bogus: /],
  'An unknown key deep in a tree': [operations(sphere({ radios: 3 })), 2, /\/operations\/0\/tree\/radios: /],
  'A radius out of its range, with its unit': [operations(sphere({ radius: -1 })), 2,
                                               /\/operations\/0\/tree\/radius: .*\bm\b.*-1/],
  'A falloff in words': [operations(sphere({ falloff: '2 m' })), 2, /\/operations\/0\/tree\/falloff: /],
  'An unknown type': [operations({ type: 'pyramid' }), 2, /\/operations\/0\/tree\/type: .*pyramid/],
  'A missing required value': [operations({ type: 'sphere', center: [0, 0, 0] }), 2, /\/operations\/0\/tree(\/radius)?: .*radius|\/operations\/0\/tree\/radius: /],
  'A file that is not there': [{ hoodoo: 1, terrains: [{ dem: 'nowhere.tif' }] }, 4, /\/terrains\/0\/dem: .*nowhere\.tif/],
  'A file that is no DEM': [{ hoodoo: 1, terrains: [{ dem: 'scene.json' }] }, 2, /\/terrains\/0\/dem: .*|scene\.json/],
  'A cycle of use': [scene({ define: { a: { use: 'b' }, b: { type: 'translate', by: [1, 0, 0], child: { use: 'a' } } },
                             operations: [{ op: 'union', tree: { use: 'a' } }] }), 2, /\/define\/[ab].*: .*cycle|\/define\/[ab].*(itself|circle)/],
  'A use of nothing': [operations({ use: 'boulder' }), 2, /\/operations\/0\/tree(\/use)?: .*boulder/],
  'Another version of the format': [{ ...scene(), hoodoo: 2 }, 2, /\/hoodoo: /],
  'JSON cut short': ['{"hoodoo": 1, "terrains": [', 2, /scene\.json.*line|line/],
  'A key twice': ['{"hoodoo": 1, "hoodoo": 1, "terrains": [{"dem": "dem.tif"}]}', 2, /hoodoo/],
  'No JSON at all': ['\u0000\u0001', 2, /scene\.json/],
  'A million nested arrays': ['['.repeat(1_000_000) + ']'.repeat(1_000_000), 3, /scene\.json.*(deep|nest)/],
  'A million nested trees': ['{"hoodoo":1,"geology":' + '{"type":"blend","children":['.repeat(100_000), 3, /scene\.json.*(deep|nest)/],
  'A string of 2 GB': [(file) => longString(file, 2 ** 31), 3, /scene\.json.*(bytes|MiB|long|large)/],
  'A string of 63 MB': [(file) => longString(file, 63e6), 2, /\/terrains: /],
  'A grid of 1 mm over 100 km': [scene({ bake: { spacing: 0.001 } }), 3, /\/bake\/spacing: .*100000 x 100000 m/],
};

/** A scene whose name has `size` letters; beyond a gigabyte most of it is a hole in the file. */
async function longString(file, size) {
  const handle = await open(file, 'w');
  await handle.write('{"hoodoo": 1, "name": "');
  if (size < 1e9) await handle.write(`${'a'.repeat(size)}"}`);
  else await handle.write('"}', size);
  await handle.close();
}

for (const [what, [content, code, message]] of Object.entries(wrong)) {
  test(`${what} is refused with exit ${code}, in under ${most} s`, async () => {
    const result = await refused('bake', content);
    assert.equal(result.code, code, result.stderr.slice(0, 500));
    assert.match(result.stderr, /^hoodoo: /);
    assert.match(result.stderr.slice(0, 5000), message);
    assert.ok(result.busy < most, `took ${result.busy} s`);
    assert.ok(result.stderr.length < 10_000, 'the message is readable');
  });
}

test('hoodoo check lists every problem of a scene at once', async () => {
  const result = await refused('check', {
    ...operations(sphere({ radius: -1 }), sphere({ falloff: 0, radios: 1 })), bogus: 1, terrains: [{ dem: 'nowhere.tif' }],
  });
  assert.equal(result.code, 2);
  for (const pointer of ['/bogus', '/terrains/0/dem', '/operations/0/tree/radius', '/operations/1/tree/radios', '/operations/1/tree/falloff']) {
    assert.ok(result.stdout.includes(`${pointer}: `), `${pointer} is not in\n${result.stdout}`);
  }
});

test('Errors as JSON have the exit code and each problem with its place', async () => {
  const file = join(folder, 'scene.json');
  await writeFile(file, JSON.stringify(scene({ bogus: 1 })));
  const result = await hoodoo(['--json', 'bake', file, '-o', join(folder, 'out')]);
  const error = JSON.parse(result.stderr);
  assert.equal(error.exit, 2);
  assert.equal(error.problems[0].where, '/bogus');
});

test('A scene that is not there is exit 4, naming it', async () => {
  const result = await hoodoo(['bake', join(folder, 'none.json'), '-o', join(folder, 'out')]);
  assert.equal(result.code, 4, result.stderr);
  assert.match(result.stderr, /none\.json/);
});

test('A scene that never ends is refused', async () => {
  const result = await hoodoo(['check', '/dev/zero'], { limit: 20_000 });
  assert.equal(result.signal, null);
  assert.ok([2, 3, 4].includes(result.code), result.stderr);
  assert.ok(result.busy < most, `took ${result.busy} s`);
});

test('An output folder that cannot be made is exit 4', async () => {
  const file = join(folder, 'scene.json');
  await writeFile(file, JSON.stringify(scene()));
  const result = await hoodoo(['bake', file, '-o', join(file, 'below-a-file')], { limit: 30_000 });
  assert.equal(result.code, 4, result.stderr);
});

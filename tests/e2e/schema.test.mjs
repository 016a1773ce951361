/** The JSON Schema in the hands of another's validator (ajv): it takes what hoodoo takes, and points where hoodoo does. */
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { writeFile } from 'node:fs/promises';
import { join, resolve } from 'node:path';
import { after, before, test } from 'node:test';
import Ajv2020 from 'ajv/dist/2020.js';
import { examples, hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';

const schemas = resolve(import.meta.dirname, '../../schema');
const read = (file) => JSON.parse(readFileSync(file, 'utf8'));
// Not strict about tuples, since a ball may leave its energy out, nor about required keys, since alternatives demand
// some that stand elsewhere. A field may be a number or null.
const ajv = new Ajv2020({ strict: true, strictTuples: false, strictRequired: false, allowUnionTypes: true, allErrors: true });
ajv.addKeyword('x-unit');
const validate = ajv.compile(read(join(schemas, 'scene.schema.json')));

const token = (key) => `/${key.replaceAll('~', '~0').replaceAll('/', '~1')}`;

/**
 * JSON Pointers of what is wrong, each once. An unknown or missing key is reported at its object, and hoodoo points
 * at the key. Where none of several alternatives holds, their own errors say nothing more.
 */
function places(errors) {
  const unions = errors.filter(({ keyword }) => keyword === 'anyOf' || keyword === 'oneOf');
  const isAlternative = ({ schemaPath }) => unions.some((union) => schemaPath.startsWith(`${union.schemaPath}/`));
  const place = ({ instancePath, params }) =>
    instancePath + ['additionalProperty', 'missingProperty'].map((key) => (params[key] === undefined ? '' : token(params[key]))).join('');
  return [...new Set(errors.filter((error) => error.keyword !== 'if' && !isAlternative(error)).map(place))].sort();
}
const wrong = (scene) => (validate(scene) ? [] : places(validate.errors));

/** A scene with a bit of everything. */
const whole = () => ({
  hoodoo: 1, name: 'whole', seed: 4,
  materials: [{ name: 'shale', color: '#8d8377', resistance: [0, 0.4], friction: 0.6 }, { name: 'limestone', resistance: [0.4, 1] }],
  terrains: [{ id: 'land', dem: 'dem.tif', falloff: 9, nodata: 'hole', domain: [[0, 0], [90, 0], [90, 90]] }, { dem: 'dem.tif', nodata: 3.5 }],
  define: {
    layers: { type: 'strata', wavelength: 12, octaves: 3 },
    bent: { type: 'translate', by: [1, 2, 3], child: { type: 'fold', amplitude: 3, child: { use: 'layers' } } },
    unused: { type: 'rotate', angle: 30, child: { type: 'torus', center: [0, 0, 0], radius: 5, tube: 1 } },
  },
  geology: { type: 'blend', children: [
    { type: 'fault', by: [0, 0, 4], child: { use: 'bent' }, domain: { type: 'half_space', point: [0, 0, 0] } },
    { type: 'plane', point: [0, 0, 40], normal: [0, 0, 1], energy: -0.5 }] },
  operations: [
    { id: 'cave', op: 'difference', region: { type: 'box', min: [0, 0, -20], max: [90, 90, 90] },
      tree: { type: 'sphere', center: { uv: [0.5, 0.5], ground: -4 }, radius: 9, turbulence: { amplitude: 1 } } },
    { op: 'union', tree: { type: 'warp', amplitude: 2, child: { type: 'smooth_union', width: 0.5, children: [
      { type: 'catmull_rom', points: [[0, 0, 0], { xy: [9, 9], ground: 2 }, [20, 9, 3]], radius: 2, closed: true },
      { type: 'points', balls: [[0, 0, 0, 2], [3, 0, 0, 2, -1]] }] } } },
    { op: 'blend', tree: { type: 'erosion', amount: 0.3, resistance: { use: 'layers' },
                           control: { type: 'expression', formula: 'smoothstep(low, 9, z)', parameters: { low: 3 } } } },
    { op: 'intersect', region: { type: 'altitude', range: [-90, 400] }, tree: { type: 'from_distance', child: {
      type: 'offset', by: 2, child: { type: 'prism', outline: [[0, 0], [90, 0], [90, 90]], bottom: -90, top: 300 } } } },
    { op: 'union', tree: { type: 'repeat', join: 'blend', placements: [{ at: [5, 5, 5], angle: 20 }], child: {
      type: 'ellipsoid', center: [0, 0, 0], radii: [6, 7, 8] } } },
    { type: 'arch', op: 'blend', from: [1, 1, 1], to: [30, 1, 1], height: 9, thickness: 4,
      region: { type: 'polygon', points: [[0, 0], [90, 0], [90, 90]], feather: 2 } },
  ],
  bake: { spacing: 2, extent: { min: [0, 0], max: [90, 90] }, tile_cells: 64, profile: 'plain', levels: 2, tile_triangles: 5000,
          keep_thin: true, base: { closed: 20 } },
});

/** Puts `value` at `pointer`, or takes away what is there. */
function changed(pointer, value) {
  const scene = whole(), keys = pointer.split('/').slice(1), last = keys.pop();
  const object = keys.reduce((at, key) => at[key], scene);
  if (value === undefined) delete object[last];
  else object[last] = value;
  return scene;
}

const gone = undefined;
/** What is changed, to what, and where that is wrong if not there. */
const broken = [
  // Keys that nothing knows.
  ['/bogus', 1], ['/materials/0/colour', '#000000'], ['/terrains/0/path', 'dem.tif'], ['/operations/0/trees', {}],
  ['/operations/0/tree/radios', 3], ['/operations/0/tree/turbulence/amplitud', 3], ['/operations/0/tree/center/z', 3],
  ['/operations/1/tree/child/children/1/ball', []], ['/operations/4/tree/placements/0/turn', 3], ['/operations/5/width', 3],
  ['/operations/0/region/margin', 1], ['/bake/threads', 4], ['/bake/extent/z', [0, 1]], ['/bake/base/open', 1], ['/define/bent/child/fold', 1],
  ['/geology/children/0/domain/a~b', 1, '/geology/children/0/domain/a~0b'],
  // Wrong types.
  ['/name', 7], ['/seed', 'four'], ['/seed', 1.5], ['/materials', {}], ['/materials/0', 'shale'], ['/terrains/0/inverted', 'no'],
  ['/terrains/0/falloff', '9 m'], ['/terrains/1/nodata', 'fill'], ['/define/layers', 'strata'], ['/geology', []],
  ['/geology/children', {}], ['/geology/children/1', null], ['/operations', {}], ['/operations/0', 7], ['/operations/0/tree', 'sphere'],
  ['/operations/0/tree/radius', '9'], ['/operations/0/tree/turbulence', 2], ['/operations/0/tree/center', 'here'],
  ['/operations/2/tree/control/formula', 1], ['/operations/2/tree/control/parameters/low', 'x'], ['/operations/2/tree/resistance/use', 3],
  ['/operations/1/tree/child/children/0/closed', 1], ['/operations/0/region', 'everywhere'], ['/bake', 3], ['/bake/extent', [0, 0, 90, 90]], ['/bake/base', 20],
  ['/bake/base/closed', 'deep'], ['/operations/1/tree/child/children/1/file', 3],
  // Out of range.
  ['/hoodoo', 2], ['/seed', -1], ['/materials/0/friction', -1], ['/materials/0/resistance/1', 1.2], ['/terrains/0/falloff', 0],
  ['/define/layers/wavelength', 0], ['/define/layers/octaves', 13], ['/define/bent/child/amplitude', -1],
  ['/define/unused/child/tube', -1], ['/define/unused/angle', 400], ['/geology/children/1/energy', 2000], ['/operations/0/tree/radius', 0],
  ['/operations/0/tree/center/uv/0', 1.5], ['/operations/0/tree/turbulence/octaves', 0], ['/operations/1/tree/child/width', 0],
  ['/operations/1/tree/child/children/1/balls/1/3', 0], ['/operations/2/tree/amount', -1], ['/operations/3/tree/child/by', 1e6],
  ['/operations/4/tree/child/radii/2', 0], ['/operations/4/tree/placements/0/scale', 0], ['/operations/5/thickness', 0],
  ['/operations/5/region/feather', -1], ['/bake/spacing', 0], ['/bake/levels', 33], ['/bake/tile_cells', 8], ['/bake/base/closed', 0],
  ['/bake/tile_triangles', 999], ['/bake/tile_triangles', 16777217], ['/bake/tile_triangles', 1e4 + 0.5], ['/bake/keep_thin', 1],
  // Keys that must be there.
  ['/hoodoo', gone], ['/terrains', gone], ['/terrains/0/dem', gone], ['/materials/0/name', gone], ['/define/layers/wavelength', gone],
  ['/operations/0/tree/radius', gone], ['/operations/0/tree/center/ground', gone], ['/operations/0/op', gone], ['/operations/0/tree', gone],
  ['/operations/1/tree/child/children', gone],
  ['/operations/2/tree/resistance', gone], ['/operations/4/tree/placements/0/at', gone], ['/operations/5/to', gone],
  ['/operations/0/region/max', gone], ['/operations/0/region/type', gone], ['/bake/extent/min', gone], ['/bake/base/closed', gone],
  ['/define/layers/type', gone, '/define/layers'], ['/operations/0/tree/type', gone, '/operations/0/tree'],
  ['/operations/0/tree/center/uv', gone, '/operations/0/tree/center'],
  // No such name.
  ['/operations/0/op', 'subtract'], ['/operations/0/tree/type', 'pyramid'], ['/operations/5/type', 'bridge'], ['/operations/5/op', 'intersect'],
  ['/operations/0/region/type', 'ball'], ['/operations/4/tree/join', 'sum'], ['/bake/profile', 'fbx'], ['/bake/frame', 'moon'], ['/define/layers/type', 'layers'],
  ['/operations/0/tree/type', 7], ['/materials/0/color', 'grey'], ['/terrains/0/nodata', 'none'],
  // Types in a tree of another family.
  ['/operations/1/tree/child/children/1', { type: 'strata', wavelength: 3 }, '/operations/1/tree/child/children/1/type'],
  ['/geology/children/1', { type: 'union', children: [] }, '/geology/children/1/type'],
  ['/operations/3/tree/child/child', { type: 'point', center: [0, 0, 0], radius: 3 }, '/operations/3/tree/child/child/type'],
  // Lists of the wrong length.
  ['/materials', []], ['/terrains', []], ['/materials/0/resistance', [0]], ['/terrains/0/domain', [[0, 0], [1, 1]]],
  ['/terrains/0/domain/1', [1, 2, 3]], ['/define/bent/by', [1, 2]], ['/operations/0/tree/center', [1, 2]],
  ['/operations/0/tree/center/uv', [0.5]], ['/operations/1/tree/child/children', []], ['/operations/1/tree/child/children/0/points', [[0, 0, 0]]],
  ['/operations/1/tree/child/children/1/balls/0', [1, 2, 3]], ['/operations/1/tree/child/children/1/balls', []],
  ['/operations/4/tree/placements', []], ['/operations/0/region/min', [0, 0]], ['/operations/3/region/range', [1]], ['/bake/extent/max', [90]],
  ['/operations/5/region/points/0', [1]],
];

let folder;
before(async () => {
  folder = await makeFolder();
  const made = await hoodoo(['synthesize', join(folder, 'dem.tif'), '--pixels', '64', '--spacing', '4']);
  assert.equal(made.code, 0, made.stderr);
});
after(() => removeFolder(folder));

/** Where hoodoo finds the scene wrong. */
async function checked(scene) {
  const file = join(folder, 'scene.json');
  await writeFile(file, JSON.stringify(scene));
  const result = await hoodoo(['--json', 'check', file]);
  const { problems } = JSON.parse(result.stdout);
  assert.equal(result.code, problems.length > 0 ? 2 : 0, result.stderr);
  return [...new Set(problems.map(({ where }) => where))].sort();
}

test('Every example is a scene', () => {
  const folders = examples();
  assert.ok(folders.length > 1);
  for (const one of folders) assert.deepEqual(wrong(read(join(one, 'scene.json'))), [], one);
});

for (const name of readdirSync(join(schemas, 'nodes')).filter((file) => file.endsWith('.json'))) {
  test(`The tree of nodes/${name} has a place in a scene`, () => {
    const tree = read(join(schemas, 'nodes', name));
    const scene = { hoodoo: 1, terrains: [{ dem: 'dem.tif' }] };
    const places_ = { operations: { ...scene, operations: [{ op: 'union', tree }] }, geology: { ...scene, geology: tree } };
    const taken = Object.keys(places_).filter((key) => wrong(places_[key]).length === 0);
    assert.notDeepEqual(taken, [], JSON.stringify(validate.errors));
  });
}

test('A scene with a bit of everything is right in the eyes of both', async () => {
  assert.deepEqual(wrong(whole()), []);
  assert.deepEqual(await checked(whole()), []);
});

for (const [pointer, value, where = pointer] of broken) {
  test(`${pointer} ${value === gone ? 'left out' : `as ${JSON.stringify(value)}`} is wrong at ${where}, says either`, async () => {
    const scene = changed(pointer, value);
    assert.deepEqual(wrong(scene), [where], 'ajv');
    assert.deepEqual(await checked(scene), [where], 'hoodoo check');
  });
}

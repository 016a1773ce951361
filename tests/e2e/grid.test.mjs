/** Voxels of an OpenVDB file in a scene, through the command: as a body, as a hollow and as resistance. */
import assert from 'node:assert/strict';
import { readFile, rename, truncate, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { command, digests, hoodoo, makeFolder, removeFolder, run } from './hoodoo.mjs';

const writer = process.env.HOODOO_WRITE_VDB ?? join(dirname(command), 'tests/engine/scene/hoodoo_write_vdb');
const ball = { x: 120, y: 130, z: 300, radius: 30, voxel: 2 };   // above the ground
let folder;
const inFolder = (name) => join(folder, name);

/** The level set of a ball by OpenVDB. */
async function writeBall(name, { x, y, z, radius, voxel }) {
  const made = await run(writer, [inFolder(name), radius, voxel, x, y, z].map(String));
  assert.equal(made.code, 0, made.stderr);
}

/** A distance, negative inside, as a field that is 1/2 at the surface. */
const body = (more) => ({ type: 'grid', file: 'ball.vdb', low: 4, high: -4, ...more });
const scene = (more) => ({
  hoodoo: 1, terrains: [{ dem: 'dem.tif' }],
  materials: [{ name: 'soft', color: '#998877', resistance: [0, 0.5] },
              { name: 'hard', color: '#556677', resistance: [0.5, 1] }],
  operations: [{ op: 'union', tree: body() }], ...more,
});

async function command_(subcommand, content, args = []) {
  await writeFile(inFolder('scene.json'), JSON.stringify(content));
  return hoodoo([subcommand, inFolder('scene.json'), ...args]);
}

async function probe(content, points) {
  await writeFile(inFolder('points.csv'), points.map((p) => p.join(',')).join('\n'));
  const result = await command_('probe', content, ['--points', inFolder('points.csv')]);
  assert.equal(result.code, 0, result.stderr);
  const [head, ...lines] = result.stdout.trim().split('\n').map((line) => line.split(','));
  return lines.map((line) => Object.fromEntries(head.map((key, i) => [key, isNaN(line[i]) ? line[i] : Number(line[i])])));
}

async function bake(content, name) {
  const result = await command_('bake', content, ['-o', inFolder(name)]);
  assert.equal(result.code, 0, result.stderr);
  const manifest = JSON.parse(await readFile(inFolder(`${name}/bake.json`), 'utf8'));
  return { files: await digests(inFolder(name)), manifest };
}

before(async () => {
  folder = await makeFolder();
  const made = await hoodoo(['synthesize', inFolder('dem.tif'), '--pixels', '64', '--spacing', '4']);
  assert.equal(made.code, 0, made.stderr);
  await writeBall('ball.vdb', ball);
});
after(() => removeFolder(folder));

test('A level set is a body with its surface where the distance is 0, and its normal there', async () => {
  const { x, y, z, radius } = ball;
  const [top, side, inside, outside] = await probe(scene(), [
    [x, y, z + radius], [x + radius * 0.6, y, z + radius * 0.8], [x, y, z], [x + radius + 8, y, z]]);
  assert.ok(Math.abs(top.field - 0.5) < 0.01, `${top.field}`);
  assert.ok(Math.abs(top.gz + 1 / 8) < 0.01 && Math.abs(top.gx) < 0.01, `${top.gx} ${top.gz}`);
  assert.ok(Math.abs(side.field - 0.5) < 0.02, `${side.field}`);
  assert.ok(Math.abs(side.gx + 0.6 / 8) < 0.02 && Math.abs(side.gz + 0.8 / 8) < 0.02, `${side.gx} ${side.gz}`);
  assert.equal(inside.field, 1);
  assert.equal(outside.field, 0);
});

test('A grid is the resistance, and chooses the material', async () => {
  const { x, y, z } = ball;
  const geology = body({ background: 4 });
  const [inside, outside] = await probe(scene({ geology }), [[x, y, z], [x, y, z - 100]]);
  assert.equal(inside.resistance, 1);
  assert.equal(inside.material, 'hard');
  assert.equal(outside.resistance, 0);
  assert.equal(outside.material, 'soft');
});

test('A bake depends on what a grid holds, not on its name', async () => {
  const first = await bake(scene(), 'first');
  await rename(inFolder('ball.vdb'), inFolder('renamed.vdb'));
  const renamed = await bake(scene({ operations: [{ op: 'union', tree: body({ file: 'renamed.vdb', grid: 'ball' }) }] }), 'second');
  assert.deepEqual(renamed.files, first.files);
  const verified = await hoodoo(['verify', inFolder('first')]);
  assert.equal(verified.code, 0, verified.stdout + verified.stderr);
  await writeBall('ball.vdb', { ...ball, radius: 32 });
  const larger = await bake(scene(), 'first');
  assert.notDeepEqual(larger.files, first.files);
});

test('What is wrong with a grid is told with its place and the right exit code', async () => {
  await writeBall('broken.vdb', ball);
  await truncate(inFolder('broken.vdb'), 5000);
  const wrong = [
    [{ file: 'nowhere.vdb' }, 4, /\/operations\/0\/tree\/file: no file "nowhere\.vdb"/],
    [{ file: 'dem.tif' }, 2, /\/operations\/0\/tree\/file: "dem\.tif" is no OpenVDB file/],
    [{ file: 'broken.vdb' }, 2, /\/operations\/0\/tree\/file: "broken\.vdb" is damaged or cut short/],
    [{ grid: 'rock' }, 2, /\/operations\/0\/tree\/grid: "ball\.vdb" has no grid "rock", but "ball" \(float\)/],
  ];
  for (const [more, code, message] of wrong) {
    const result = await command_('bake', scene({ operations: [{ op: 'union', tree: body(more) }] }), ['-o', inFolder('none')]);
    assert.equal(result.code, code, result.stderr);
    assert.match(result.stderr, message);
  }
});

test('hoodoo draw finds the file beside the tree', async () => {
  await writeFile(inFolder('tree.json'), JSON.stringify(body()));
  const drawn = await hoodoo(['draw', inFolder('tree.json'), '-o', inFolder('tree.png')], { cwd: '/' });
  assert.equal(drawn.code, 0, drawn.stderr);
  assert.equal((await readFile(inFolder('tree.png'))).subarray(1, 4).toString(), 'PNG');
});

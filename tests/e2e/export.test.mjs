/** hoodoo export: a bake with a ball in the air, read back by loaders of others; and its archive, streamed. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { mkdir, readFile, readdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Uint8ArrayReader, Uint8ArrayWriter, ZipReader } from '@zip.js/zip.js';
import validator from 'gltf-validator';
import { OBJLoader } from 'three/examples/jsm/loaders/OBJLoader.js';
import { PLYLoader } from 'three/examples/jsm/loaders/PLYLoader.js';
import { digests, hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

let work, bake;
const at = (name) => join(work, name);

before(async () => {
  work = await makeFolder();
  const made = await hoodoo(['synthesize', at('dem.tif'), '--pixels', '96', '--spacing', '2']);
  assert.equal(made.code, 0, made.stderr);
  await writeFile(at('scene.json'), JSON.stringify({
    hoodoo: 1,
    materials: [{ name: 'wet shale', color: '#8d8377', resistance: [0, 0.5], friction: 0.6 },
                { name: 'limestone', color: '#cfc6b0', resistance: [0.5, 1], friction: 0.8 }],
    geology: { type: 'strata', wavelength: 12, octaves: 3 },
    terrains: [{ id: 'land', dem: 'dem.tif', falloff: 8 }],
    operations: [{ id: 'ball', op: 'union', tree: { type: 'sphere', center: [95, 96, 200], radius: 14, falloff: 8 } },
                 { id: 'hollow', op: 'difference', tree: { type: 'sphere', center: [95, 96, 200], radius: 7, falloff: 8 } }],
    bake: { spacing: 1, tile_cells: 64 },
  }));
  const baked = await hoodoo(['bake', at('scene.json'), '-o', at('bake')]);
  assert.equal(baked.code, 0, baked.stderr);
  bake = JSON.parse(await readFile(at('bake/bake.json'), 'utf8'));
});
after(() => removeFolder(work));

const export_ = (file, ...args) => hoodoo(['export', at('bake'), '-o', at(file), ...args]);

/** Exports, and gives what the command says as JSON. */
async function exported(file, ...args) {
  const result = await export_(file, '--json', ...args);
  assert.equal(result.code, 0, result.stderr);
  return JSON.parse(result.stdout);
}

const sum = (member, level = 0) => bake.tiles.filter(({ key }) => key.startsWith(`${level}/`))
  .reduce((total, tile) => total + (tile[member] ?? 0), 0);

/** Edges with one face of triangles [[a, b, c], ...] between points, joined where they are equal. */
function openEdges(positions, triangles) {
  const names = new Map();
  const name = (i) => {
    const key = positions.slice(3 * i, 3 * i + 3).join();
    if (!names.has(key)) names.set(key, names.size);
    return names.get(key);
  };
  const sides = new Map();
  for (const corners of triangles) {
    const [a, b, c] = corners.map(name);
    for (const [from, to] of [[a, b], [b, c], [c, a]]) {
      const edge = from < to ? `${from} ${to}` : `${to} ${from}`;
      sides.set(edge, (sides.get(edge) ?? 0) + 1);
    }
  }
  const counts = [...sides.values()];
  assert.ok(counts.every((count) => count <= 2));
  return counts.filter((count) => count === 1).length;
}

const triples = (indices) => Array.from({ length: indices.length / 3 }, (_, i) => [...indices.slice(3 * i, 3 * i + 3)]);

test('An OBJ is one welded mesh in groups by material', async () => {
  const said = await exported('a.obj');
  const text = await readFile(at('a.obj'), 'utf8');
  const lines = text.split('\n');
  const positions = lines.filter((line) => line.startsWith('v ')).flatMap((line) => line.split(' ').slice(1).map(Number));
  const faces = lines.filter((line) => line.startsWith('f ')).map((line) => line.split(' ').slice(1).map((corner) => parseInt(corner, 10) - 1));
  assert.equal(positions.length / 3, said.vertices);
  assert.equal(faces.length, sum('triangles'));
  assert.equal(openEdges(positions, faces), sum('world_edges'));
  const loaded = new OBJLoader().parse(text);
  const names = new Set(loaded.children.flatMap((child) => [child.material].flat().map((material) => material.name)));
  assert.deepEqual([...names].sort(), ['limestone', 'wet_shale']);
  assert.match(await readFile(at('a.mtl'), 'utf8'), /^newmtl wet_shale$/m);
});

test('A PLY is the same mesh with colours', async () => {
  const said = await exported('a.ply');
  const bytes = await readFile(at('a.ply'));
  const mesh = new PLYLoader().parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  assert.equal(mesh.attributes.position.count, said.vertices);
  assert.equal(mesh.attributes.color.count, said.vertices);
  const triangles = triples(mesh.index.array);
  assert.equal(triangles.length, sum('triangles'));
  assert.equal(openEdges(mesh.attributes.position.array, triangles), sum('world_edges'));
  for (const level of [1, 2]) {
    assert.equal((await exported('level.ply', '--level', level)).triangles, sum('triangles', level));
  }
});

test('A glTF is valid, with a vertex per position and material', async () => {
  for (const name of ['a.glb', 'a.gltf']) {
    const said = await exported(name);
    const report = await validator.validateBytes(await readFile(at(name)), {
      externalResourceFunction: async (uri) => new Uint8Array(await readFile(at(uri))), writeTimestamp: false,
    });
    assert.equal(report.issues.numErrors + report.issues.numWarnings, 0, JSON.stringify(report.issues.messages));
    assert.equal(report.info.totalTriangleCount, sum('triangles'));
    assert.equal(report.info.totalVertexCount, said.vertices);
    assert.equal(report.info.drawCallCount, 1);
  }
});

test('A level set has a narrow band, and is read as voxels of another scene', async () => {
  assert.ok((await exported('rock.vdb', '--region', '64,64,128,128')).voxels > 64 * 64 * 6);
  await writeFile(at('again.json'), JSON.stringify({
    hoodoo: 1,
    terrains: [{ id: 'land', dem: 'dem.tif', falloff: 8 }],
    operations: [{ id: 'copy', op: 'union', tree: { type: 'grid', file: 'rock.vdb', low: 2, high: -2 } }],
  }));
  const places = { hollow: 200, shell: 210, 'below it': 189, 'over it': 219, 'under it': 180 };
  await writeFile(at('points.csv'), 'x,y,z\n' + Object.values(places).map((z) => `95,96,${z}\n`).join(''));
  const probed = await hoodoo(['probe', at('again.json'), '--points', at('points.csv')]);
  assert.equal(probed.code, 0, probed.stderr);
  const fields = probed.stdout.trim().split('\n').slice(1).map((line) => Number(line.split(',')[3]));
  assert.deepEqual(fields.map((field) => field > 0.5), [false, true, true, false, false], `${Object.keys(places)}: ${fields}`);
});

test('A height map is a DEM: the ball is seen from above', async () => {
  const said = await exported('a.tif');
  assert.deepEqual([said.width, said.height], [192, 192]);
  const info = await hoodoo(['info', at('a.tif'), '--json']);
  assert.equal(info.code, 0, info.stderr);
  const place = JSON.parse(await readFile(at('a.tif.json'), 'utf8'));
  const { crs, nodata, transform } = JSON.parse(info.stdout);
  assert.equal(crs, bake.frame.crs);
  assert.equal(nodata, 0);
  const [x, y] = bake.frame.origin;
  assert.deepEqual(transform, [x, 1, 0, y + 192, 0, -1]);
  assert.ok(place.highest >= 213 && place.highest < 215, `${place.highest} m`);
  const other = await exported('b.png', '--pixel', '4', '--region', '0,0,100,50');
  assert.deepEqual([other.width, other.height], [25, 13]);
});

test('The same export has the same bytes', async () => {
  const folders = ['once', 'twice'];
  for (const folder of folders) {
    await mkdir(at(folder));
    for (const name of ['a.obj', 'a.ply', 'a.gltf', 'a.vdb', 'a.png', 'a.tif', 'a.3tz']) await exported(join(folder, name));
  }
  const [once, twice] = await Promise.all(folders.map((folder) => digests(at(folder))));
  assert.deepEqual(once, twice);
  assert.equal(Object.keys(once).length, 11, 'and nothing beside them');
});

/** 3D Tiles Archive Format 1.3: what the index says of a name, by a search of one's own. */
function inIndex(index, name) {
  const digest = createHash('md5').update(name).digest();
  for (let i = 0; i < index.length; i += 24) {
    if (index.subarray(i, i + 16).equals(digest)) return Number(index.readBigUInt64LE(i + 16));
  }
  return -1;
}

test('A .3tz is a ZIP of every file, and its index leads to each', async () => {
  const said = await exported('a.3tz');
  const bytes = await readFile(at('a.3tz'));
  const zip = new ZipReader(new Uint8ArrayReader(new Uint8Array(bytes)), { checkSignature: true });
  const entries = await zip.getEntries();
  assert.equal(entries.at(-1).filename, '@3dtilesIndex1@');
  assert.equal(entries.length, said.packed + 1);
  const index = Buffer.from(await entries.at(-1).getData(new Uint8ArrayWriter()));
  assert.equal(index.length, 24 * said.packed);
  const halves = triples([...Array(said.packed * 3).keys()]).map(([i]) => index.readBigUInt64LE(8 * i));
  assert.deepEqual(halves, halves.toSorted((a, b) => (a < b ? -1 : 1)));
  const expected = await digests(at('bake'));
  for (const entry of entries.slice(0, -1)) {
    const data = Buffer.from(await entry.getData(new Uint8ArrayWriter()));
    assert.equal(createHash('sha256').update(data).digest('hex'), expected[entry.filename], entry.filename);
    assert.equal(entry.compressionMethod, 0);
    const offset = inIndex(index, entry.filename);
    assert.equal(offset, entry.offset);
    assert.equal(bytes.readUInt32LE(offset + 14), entry.signature, 'the CRC stands in the local header');
  }
  const kept = Object.keys(expected).filter((name) => !name.startsWith('.hoodoo'));
  assert.equal(kept.length, said.packed);
});

test('A job is streamed as the archive that its folder would be exported to', async () => {
  const server = await Server.start({ data: at('archived'), roots: [work] });
  try {
    const id = await server.submit(JSON.parse(await readFile(at('scene.json'), 'utf8')));
    const early = await server.fetch(`/jobs/${id}/files/tileset.3tz`);
    assert.equal((await server.follow(id)).at(-1).status, 'successful');
    assert.ok(early.status === 404 || early.status === 200, 'it may be done already');
    const response = await server.fetch(`/jobs/${id}/files/tileset.3tz`);
    assert.equal(response.status, 200);
    assert.equal(response.headers.get('content-type'), 'application/vnd.maxar.archive.3tz+zip');
    assert.match(response.headers.get('content-disposition'), new RegExp(`filename="${id}.3tz"`));
    const streamed = Buffer.from(await response.arrayBuffer());
    const exported = await hoodoo(['export', at(`archived/jobs/${id}/out`), '-o', at('job.3tz')]);
    assert.equal(exported.code, 0, exported.stderr);
    assert.ok(streamed.equals(await readFile(at('job.3tz'))));
    assert.equal((await server.fetch(`/jobs/${id}/files/other.3tz`)).status, 404);
    assert.equal((await server.fetch(`/jobs/${id}/files/tileset.3tz`, { method: 'HEAD' })).status, 200);
    const held = await Promise.all(Array.from({ length: 12 }, () => server.fetch(`/jobs/${id}/files/tileset.3tz`)));
    assert.ok(held.every(({ status }) => status === 200 || status === 503));
    for (const each of held) await each.arrayBuffer();
    assert.equal((await server.fetch(`/jobs/${id}/files/tileset.3tz`)).status, 200, 'whoever has ended makes room');
  } finally {
    await server.stop('SIGKILL');
  }
});

test('An archive and a folder are streamed alike', async () => {
  await exported('world.3tz');
  const server = await Server.start({ data: at('data'), args: ['--tileset', at('world.3tz'), '--tileset', at('bake')] });
  try {
    const { tilesets } = await server.json('/tilesets');
    assert.deepEqual(tilesets.map(({ name }) => name), ['bake', 'world']);
    assert.equal(tilesets[1].href, `${server.url}/tilesets/world/tileset.json`);
    const uris = [];
    JSON.stringify(await server.json('/tilesets/world/tileset.json'), (key, value) => {
      if (key === 'uri') uris.push(value);
      return value;
    });
    assert.ok(uris.length >= 14);
    for (const file of ['tileset.json', 'bake.json', ...uris]) {
      const [packed, plain] = await Promise.all(['world', 'bake'].map((name) => server.fetch(`/tilesets/${name}/${file}`)));
      assert.equal(packed.status, 200, file);
      for (const header of ['content-type', 'content-length', 'cache-control', 'accept-ranges', 'access-control-allow-origin']) {
        assert.equal(packed.headers.get(header), plain.headers.get(header), `${header} of ${file}`);
      }
      assert.ok(Buffer.from(await packed.arrayBuffer()).equals(Buffer.from(await plain.arrayBuffer())), file);
    }
    const tile = `/tilesets/world/${uris[0]}`;
    const whole = Buffer.from(await (await server.fetch(tile)).arrayBuffer());
    const part = await server.fetch(tile, { headers: { range: 'bytes=4-11' } });
    assert.equal(part.status, 206);
    assert.equal(part.headers.get('content-range'), `bytes 4-11/${whole.length}`);
    assert.deepEqual(Buffer.from(await part.arrayBuffer()), whole.subarray(4, 12));
    for (const path of [tile, '/tilesets/world/tileset.json']) {
      const etag = (await server.fetch(path)).headers.get('etag');
      assert.equal((await server.fetch(path, { headers: { 'if-none-match': etag } })).status, 304);
    }
    for (const path of ['/tilesets/world/@3dtilesIndex1@', '/tilesets/world/../bake/tileset.json', '/tilesets/world/nothing.json',
                        '/tilesets/other/tileset.json', '/tilesets/world/', '/tilesets/bake/.hoodoo/state.json']) {
      assert.equal((await server.raw(path)).status, 404, path);
    }
  } finally {
    await server.stop();
  }
});

/** what: [arguments of export, what it says]. */
const wrong = {
  'An unknown ending': [['-o', 'a.stl'], /a\.stl: must end in obj, ply, glb, gltf, vdb, png, tif or 3tz, got "stl"/],
  'An unknown format': [['-o', 'a', '--format', 'fbx'], /--format: must be obj, .* got "fbx"/],
  'A level that is not there': [['-o', 'a.ply', '--level', '3'], /--level: must be in \[0, 2\]/],
  'A region outside': [['-o', 'a.ply', '--region', '-50,-50,-10,-10'], /--region: -50,-50,-10,-10 m has no surface of level 0, which lies within 0,0,192,192 m/],
  'A region without ground': [['-o', 'a.ply', '--region', '10,10,10,20'], /--region: must be X0,Y0,X1,Y1 in metres/],
  'A region of three numbers': [['-o', 'a.ply', '--region', '1,2,3'], /--region: must be/],
  'A voxel without size': [['-o', 'a.vdb', '--voxel', '0'], /--voxel: must be in \[0\.0001, 1000000\] m, got "0"/],
  'A voxel of a mesh': [['-o', 'a.ply', '--voxel', '1'], /--voxel: is for a VDB alone/],
};
for (const [what, [args, says]] of Object.entries(wrong)) {
  test(`${what} is refused`, async () => {
    const result = await hoodoo(['export', at('bake'), ...args], { cwd: work });
    assert.equal(result.code, 2, result.stdout + result.stderr);
    assert.match(result.stderr, /^hoodoo: /);
    assert.match(result.stderr, says);
  });
}

test('What cannot be read, written or served is named', async () => {
  const nowhere = await hoodoo(['export', at('nowhere'), '-o', at('a.ply')]);
  assert.equal(nowhere.code, 4);
  assert.match(nowhere.stderr, /nowhere: is no folder/);
  const unwritable = await export_('scene.json/a.ply', '--json');
  assert.equal(unwritable.code, 4);
  assert.match(JSON.parse(unwritable.stderr).problems[0].where, /scene\.json/);
  const few = await hoodoo(['export', at('bake'), '-o', at('a.png'), '--pixel', '0.0001', '--json']);
  assert.equal(few.code, 3, few.stderr);
  await writeFile(at('not.3tz'), 'no archive');
  const served = await hoodoo(['serve', '--listen', '127.0.0.1:0', '--data', at('other'), '--tileset', at('not.3tz')], { limit: 10_000 });
  assert.equal(served.code, 2);
  assert.match(served.stderr, /not\.3tz: is no ZIP file/);
  const left = await readdir(work);
  assert.ok(!left.some((name) => name.endsWith('.part')), left.join());
});

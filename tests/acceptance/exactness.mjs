/**
 * Are borders exact, and is the picture whole? Bakes scenes whose features cross borders and corners of tiles, and asks
 * of each: that `hoodoo verify` finds nothing; that border vertices, decoded by others' tools, are the same to the bit
 * on every level and each level is one closed surface; and that two viewers (three.js with 3d-tiles-renderer, CesiumJS)
 * show, with several levels at once, no background where the unsplit meshes of those levels (`hoodoo export`) have none,
 * from twenty places, within caves too, where no skirt stands out.
 *
 * Each scene is its own control: a tile lifted by one step must be found in the files, and the skirts of one tile left out
 * in the picture. Prints a Markdown table; ends with 1 when anything is wrong.
 *
 *     node exactness.mjs [NAME ...] [--gallery] [--keep DIR] [--cameras N] [--viewers three,cesium]
 *
 * NAME picks scenes by a part of their name; --gallery takes the bundled examples, some of which are too small to show several
 * levels at once; --keep leaves tilesets and pictures in DIR. The control of skirts needs `three`.
 */
import { cp, mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';
import { holes, launch, serveFolders } from '../e2e/browser.mjs';
import { hoodoo, makeFolder, removeFolder } from '../e2e/hoodoo.mjs';
import { check } from '../e2e/tiles.mjs';
import { lookInto } from '../e2e/tiles/look.mjs';
import { Cesium, Three, Unsplit, error, skirtsIn } from './drawings.mjs';
import { gallery, scenes } from './scenes.mjs';

const fov = 50;   // degrees, as in the viewer

const { positionals: wanted, values: options } = parseArgs({
  allowPositionals: true,
  options: {
    gallery: { type: 'boolean', default: false }, keep: { type: 'string' }, cameras: { type: 'string', default: '20' }, viewers: { type: 'string', default: 'three,cesium' },
  },
});

/** Cameras within caves as given, the others around the world's middle, high and low, far and near. */
function camerasFor(box, inside, count) {
  const [x, y, z, hx, , , , hy, , , , hz] = box;
  const half = Math.max(hx, hy), list = inside.map(([position, target]) => ({ position, target, cave: true }));
  for (let i = 0; list.length < count; ++i) {
    const turn = 2.399963 * i, far = 0.35 + 0.9 * ((i * 0.618) % 1), up = 0.25 + 0.9 * ((i * 0.414) % 1);
    list.push({
      position: [x + far * half * Math.cos(turn), y + far * half * Math.sin(turn), z + hz + up * 0.4 * half],
      target: [x - 0.2 * half * Math.cos(turn), y - 0.2 * half * Math.sin(turn), z],
    });
  }
  return list.slice(0, count).map((camera) => ({ fov, near: camera.cave ? 0.3 : half / 2000, far: 20 * half, ...camera }));
}

const viewers = { three: Three, cesium: Cesium };
const chosen = options.gallery ? gallery : scenes;

/** Bakes and checks the files; gives what the table says and what is wrong. */
async function checkFiles(name, folder) {
  const made = await chosen[name](folder);
  await writeFile(join(folder, 'scene.json'), JSON.stringify(made.scene, null, 1));
  const run = async (args) => {
    const done = await hoodoo(args);
    if (done.code !== 0) throw new Error(`hoodoo ${args[0]}: exit ${done.code ?? done.signal}: ${done.stdout}${done.stderr}`);
    return done;
  };
  const tiles = join(folder, 'tileset');
  const baked = await run(['bake', join(folder, 'scene.json'), '-o', tiles, '--threads', '2', '--progress', 'off']);
  await run(['verify', tiles]);
  await mkdir(join(folder, 'export'), { recursive: true });
  const known = await lookInto(tiles);
  for (const level of known.files.keys()) {
    await run(['export', tiles, '--level', String(level), '-o', join(folder, `export/${level}.glb`)]);
  }
  const found = await check(tiles);
  const lifted = await countLifted(folder, known.files[0]);
  const unseen = lifted === 0 ? ['no crack is found around a leaf that stands one step too high'] : [];
  return { inside: made.inside, seconds: baked.seconds, found, lifted, problems: [...found.problems, ...unseen] };
}

/** Columns of the lattice with a crack once the leaf in the middle of `files` has been lifted by one step. */
async function countLifted(folder, files) {
  const { lattice: { step } } = JSON.parse(await readFile(join(folder, 'tileset/bake.json'), 'utf8'));
  const copy = join(folder, 'lifted'), file = join(copy, files[Math.floor(files.length / 2)]);
  await cp(join(folder, 'tileset'), copy, { recursive: true });
  await writeFile(file, lift(await readFile(file), step));
  const { cracks } = await check(copy);
  await rm(copy, { recursive: true });
  return cracks;
}

/** A .glb whose nodes stand `height` metres higher: up is y in glTF. */
function lift(glb, height) {
  const header = 12, start = header + 8, end = start + glb.readUInt32LE(header);
  const json = JSON.parse(glb.toString('utf8', start, end));
  for (const node of json.nodes) {
    const [x, y, z] = node.translation ?? [0, 0, 0];
    node.translation = [x, y + height, z];
  }
  const text = Buffer.from(JSON.stringify(json)), padded = Buffer.alloc(Math.ceil(text.length / 4) * 4, ' ');
  text.copy(padded);
  const moved = Buffer.concat([glb.subarray(0, start), padded, glb.subarray(end)]);
  moved.writeUInt32LE(moved.length, 8);
  moved.writeUInt32LE(padded.length, header);
  return moved;
}

/** Cracks where the tiles of a view hang no skirts, and at most where one of them hangs none. */
async function countBare(viewer, shown, solids) {
  const count = async (uri) => holes(await viewer.drawWithoutSkirts(uri), solids, error + 1).cracks;
  const all = await count();
  let one = 0;
  for (const uri of all > 0 ? shown : []) one = Math.max(one, await count(uri));
  return { all, one };
}

/** Looks at a scene through one viewer and adds what it sees to `result`. */
async function lookThrough(viewer, viewerName, cameras, { name, folder, known, unsplit, result }) {
  for (const [i, camera] of cameras.entries()) {
    const { mask, shown, problems } = await viewer.draw(camera);
    const picture = options.keep && join(folder, `${viewerName}-${String(i).padStart(2, '0')}.png`);
    if (picture) await viewer.page.screenshot({ path: picture });
    const onScreen = new Set(shown.map((file) => known.levels.get(/([0-9a-f]+\.glb)(\?|$)/.exec(file)[1])));
    const solids = await unsplit.draw(camera, onScreen);
    const { deep, cracks } = holes(mask, solids, error + 1);
    result.views += 1;
    result.mixed += onScreen.size > 1 ? 1 : 0;
    result.deep += deep;
    result.cracks += cracks;
    if (deep + cracks > 0) problems.push(`${deep} deep pixels of background and ${cracks} of cracks, levels ${[...onScreen]}`);
    if (!mask.bits.some((bit) => bit)) problems.push('shows nothing');
    if (camera.cave && viewerName === 'three') {
      const { pixels, wide } = skirtsIn(mask, await viewer.drawWithoutSkirtsColour());
      result.skirts += pixels;
      if (wide > 0) problems.push(`a skirt stands out within the cave: ${wide} of ${pixels} pixels`);
    } else if (viewerName === 'three' && !result.bare?.one) {
      result.bare = await countBare(viewer, shown, solids);
    }
    result.problems.push(...problems.map((what) => `${name}, ${viewerName}, camera ${i}: ${what}`));
  }
}

async function look(browser, name, folder, inside) {
  const known = await lookInto(join(folder, 'tileset'));
  const server = await serveFolders({ '/tileset/': join(folder, 'tileset'), '/export/': join(folder, 'export') });
  const result = { problems: [], views: 0, mixed: 0, deep: 0, cracks: 0, skirts: 0 };
  const unsplit = new Unsplit(), pages = [];
  const open = async (drawing) => {
    await drawing.open(browser, server);
    pages.push(drawing.page);
    return drawing;
  };
  try {
    const cameras = camerasFor(known.box, inside, Number(options.cameras));
    await open(unsplit);
    for (const viewerName of options.viewers.split(',')) {
      await lookThrough(await open(new viewers[viewerName]()), viewerName, cameras, { name, folder, known, unsplit, result });
    }
    if (options.gallery) return result;
    if (result.mixed < result.views / 4) result.problems.push(`${name}: only ${result.mixed} views show several levels`);
    if (result.bare?.one === 0) result.problems.push(`${name}: the skirts of one tile are not missed in any view`);
  } finally {
    for (const page of pages) await page.end();
    await server.close();
  }
  return result;
}

const names = Object.keys(chosen).filter((name) => wanted.length === 0 || wanted.some((part) => name.includes(part)));
if (names.length === 0) throw new Error(`no such scene, only ${Object.keys(chosen).join(', ')}`);
const count = new Intl.NumberFormat('en').format;
console.log('| scene | bake | tiles (files) | levels | border vertices equal | Euler of leaves | views (several levels) | background deep / cracks | cracked columns, one tile lifted | cracks without skirts / those of one tile | skirt pixels in caves | result |');
console.log('|---|---|---|---|---|---|---|---|---|---|---|---|');
const browser = await launch();
let failed = 0;
for (const name of names) {
  const folder = options.keep ? join(resolve(options.keep), name.replaceAll(' ', '-')) : await makeFolder();
  await mkdir(folder, { recursive: true });
  try {
    const { inside, seconds, found, lifted, problems } = await checkFiles(name, folder);
    const seen = await look(browser, name, folder, inside);
    problems.push(...seen.problems);
    for (const problem of problems.slice(0, 20)) console.error(`${name}: ${problem}`);
    failed += problems.length > 0 ? 1 : 0;
    const wrong = found.positionMismatches + found.normalMismatches;
    const cells = [
      name, `${seconds.toFixed(1)} s`, `${count(found.tiles)} (${count(found.contents)})`, Object.keys(found.euler).length,
      `${count(found.borderVertices - wrong)} of ${count(found.borderVertices)}`, found.euler[0], `${seen.views} (${seen.mixed})`,
      `${seen.deep} / ${seen.cracks}`, lifted, seen.bare ? `${seen.bare.all} / ${seen.bare.one}` : '-',
      seen.skirts, problems.length === 0 ? 'passes' : `${problems.length} problems`,
    ];
    console.log(`| ${cells.join(' | ')} |`);
  } catch (problem) {
    ++failed;
    console.log(`| ${name} | ${problem.message.trim().replaceAll('\n', ' ').slice(0, 400)} |`);
  } finally {
    if (!options.keep) await removeFolder(folder);
  }
}
await browser.close();
process.exit(failed === 0 ? 0 : 1);

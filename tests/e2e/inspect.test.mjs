/**
 * The tools of the web viewer: flat land of 192 m at 50 m, a ball of ore over it, a closed chamber below it. What they say is
 * held against `hoodoo probe`, `hoodoo diff`, bake.json, cs2cs and what follows from the camera.
 */
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launch, openPage, settle } from './browser.mjs';
import { writeDem } from './dem.mjs';
import { hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const ground = 50, side = 192;                      // m
const ball = { center: [95, 96, 70], radius: 10 };
const chamber = { center: [40, 40, 30], radius: 12 };
const moved = 2;                                    // m, the ball in the second job
const tileSize = 64;                                // m, of the finest level
const [width, height] = [960, 540], middle = [width / 2, height / 2];
const halfView = Math.tan((25 * Math.PI) / 180);    // of the camera, upright

const scene = (center = ball.center, bake = {}) => ({
  hoodoo: 1, name: 'Ball and chamber',
  materials: [{ name: 'rock', color: '#9a8877' }, { name: 'ore', color: '#3366cc' }],
  terrains: [{ id: 'land', dem: 'flat.tif', falloff: 8 }],
  operations: [
    { id: 'ball', op: 'union', material: 'ore', tree: { type: 'sphere', ...ball, center, falloff: 8 } },
    { id: 'chamber', op: 'carve', tree: { type: 'sphere', ...chamber, falloff: 4 } },
  ],
  bake: { spacing: 1, tile_cells: tileSize, ...bake },
});

let work, server, browser, first, second, earth, slabs;

before(async () => {
  work = await makeFolder();
  await mkdir(join(work, 'root'));
  await writeDem(join(work, 'root/flat.tif'), side / 2, 2, () => ground);
  server = await Server.start({ data: join(work, 'data'), roots: [join(work, 'root')] });
  const submit = async (what) => {
    const id = await server.submit(what);
    const info = (await server.follow(id)).at(-1);
    assert.equal(info.status, 'successful', info.message);
    return id;
  };
  [browser, first, second, earth, slabs] = await Promise.all([
    launch(), submit(scene()), submit(scene([ball.center[0] + moved, ...ball.center.slice(1)])),
    submit(scene(ball.center, { frame: 'ecef', vertical: 'ellipsoid' })), submit(scene(ball.center, { tile_triangles: 1000 })),
  ]);
});
after(async () => {
  await browser?.close();
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

/** Straight down from `up` metres over the ground at x, y. */
const above = ([x, y], up) => `cam=${x},${y},${ground + up}&at=${x},${y + 0.01},${ground}`;

async function open(query, hash = '', size = [width, height], more = {}) {
  const page = await openPage(browser, server.url, size, more);
  await page.goto(`${server.url}/viewer/?err=1&${query}#${hash}`);
  await settle(page);
  return page;
}
async function end(page) {
  assert.deepEqual(page.problems, []);
  assert.deepEqual(await page.evaluate(() => globalThis.hoodoo.errors), []);
  await page.end();
}

/** The rows of a card: {name: text}. */
const rows = (page, card) => page.evaluate((id) => {
  const terms = [...document.querySelectorAll(`#${id} dt`)];
  return Object.fromEntries(terms.map((term) => [term.textContent, term.nextElementSibling.textContent]));
}, card);
const numbers = (text) => text.match(/-?\d+(\.\d+)?/g).map(Number);
const near = (found, wanted, most, what) => assert.ok(Math.abs(found - wanted) <= most, `${what}: ${found}, not ${wanted}`);

async function inspect(page, at) {
  await page.evaluate(() => globalThis.hoodoo.tools.inspector.clear());
  await page.mouse.click(...at);
  await page.waitForFunction(() => globalThis.hoodoo.tools.inspector.found?.complete);
  return rows(page, 'inspect-card');
}

/** Red, green and blue of the canvas, drawn anew: of one pixel of the page, or of all, as a digest and the share of `background`. */
const pixel = (page, [x, y]) => page.evaluate(([left, top]) => {
  const { stage } = globalThis.hoodoo;
  stage.render();
  const gl = stage.renderer.getContext(), data = new Uint8Array(4);
  gl.readPixels(left, gl.drawingBufferHeight - 1 - top, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, data);
  return [...data.slice(0, 3)];
}, [x, y]);
const differ = (a, b) => Math.max(...a.map((value, i) => Math.abs(value - b[i])));

const bakeOf = (id) => server.json(`/jobs/${id}/tiles/bake.json`);
const skirtTriangles = (page) => page.evaluate(() => globalThis.hoodoo.terrain.statistics().skirtTriangles);

test('The inspector says of a point what probe and bake.json say', async () => {
  const page = await open(`job=${first}`, above(ball.center, 60));
  await page.keyboard.press('KeyI');
  assert.ok(await page.getByText('Click a point.').isVisible());
  const { tiles } = await bakeOf(first);
  const found = [];
  for (const at of [middle, [middle[0] + 220, middle[1] - 60]]) {
    const said = await inspect(page, at);
    const place = numbers(said.Position), [x, y] = place;
    const key = `0/${Math.floor(x / tileSize)}/${Math.floor(y / tileSize)}`;
    const tile = tiles.find((each) => each.key === key);
    assert.equal(said.Tile, key);
    assert.equal(said.Level, '0 (finest 0, coarsest 2)');
    assert.equal(said.Slice, tile.slice);
    assert.equal(said.File, tile.content);
    assert.equal(said['Geometric error'], `${tile.geometricError.toFixed(2)} m`);
    assert.equal(said.Map, `EPSG:32632: ${(500000 + x).toFixed(2)}, ${(5000000 - side + y).toFixed(2)}`);
    const link = await page.getAttribute('#inspect-card a', 'href');
    assert.equal((await fetch(link, { method: 'HEAD' })).status, 200);
    found.push({ place, material: said.Material });
  }
  near(found[0].place[2], ball.center[2] + ball.radius, 0.2, 'top of the ball');
  near(found[1].place[2], ground, 0.1, 'ground');

  await writeFile(join(work, 'root/scene.json'), JSON.stringify(scene()));
  await writeFile(join(work, 'points.csv'), `x,y,z\n${found.map(({ place }) => place.join(',')).join('\n')}\n`);
  const probed = await hoodoo(['probe', join(work, 'root/scene.json'), '--points', join(work, 'points.csv')]);
  assert.equal(probed.code, 0, probed.stderr);
  const materials = probed.stdout.trimEnd().split('\n').slice(1).map((line) => line.split(',')[8]);
  assert.deepEqual(found.map(({ material }) => material), materials);
  assert.deepEqual(materials, ['ore', 'rock']);

  await page.evaluate(() => {                        // up
    const { navigation, stage: { camera: { position } } } = globalThis.hoodoo;
    navigation.lookFrom(position, position.clone().add({ x: 0, y: 50, z: 50 }));
  });
  await settle(page);
  await page.mouse.click(...middle);                 // on the sky
  assert.equal((await page.textContent('#inspect-card p')).trim(), 'Nothing there.');
  assert.deepEqual(await rows(page, 'inspect-card'), {});
  await page.keyboard.press('Escape');
  assert.ok(!await page.isVisible('#inspect-card'));
  await end(page);
});

test('It knows the slabs of a tile', async () => {
  const page = await open(`job=${slabs}`, above(ball.center, 60));
  await page.keyboard.press('KeyI');
  const tile = (await bakeOf(slabs)).tiles.find(({ key }) => key === '0/1/1');
  const digests = tile.contents.map(({ content }) => content);
  assert.ok(digests.length > 1);
  const files = new Set();
  for (const at of [middle, [middle[0] + 160, middle[1]]]) {
    const said = await inspect(page, at);
    assert.deepEqual([said.Tile, said.Slice], ['0/1/1', tile.slice]);
    assert.ok(digests.includes(said.File));
    files.add(said.File);
  }
  assert.equal(files.size, 2, 'the ball and the land are in slabs of their own');
  await end(page);
});

test('On the Earth it says longitude, latitude and height', async () => {
  const page = await open(`job=${earth}`);
  await page.keyboard.press('KeyI');
  const said = await inspect(page, middle);
  const [lon, lat] = numbers(said['Longitude, latitude']);
  const { stdout, status, stderr } = spawnSync('cs2cs', ['-f', '%.3f', 'EPSG:4326', 'EPSG:32632'], { input: `${lat} ${lon}\n`, encoding: 'utf8' });
  assert.equal(status, 0, stderr);
  const [east, north] = numbers(stdout), [x, y] = [east - 500000, north - 5000000 + side];
  assert.ok(x > 0 && x < side && y > 0 && y < side, `${x}, ${y}`);
  near(numbers(said['Above the ellipsoid'])[0], ground, 31, 'land or ball');
  // The frame's east and north leave the grid's by less than a metre here.
  const [px, py] = numbers(said.Position);
  const { tiles } = await bakeOf(earth);
  const [low, high] = tiles.reduce(([a, b], { box }) => [[Math.min(a[0], box[0]), Math.min(a[1], box[1])], [Math.max(b[0], box[3]), Math.max(b[1], box[4])]],
                                   [[Infinity, Infinity], [-Infinity, -Infinity]]);
  near(x / side, (px - low[0]) / (high[0] - low[0]), 0.02, 'from west to east');
  near(y / side, (py - low[1]) / (high[1] - low[1]), 0.02, 'from south to north');
  await end(page);
});

test('A measurement is as long as the camera says', async () => {
  const up = 100, away = 200;                        // m over the ground, pixels
  const page = await open(`job=${first}`, above([150, 150], up));
  const metresPerPixel = (2 * up * halfView) / height;
  await page.click('#tool-measure');
  await page.mouse.click(middle[0] - away, middle[1]);
  await page.mouse.click(middle[0] + away / 2, middle[1]);
  const flat = await rows(page, 'measure-card');
  near(numbers(flat.Distance)[0], 1.5 * away * metresPerPixel, 0.3, 'distance');
  near(numbers(flat.Horizontal)[0], 1.5 * away * metresPerPixel, 0.3, 'horizontal');
  near(numbers(flat.Vertical)[0], 0, 0.1, 'vertical');

  await page.goto('about:blank');
  await page.goto(`${server.url}/viewer/?err=1&job=${first}#${above(ball.center, up)}`);
  await settle(page);
  await page.keyboard.press('KeyM');
  await page.keyboard.press('Enter');                // the top of the ball, in the middle
  await page.mouse.click(middle[0] + away, middle[1]);
  const steep = await rows(page, 'measure-card');
  const across = away * metresPerPixel, down = ground - ball.center[2] - ball.radius;
  near(numbers(steep.Horizontal)[0], across, 0.4, 'horizontal');
  near(numbers(steep.Vertical)[0], down, 0.3, 'vertical');
  near(numbers(steep.Distance)[0], Math.hypot(across, down), 0.4, 'distance');
  near(numbers(steep.Slope)[0], (Math.atan2(down, across) * 180) / Math.PI, 0.5, 'slope');
  await end(page);
});

test('A section opens the ground and shows the chamber in it', async () => {
  const [x, y, z] = chamber.center;
  const page = await open(`job=${first}`, `cam=${x},${y - 60},${z + 60}&at=${x},${y},${z}`);
  const perPixel = (2 * Math.hypot(60, 60) * halfView) / height;
  const beside = [Math.round(middle[0] + (chamber.radius + 8) / perPixel), middle[1]];
  const closed = await pixel(page, middle);
  await page.click('#tool-section');
  await page.click('#section-axis input[value=y]');
  await page.evaluate((level) => {
    const slider = document.getElementById('section-level'), { box } = globalThis.hoodoo.tools.section;
    slider.value = (1000 * (level - box.min.y)) / (box.max.y - box.min.y);
    slider.dispatchEvent(new Event('input', { bubbles: true }));
  }, y);
  await settle(page);
  assert.match(await page.inputValue('#section-text').catch(() => page.textContent('#section-text')), /^y = (39\.9|40\.0|40\.1) m$/);
  const open_ = await pixel(page, middle), rock = await pixel(page, beside);
  assert.ok(differ(closed, open_) > 10, 'the picture changes');
  assert.ok(rock.every((value, i) => value >= [100, 80, 60][i] && value <= [130, 107, 86][i]), `rock cut open, not ${rock}`);
  assert.ok(differ(open_, rock) > 10, 'the chamber is not filled');

  await page.keyboard.press('KeyI');
  const wall = numbers((await inspect(page, middle)).Position);
  near(Math.hypot(...wall.map((value, i) => value - chamber.center[i])), chamber.radius, 0.5, "the chamber's wall");
  await page.mouse.click(...beside);
  const cut = await rows(page, 'inspect-card');
  assert.equal(cut.Material, 'rock, cut open');
  near(numbers(cut.Position)[1], y, 0.1, 'the plane');
  await page.keyboard.press('KeyI');

  await page.keyboard.press('KeyC');                 // on to z, through the ball
  await page.evaluate((level) => globalThis.hoodoo.tools.section.cut(2, level), chamber.center[2]);
  await settle(page);
  const [level, hole] = [await pixel(page, beside), await pixel(page, middle)];
  assert.ok(level.every((value, i) => value >= [100, 80, 60][i] && value <= [130, 107, 86][i]), `level rock cut open, not ${level}`);
  assert.ok(differ(level, hole) > 10, 'the chamber seen from above');
  await page.keyboard.press('KeyC');
  await settle(page);
  assert.ok(differ(await pixel(page, middle), closed) <= 2, 'and all is as it was');
  await end(page);
});

test('Underground there are no skirts, and the land has an inner side', async () => {
  const page = await open(`job=${first}`, 'cam=150,20,-60&at=100,100,50');
  assert.ok(await skirtTriangles(page) > 0);
  const sky = await pixel(page, middle);
  await page.keyboard.press('KeyZ');
  await settle(page);
  assert.equal(await skirtTriangles(page), 0);
  const rock = await pixel(page, middle);
  assert.ok(differ(rock, sky) > 30 && rock[0] > rock[2] && Math.max(...rock) > 40, `lit rock, not ${rock}`);
  await page.click('#tool-underground');
  await settle(page);
  assert.ok(await skirtTriangles(page) > 0);
  assert.ok(differ(await pixel(page, middle), sky) <= 2);
  await end(page);
});

test('A link shows the same view, section, measurement and mode', async () => {
  const page = await open(`job=${first}`, above(ball.center, 120));
  await page.keyboard.press('Digit2');
  await page.evaluate(() => globalThis.hoodoo.tools.section.cut(0, 60.5, true));
  await page.keyboard.press('KeyZ');
  await page.keyboard.press('KeyX');
  await page.keyboard.press('KeyM');
  await page.mouse.click(...middle);
  await page.evaluate(() => { globalThis.hoodoo.navigation.orbit.enableDamping = false; });   // it would go on for a second
  await page.mouse.move(...middle);
  await page.mouse.down();
  await page.mouse.move(middle[0] + 80, middle[1] - 40, { steps: 4 });
  await page.mouse.up();
  await settle(page);
  await page.click('#tool-share');
  const link = await page.inputValue('#share-link');
  const state = (of) => of.evaluate(() => {
    const { stage, navigation, tools } = globalThis.hoodoo;
    return { camera: stage.camera.position.toArray(), target: navigation.target.toArray(), tools: tools.state,
      colours: document.querySelector('#colours :checked').value };
  });
  const there = await state(page);
  assert.equal(there.tools.cut, 'x,60.50,-');
  assert.equal(there.tools.under, '1');
  assert.ok(there.tools.measure);

  const other = await openPage(browser, server.url, [width, height]);
  await other.goto(link);
  await settle(other);
  const here = await state(other);
  for (const what of ['camera', 'target']) there[what].forEach((value, i) => near(here[what][i], value, 0.02, what));
  assert.deepEqual({ tools: here.tools, colours: here.colours }, { tools: there.tools, colours: 'materials' });
  assert.equal(await other.getAttribute('#tool-underground', 'aria-pressed'), 'true');
  await other.evaluate(() => { location.hash = location.hash.replace('x,60.50,-', 'y,20'); });   // a link into the open page
  await other.waitForFunction(() => globalThis.hoodoo.tools.section.text === 'y,20.00');
  assert.ok(await other.isChecked('#wireframe'));
  assert.equal(await other.inputValue('#colours :checked'), 'materials', 'and drops nothing of it');
  await page.click('#home');
  await page.waitForFunction((old) => document.getElementById('share-link').value !== old, link);   // it follows the view
  await end(page);
  await end(other);
});

test('Two jobs side by side: tiles that differ are listed and tinted', async () => {
  const page = await open(`job=${first}&with=${second}`);
  await page.waitForFunction(() => globalThis.hoodoo.compare.rows);
  const listed = await page.$$eval('#compare-card tbody tr', (all) => all.map((row) => [row.cells[0].textContent, row.cells[1].textContent]));

  const [before_, after_] = await Promise.all([bakeOf(first), bakeOf(second)]);
  const contents = (bake) => new Map(bake.tiles.map(({ key, content }) => [key, content]));
  const [old, new_] = [contents(before_), contents(after_)];
  assert.equal(old.size, new_.size);
  const other = [...old.keys()].filter((key) => old.get(key) !== new_.get(key)).sort();
  assert.deepEqual(listed, other.map((key) => [key, 'changed']));
  assert.deepEqual(other, ['0/1/1', '1/0/0', '2/0/0'], 'the tiles over the ball');
  const folder = (id) => join(work, 'data/jobs', id, 'out');
  const { stdout } = await hoodoo(['diff', folder(first), folder(second), '--json']);
  assert.deepEqual(JSON.parse(stdout).tiles.map(({ key }) => key).sort(), listed.map(([key]) => key));

  await settle(page);
  const tinted = await page.evaluate(() => globalThis.hoodoo.stage.panes.map((_, i) => globalThis.hoodoo.compare.terrains[i].surfaces
    .map(({ material, userData }) => [userData.uri, material.emissive.getHex() !== 0])));
  for (const [i, bake] of [before_, after_].entries()) {
    assert.ok(tinted[i].length > 4 && tinted[i].some(([, is]) => is));
    const changed = new Set(bake.tiles.filter(({ key }) => other.includes(key)).map(({ uri }) => uri));
    for (const [uri, is] of tinted[i]) assert.equal(is, changed.has(uri), uri);
  }
  const [left, right] = [await pixel(page, [width / 4, height / 2]), await pixel(page, [(3 * width) / 4, height / 2])];
  assert.ok(differ(left, right) < 40, 'one camera, two panes');

  const camera = () => page.evaluate(() => globalThis.hoodoo.stage.camera.position.toArray());
  const whole = await camera();
  await page.click('#compare-card tbody button');
  await settle(page);
  assert.ok(differ(whole, await camera()) > 10, 'a row leads to its tile');
  await end(page);
});

test('A comparison with itself lists nothing, in whichever form bake.json is', async () => {
  const page = await openPage(browser, server.url, [width, height]);
  let asked = 0;
  await page.route('**/bake.json', async (route) => {   // at first as it is, then as JSON Lines
    const { tiles, ...header } = await bakeOf(first);
    const lines = [{ ...header, format: 2 }, ...tiles, { key: '0/9/9', missing: true }].map((line) => JSON.stringify(line));
    if (++asked === 1) await route.continue();
    else await route.fulfill({ body: `${lines.join('\n')}\n` });
  });
  const tileset = `/jobs/${first}/tiles/tileset.json`;
  await page.goto(`${server.url}/viewer/?tileset=${tileset}&with=${tileset}`);
  await settle(page);
  await page.waitForFunction(() => globalThis.hoodoo.compare.rows);
  assert.equal(await page.textContent('#compare-card [role=status]'), 'All 14 tiles are the same.');
  assert.equal(asked, 2);
  assert.ok(!await page.isVisible('#compare-card table'));
  await end(page);
});

test('At 400 pixels all tools can be touched', async () => {
  const size = [400, 800];
  const page = await open(`job=${first}`, above(ball.center, 100), size, { hasTouch: true, isMobile: true });
  const inside = async (selector) => {
    const box = await page.locator(selector).boundingBox();
    assert.ok(box && box.x >= 0 && box.y >= 0 && box.x + box.width <= size[0] && box.y + box.height <= size[1], `${selector}: ${JSON.stringify(box)}`);
    return box;
  };
  assert.ok(!await page.isVisible('#controls'), 'the panel is folded');
  for (const name of ['inspect', 'measure', 'section', 'underground', 'share', 'help']) await inside(`#tool-${name}`);
  await page.tap('#tool-inspect');
  await page.touchscreen.tap(size[0] / 2, size[1] / 2);
  await page.waitForFunction(() => globalThis.hoodoo.tools.inspector.found?.complete);
  assert.equal((await rows(page, 'inspect-card')).Material, 'ore');
  const card = await inside('#inspect-card');
  assert.ok(card.y > size[1] / 2, 'the point stays in sight');
  await page.tap('#inspect-card .close');
  await page.tap('#tool-section');
  await inside('#section-level');
  await page.tap('#section-flip');
  await page.tap('#tool-section');
  await page.tap('#tool-help');
  await inside('#help');
  await page.keyboard.press('Escape');
  await page.tap('#fold');
  assert.ok(await page.isVisible('#controls'));
  await inside('#panel');
  await end(page);

  const pair = await open(`job=${first}&with=${second}`, '', size, { hasTouch: true, isMobile: true });
  await pair.waitForFunction(() => globalThis.hoodoo.compare.rows);
  const panes = await pair.evaluate(() => [0, 1].map((i) => globalThis.hoodoo.stage.pane(i)));
  assert.deepEqual(panes.map(({ top, height: tall }) => [top, tall]), [[0, 400], [400, 400]]);
  await end(pair);
});

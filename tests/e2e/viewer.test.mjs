/** The web viewer in a browser: it follows a job while it bakes, and does what its panel and keys say. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launch, openPage, settle } from './browser.mjs';
import { exampleScene, makeFolder, makeRoot, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

let work, server, browser, scene, id;

before(async () => {
  work = await makeFolder();
  const root = await makeRoot(work);
  scene = await exampleScene();
  server = await Server.start({ data: join(work, 'data'), roots: [root] });
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

const statistics = (page) => page.evaluate(() => {
  const { tiles, triangles, materials } = globalThis.hoodoo.terrain.statistics();
  return { tiles, triangles, materials: [...materials.keys()].sort() };
});

async function open(address, size = [960, 540]) {
  const page = await openPage(browser, server.url, size);
  await page.goto(server.url + address);
  return page;
}

/** Waits for tiles on screen; says what the viewer was at where none come. */
async function showsTiles(page) {
  try {
    await page.waitForFunction(() => globalThis.hoodoo?.terrain.statistics().tiles > 0, null, { timeout: 60_000 });
  } catch (error) {
    error.message += await page.evaluate(() => {
      const { current, next, stale } = globalThis.hoodoo?.terrain ?? {};
      return JSON.stringify({ stale, current: current?.stats, next: next?.stats, root: next?.root?.boundingVolume, errors: globalThis.hoodoo?.errors });
    });
    throw error;
  }
}

test('It shows a job while it bakes, and all of it at the end', async () => {
  const page = await open('/viewer/');   // so that the browser is ready when the bake begins
  id = await server.submit({ ...scene, bake: { ...scene.bake, spacing: 0.75 } });
  await page.goto(`${server.url}/viewer/?job=${id}`);
  await showsTiles(page);
  const { status } = await server.json(`/jobs/${id}`);
  assert.equal(status, 'running', 'tiles are on screen before the job ends');
  assert.equal((await server.follow(id)).at(-1).status, 'successful');
  await page.waitForFunction(() => document.getElementById('message').textContent === 'Finished.', null, { timeout: 60_000 });
  await settle(page);
  assert.equal(await page.textContent('#title'), scene.name);
  const live = await statistics(page);
  assert.deepEqual(page.problems, []);
  await page.end();

  const fresh = await open(`/viewer/?job=${id}`);
  await settle(fresh);
  assert.deepEqual(await statistics(fresh), live, 'it ends as if it had been opened after the job');
  assert.deepEqual(fresh.problems, []);
  await fresh.end();
});

test('A tileset with nothing to see yet holds up no later one', async () => {
  const page = await openPage(browser, server.url, [960, 540]);
  const bare = ({ content, contents, children, ...tile }) => ({ ...tile, ...children && { children: children.map(bare) } });
  let looks = 0, loads = 0;
  await page.route(`**/jobs/${id}`, async (route) => {   // as if the bake had only begun at the first look
    const response = await route.fetch();
    const info = await response.json();
    await route.fulfill({ response, json: ++looks === 1 ? { ...info, status: 'running' } : info });
  });
  await page.route('**/tileset.json', async (route) => {
    const response = await route.fetch();
    if (route.request().method() === 'HEAD') {
      await route.fulfill({ response, headers: { ...response.headers(), etag: `"${looks}"` } });
    } else if (++loads === 1) {
      const tileset = await response.json();
      await route.fulfill({ response, json: { ...tileset, root: bare(tileset.root) } });
    } else {
      await route.fulfill({ response });
    }
  });
  await page.goto(`${server.url}/viewer/?job=${id}`);
  await showsTiles(page);
  assert.equal(loads, 2);
  await page.end();
});

test('Its panel and keys change what is drawn', async () => {
  const page = await open(`/viewer/?job=${id}`);
  await settle(page);
  const before_ = await statistics(page);
  const picture = async () => {
    await settle(page);
    const url = await page.evaluate(() => {
      globalThis.hoodoo.stage.render();   // what is drawn can be read until the task ends
      return globalThis.hoodoo.stage.renderer.domElement.toDataURL();
    });
    return createHash('sha256').update(url).digest('hex');
  };
  const natural = await picture();

  const pictures = new Set([natural]);
  for (const key of ['2', '3', '4']) {
    await page.keyboard.press(`Digit${key}`);
    pictures.add(await picture());
  }
  assert.equal(pictures.size, 4, 'natural, material, clay and level differ');
  await page.keyboard.press('Digit2');
  assert.deepEqual((await statistics(page)).materials, scene.materials.map(({ name }) => name).sort());
  await page.keyboard.press('Digit1');
  assert.equal(await picture(), natural, 'and natural is as it was');

  for (const name of ['wireframe', 'bounds', 'shadows']) {
    await page.click(`#${name}`);
    assert.notEqual(await picture(), natural, name);
    await page.click(`#${name}`);
  }
  await page.click('#skirts');
  await settle(page);
  assert.ok((await statistics(page)).triangles < before_.triangles, 'skirts are left out');
  await page.click('#skirts');
  assert.equal(await picture(), natural);

  await page.fill('#error', '0');
  await settle(page);
  assert.ok((await statistics(page)).triangles > before_.triangles, 'a smaller error brings more triangles');
  assert.deepEqual(page.problems, []);
  await page.end();
});

test('One can fly, and the address keeps the view', async () => {
  const page = await open(`/viewer/?job=${id}`);
  await settle(page);
  const position = (of) => of.evaluate(() => globalThis.hoodoo.stage.camera.position.toArray());
  await page.keyboard.press('KeyF');
  const start = await position(page);
  await page.locator('#view').focus();
  await page.keyboard.down('KeyW');
  await page.waitForTimeout(500);
  await page.keyboard.up('KeyW');
  await settle(page);
  const end = await position(page);
  assert.ok(Math.hypot(...end.map((x, i) => x - start[i])) > 1, 'W flies on');
  await page.waitForFunction(() => location.hash.includes('nav=fly'));
  await page.waitForTimeout(600);
  const hash = await page.evaluate(() => location.hash);

  const other = await open(`/viewer/?job=${id}${hash}`);
  await settle(other);
  const there = await position(other);
  end.forEach((x, i) => assert.ok(Math.abs(x - there[i]) < 0.1, `${there} is not ${end}`));
  assert.equal(await other.isChecked('input[value=fly]'), true);
  await page.end();
  await other.end();
});

test('Without a job it lists the jobs, and says when there is none of that name', async () => {
  const page = await open('/viewer/');
  await page.click('#jobs a');
  await settle(page);
  assert.match(page.url(), new RegExp(`job=${id}`));
  assert.deepEqual(page.problems, []);
  await page.end();
  const none = await open('/viewer/?job=nothing');
  await none.waitForFunction(() => document.getElementById('error-box').textContent.includes('no job'));
  await none.end();
});

test('It helps with keys', async () => {
  const page = await open(`/viewer/?job=${id}`);
  await settle(page);
  await page.keyboard.press('?');
  assert.ok(await page.isVisible('#help'));
  await page.keyboard.press('Escape');
  await page.keyboard.press('KeyU');
  assert.ok(!await page.isVisible('#panel'));
  await page.end();
});

test('A path that tries to be another origin loads nothing', async () => {
  const page = await open('/viewer/?tileset=http://192.0.2.1/tileset.json');
  await page.waitForFunction(() => globalThis.hoodoo?.errors.length > 0);
  assert.ok(!page.problems.some((problem) => problem.startsWith('off the origin')), page.problems.join());
  await page.end();
});

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

/**
 * Addresses whose content the server sends to a page. While a bake runs the errors of its tiles are estimates, so that a tile
 * may go for finer ones and come back at the end: out of the browser's own store, since its content stays for ever.
 */
async function answersOf(page, pattern) {
  const sent = [], kept = new Set(), network = await page.context().newCDPSession(page);
  network.on('Network.requestServedFromCache', ({ requestId }) => kept.add(requestId));
  network.on('Network.responseReceived', ({ requestId, response: { url, fromDiskCache } }) => {
    if (pattern.test(url) && !fromDiskCache && !kept.has(requestId)) sent.push(url);
  });
  await network.send('Network.enable');
  return sent;
}

test('It shows a job while it bakes, and all of it at the end', async () => {
  const page = await open('/viewer/');   // so that the browser is ready when the bake begins
  id = await server.submit({ ...scene, bake: { ...scene.bake, spacing: 0.75 } });
  const sent = await answersOf(page, /\.glb$|jobs\/\w+$/);
  await page.goto(`${server.url}/viewer/?job=${id}`);
  await showsTiles(page);
  const { status } = await server.json(`/jobs/${id}`);
  assert.equal(status, 'running', 'tiles are on screen before the job ends');
  assert.equal((await server.follow(id)).at(-1).status, 'successful');
  await page.waitForFunction(() => document.getElementById('message').textContent === 'Finished.', null, { timeout: 60_000 });
  await settle(page);
  assert.equal(await page.textContent('#title'), scene.name);
  assert.equal(await page.textContent('#job-status'), 'successful');
  const live = await statistics(page);
  assert.ok(sent.length > 1 && new Set(sent).size === sent.length, `each tile is sent once, not ${sent.length} for ${new Set(sent).size}`);
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
  let asked = 0, looks = 0, loads = 0;
  await page.route('**/events', async (route) => {   // as if the bake had only begun at the first look
    const began = ++asked === 1, info = await server.json(`/jobs/${id}`);
    const data = JSON.stringify(began ? { ...info, status: 'running' } : info);
    await route.fulfill({ contentType: 'text/event-stream', body: `id: ${asked}\nevent: ${began ? 'status' : 'end'}\ndata: ${data}\n\n` });
  });
  await page.route('**/tileset.json', async (route) => {
    const response = await route.fetch();
    if (route.request().method() === 'HEAD') {
      await route.fulfill({ response, headers: { ...response.headers(), etag: `"${++looks}"` } });
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

test('Tiles that did not come are asked for again, and it says so until they are there', async () => {
  const page = await openPage(browser, server.url, [960, 540]);
  let broken = true;
  await page.route('**/*.glb', (route) => (broken ? route.abort() : route.continue()));
  await page.goto(`${server.url}/viewer/?job=${id}`);
  await page.waitForSelector('#error-box:not([hidden])');
  assert.equal((await page.textContent('#error-said')).trim(), 'A tile could not be loaded; trying again.');
  await page.click('#error-close');
  assert.ok(await page.isHidden('#error-box'));
  await page.waitForSelector('#error-box:not([hidden])');   // once more in vain
  broken = false;
  await showsTiles(page);
  await page.waitForSelector('#error-box', { state: 'hidden' });
  await settle(page);
  const whole = await statistics(page);
  await page.reload();
  await settle(page);
  assert.deepEqual(whole, await statistics(page), 'nothing is missing');
  await page.end();
});

test('It says that the server is away, and goes on when it is back', async () => {
  const page = await openPage(browser, server.url, [960, 540]);
  let away = true;
  await page.route('**/events', (route) => (away ? route.abort() : route.continue()));
  await page.goto(`${server.url}/viewer/?job=${id}`);
  await page.waitForFunction(() => /does not answer; trying again/.test(document.getElementById('message').textContent));
  assert.ok(await page.isHidden('#progress'));
  away = false;
  await page.waitForFunction(() => document.getElementById('message').textContent === 'Finished.');
  await showsTiles(page);
  await page.end();
});

test('What was cancelled is shown as far as it came, and said to be incomplete', async () => {
  const job = await server.submit({ ...scene, bake: { ...scene.bake, spacing: 0.5 } });
  await server.follow(job, ({ tiles }) => tiles?.done > 0);
  await server.fetch(`/jobs/${job}`, { method: 'DELETE' });
  const page = await open(`/viewer/?job=${job}`);
  await page.waitForSelector('#incomplete:not([hidden])');
  assert.equal(await page.textContent('#job-status'), 'dismissed');
  assert.ok(await page.isHidden('#progress'));
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

test('The camera is turned and moved by keys', async () => {
  const page = await open(`/viewer/?job=${id}`);
  await settle(page);
  const view = async () => {
    await settle(page);
    return page.evaluate(() => {
      const { stage: { camera }, navigation } = globalThis.hoodoo;
      const { x, y, z } = navigation.fly.forward;
      return { yaw: Math.atan2(y, x), pitch: Math.asin(z), distance: camera.position.distanceTo(navigation.orbit.target) };
    });
  };
  const press = async (key) => {
    await page.keyboard.press(key);
    return view();
  };
  await page.locator('#view').focus();
  const start = await view(), turned = await press('ArrowLeft'), tilted = await press('ArrowUp'), closer = await press('+');
  assert.notEqual(await page.locator('#view').evaluate((view_) => getComputedStyle(view_).outlineStyle), 'none', 'the focus is seen');
  assert.ok(turned.yaw > start.yaw + 0.01 && Math.abs(turned.pitch - start.pitch) < 0.001, 'to the left');
  assert.ok(tilted.pitch > turned.pitch + 0.01, 'up');
  assert.ok(Math.abs(tilted.distance - start.distance) < 0.01 * start.distance, 'about the same point');
  assert.ok(closer.distance < 0.95 * start.distance, 'closer');
  assert.ok((await press('-')).distance > closer.distance, 'and farther');
  await page.keyboard.press('KeyF');
  const flying = await view(), right = await press('ArrowRight');
  assert.ok(right.yaw < flying.yaw - 0.01, 'flying, too');
  assert.deepEqual(page.problems, []);
  await page.end();
});

test('It lists bakes only, draws nothing meanwhile, and says where a job has no terrain', async () => {
  const answer = await server.fetch('/processes/echo/execution', {
    method: 'POST', headers: { 'content-type': 'application/json', prefer: 'respond-async' }, body: '{"inputs": {"echo": "hello"}}',
  });
  const { jobID } = await answer.json();
  const page = await open('/viewer/');
  await page.waitForSelector('#jobs a');
  assert.equal(await page.locator(`#jobs a[href="?job=${jobID}"]`).count(), 0);
  assert.ok(await page.locator(`#jobs a[href="?job=${id}"]`).count());
  await page.waitForFunction(() => document.getElementById('statistics').textContent.endsWith('idle'));
  await page.goto(`${server.url}/viewer/?job=${jobID}`);
  await page.waitForFunction(() => /has no terrain/.test(document.getElementById('error-said').textContent));
  assert.deepEqual(page.problems, []);
  await page.route('**/jobs?*', (route) => route.abort());
  await page.goto(`${server.url}/viewer/`);
  await page.waitForFunction(() => /does not answer/.test(document.getElementById('error-said').textContent));
  assert.deepEqual(page.problems.filter((problem) => problem.startsWith('page:')), []);
  await page.end();
});

test('Without a job it lists the jobs, and says when there is none of that name', async () => {
  const page = await open('/viewer/');
  await page.click(`#jobs a[href="?job=${id}"]`);
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
  await page.keyboard.press('KeyX');
  assert.ok(!await page.isChecked('#wireframe'), 'keys do nothing behind it');
  await page.keyboard.press('Escape');
  await page.click('#tool-share');
  await page.locator('#share-link').press('KeyX');
  assert.ok(!await page.isChecked('#wireframe'), 'nor in a field');
  await page.keyboard.press('Escape');
  assert.ok(await page.isHidden('#share-card'));
  await page.keyboard.press('KeyX');
  assert.ok(await page.isChecked('#wireframe'));
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

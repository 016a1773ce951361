/** The viewer's pages of jobs and of submission, as somebody uses them who has a DEM and a scene in mind. */
import assert from 'node:assert/strict';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { barriers } from './barriers.mjs';
import { launch, openPage, settle } from './browser.mjs';
import { writeDem } from './dem.mjs';
import { example, makeFolder, makeKey, removeFolder, synthesize } from './hoodoo.mjs';
import { Server } from './server.mjs';
import { drop, says, textOf, write } from './submitting.mjs';

const sizes = [[1280, 800], [400, 800]];
let work, server, browser, dem, scene;

before(async () => {
  work = await makeFolder();
  dem = await synthesize(join(work, 'coast.tif'));
  const root = join(work, 'root');
  await mkdir(root);
  await writeDem(join(root, 'flat.tif'), 64, 2, () => 10);
  scene = await readFile(join(example, 'scene.json'), 'utf8');
  server = await Server.start({ data: join(work, 'data'), roots: [root] });
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

const flat = (spacing, name = 'Flat') => ({ hoodoo: 1, name, terrains: [{ id: 'land', dem: 'flat.tif' }], bake: { spacing } });

async function open(path, size = sizes[0], at = server) {
  const page = await openPage(browser, at.url, size);
  await page.goto(`${at.url}/viewer/${path}`);
  return page;
}
/** Moves to the end of the line before the last brace. */
async function toLastMember(page) {
  await page.locator('.cm-content').focus();
  for (const key of ['Control+End', 'ArrowUp', 'ArrowUp', 'End']) await page.keyboard.press(key);
}
const wide = (page) => page.evaluate(() => document.documentElement.scrollWidth > innerWidth);

test('A DEM is dropped, a scene edited, put right and submitted; its tiles come while it bakes', async () => {
  const page = await open('submit.html');
  await page.selectOption('#example', 'first-light');
  await says(page, 'verdict', /wrong/);
  assert.match(await page.textContent('#findings'), /Line \d+.*\/terrains\/0\/dem/, 'its elevations are not there');

  await drop(page, dem);
  await says(page, 'upload-message', /coast.tif is on the server/);
  assert.match(await page.textContent('#preview-text'), /samples, [\d.]+ m apart; -?\d+ to \d+ m\.$/);
  const colours = await page.evaluate(() => {
    const canvas = document.getElementById('hillshade');
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });
  assert.ok(colours > 100, `the hillshade has ${colours} colours`);
  await says(page, 'verdict', /can be baked/);
  assert.match(await page.inputValue('#terrain-fields input'), /^sha256-[0-9a-f]{64}$/);

  await toLastMember(page);
  const line = scene.split('\n').findIndex((text) => text.includes('"bake"')) + 1;
  for (const key of ['ArrowLeft', 'Backspace']) await page.keyboard.press(key);
  await says(page, 'findings', new RegExp(`Line ${line}`));
  await page.keyboard.type('-2');
  await says(page, 'findings', new RegExp(`^Line ${line}/bake/spacing`));
  assert.equal(await page.locator('.cm-lint-marker-error').count(), 1);
  await page.click('#submit');
  await says(page, 'submit-message', /problems/);
  await says(page, 'findings', new RegExp(`^Line ${line}/bake/spacing`));
  const refused = page.problems.splice(0);
  assert.deepEqual(refused, [`422 ${server.url}/processes/bake-terrain/execution`, refused[1]]);

  await page.click('.finding');   // which goes to the place
  assert.ok(await page.evaluate(() => document.activeElement.id === 'editor'));
  await toLastMember(page);
  for (const key of ['ArrowLeft', 'Backspace', 'Backspace']) await page.keyboard.press(key);
  await page.keyboard.type('0.75');
  await says(page, 'verdict', /can be baked/);
  await page.click('#submit');
  await page.waitForSelector('#job:not([hidden])');
  await says(page, 'job-message', /Baking/);   // by server-sent events
  const id = await page.getAttribute('#job', 'data-id');
  await page.click('#job-open');
  await page.waitForFunction(() => globalThis.hoodoo?.terrain.statistics().tiles > 0);
  const { status } = await server.json(`/jobs/${id}`);
  assert.equal(status, 'running', 'tiles are on screen before the job ends');
  assert.deepEqual(page.problems, []);

  await page.click('#all-jobs');
  await page.waitForSelector(`.job a[href="./?job=${id}"]`);
  await page.goto(`${server.url}/viewer/submit.html`);
  await says(page, 'verdict', /can be baked/);
  assert.match(await textOf(page), /"spacing": 0\.75/, 'the scene was kept');
  assert.equal((await server.fetch(`/jobs/${id}`, { method: 'DELETE' })).status, 200);
  await page.end();
});

test('Marks stand at the place of an error', async () => {
  const page = await open('submit.html');
  const lines = () => page.locator('.finding .line').allTextContents();
  await write(page, '{\n"hoodoo": 1,\n"terrains": [{"id": "a", "dem": "flat.tif"}],\n"bake": {"spacing": 2},,\n"name": "x"}');
  await says(page, 'verdict', /wrong/);
  assert.deepEqual(await lines(), ['Line 4']);
  await write(page, ' ');
  await says(page, 'findings', /Line 1/);
  await write(page, '{"hoodoo": 1,\n"terrains": [\n{"id": "a", "dem": "flat.tif"},\n{"id": "a", "dem": "none.tif"}],\n"bake": {\n"spacing": "x",\n"what/~": 1}}');
  await says(page, 'findings', /spacing/);
  const findings = await page.locator('.finding').allTextContents();
  assert.ok(findings.some((text) => /^Line 6\/bake\/spacing/.test(text)), findings.join('\n'));
  assert.ok(findings.some((text) => /^Line 7\/bake\/what~1~0/.test(text)), findings.join('\n'));
  assert.ok(findings.some((text) => /^Line 4\/terrains\/1/.test(text)), findings.join('\n'));

  await write(page, '{"hoodoo": 1, "name": "x",\n"terrains": [{"id": "a", "dem": "flat.tif"}, {"id": "b", "dem": "flat.tif"}],\n"name": "y"}');
  await says(page, 'findings', /The key "name" stands here twice/);
  assert.deepEqual(await lines(), ['Line 3']);
  await page.click('#submit');
  await says(page, 'submit-message', /cannot be read/);
  await write(page, '{"hoodoo": 1,\n"terrains": [\n{"id": "a", "dem": "flat.tif"},\n{"id": "b", "dem": "none.tif"}],\n"bake": {"spacing": 2}}');

  const fields = page.locator('#terrain-fields input');   // each terrain has a field for its elevations
  assert.equal(await fields.count(), 2);
  await fields.nth(1).fill('flat.tif');
  await fields.nth(1).press('Enter');
  assert.match(await textOf(page), /\{"id": "b", "dem": "flat.tif"\}\],/);
  await page.selectOption('#target', '1');
  await page.setInputFiles('#file', dem);
  await says(page, 'upload-message', /is on the server/);
  assert.match(await textOf(page), /"dem": "flat.tif"\},\n\{"id": "b", "dem": "sha256-/, 'the file went to the chosen terrain');
  assert.deepEqual(page.problems, []);
  await page.end();
});

test('What is wrong beside the scene is said beside the button, and nothing is left of it afterwards', async () => {
  const page = await open('submit.html');
  await write(page, JSON.stringify(flat(8, 'Late')));
  await says(page, 'verdict', /can be baked/);
  await page.fill('#priority', '99');
  await page.click('#submit');
  await says(page, 'submit-message', /from -10 to 10/);
  assert.equal(await page.locator('.finding').count(), 0);
  await page.fill('#priority', '1');
  let away = true;
  await page.route('**/events', (route) => (away ? route.abort() : route.continue()));
  await page.click('#submit');
  await says(page, 'submit-message', /was taken/);
  assert.match(await page.textContent('#verdict'), /can be baked/);
  await says(page, 'job-message', /does not answer. Trying again/);
  away = false;
  await says(page, 'job-message', /Finished/);
  await page.end();
});

test('A damaged file is called so, of two the first is taken, and it waits for a scene that can be read', async () => {
  const page = await open('submit.html');
  const short = join(work, 'short.tif');
  await writeFile(short, (await readFile(dem)).subarray(0, 5000));
  await page.setInputFiles('#file', short);
  await says(page, 'preview-text', /may be damaged/);
  await says(page, 'upload-message', /on the server/);
  await write(page, '{"hoodoo": 1, "terrains": [{"id": "a", "dem": "flat.tif"}],');
  await drop(page, dem, 2);
  await says(page, 'upload-message', /Only the first file was taken.*has been put right/);
  await page.keyboard.press('Control+End');
  await page.keyboard.type('"bake": {"spacing": 8}}');
  await says(page, 'verdict', /can be baked/);
  assert.match(await textOf(page), /"dem": "sha256-/);
  assert.match(await page.textContent('#upload-message'), /taken\.$/);
  await page.end();
});

test('An example comes with its elevations', async () => {
  const page = await open('submit.html');
  await page.selectOption('#example', 'sea-cave');
  await says(page, 'upload-message', /sea-cave.tif is on the server/);
  await says(page, 'verdict', /can be baked/);
  assert.deepEqual(page.problems, []);
  await page.end();
});

test('A large DEM is sent in parts, and goes on after the line broke; another file is none', async () => {
  const file = join(work, 'large.tif');
  await writeDem(file, 1024, 3, (i, j) => 40 * Math.sin(i / 60) * Math.cos(j / 90) + (i ^ j) / 64);
  const page = await open('submit.html');
  let parts = 0;
  await page.route('**/uploads/*', (route) => (route.request().method() === 'PATCH' && ++parts === 2 ? route.abort() : route.continue()));
  await page.setInputFiles('#file', file);
  await says(page, 'upload-message', /Trying again/);
  assert.ok(Number(await page.getAttribute('#upload-progress', 'value')) > 0);
  await says(page, 'upload-message', /large.tif is on the server/);
  assert.ok(parts > 2);
  assert.match(await page.textContent('#preview-text'), /^1,024 × 1,024 samples, 3 m apart; -\d+ to \d+ m\.$/);
  const [broken, ...others] = page.problems.splice(0);
  assert.match(broken, /^console: Failed to load resource: net::ERR_FAILED/, 'the browser itself tells of the broken line');
  assert.deepEqual(others, []);

  await page.setInputFiles('#file', { name: 'notes.tif', mimeType: 'image/tiff', buffer: Buffer.from('no picture') });
  await says(page, 'upload-message', /notes.tif is no TIFF file/);
  assert.deepEqual(page.problems, []);
  await page.end();
});

test('The list of jobs shows how far each is; one is cancelled and removed, and no other', async () => {
  const kept = await server.submit(flat(8, 'Kept'));
  await server.follow(kept);
  const long = await server.submit(flat(0.05, 'Long'));
  const page = await open('jobs.html', sizes[1]);
  const row = page.locator('.job', { hasText: 'Long' }), other = page.locator('.job', { hasText: 'Kept' });
  await row.getByText(/Reading|Baking|Waiting/).waitFor();
  assert.ok(await row.locator('progress').isVisible());
  assert.equal(await other.locator('.badge').textContent(), 'successful');
  await row.getByRole('button', { name: 'Cancel Long' }).press('Enter');
  await row.locator('.badge', { hasText: 'dismissed' }).waitFor();
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute('aria-label')), 'Remove Long', 'the focus stays');
  assert.equal((await server.json(`/jobs/${long}`)).status, 'dismissed');
  assert.equal((await server.json(`/jobs/${kept}`)).status, 'successful');

  await row.getByRole('button', { name: 'Remove Long' }).click();
  await page.getByRole('button', { name: 'Keep' }).click();
  assert.ok(await row.isVisible(), 'it was kept after all');
  await row.getByRole('button', { name: 'Remove Long' }).click();
  await page.locator('#remove-dialog').getByRole('button', { name: 'Remove' }).click();
  await row.waitFor({ state: 'detached' });
  assert.equal((await server.fetch(`/jobs/${long}`)).status, 404);
  assert.ok(await other.isVisible());
  await page.selectOption('#status', 'failed');
  await page.waitForSelector('#empty:not([hidden])');
  assert.deepEqual(page.problems, []);
  await page.end();
});

test('Two jobs that are marked are shown side by side, wide and narrow', async () => {
  const jobs = [];
  for (const [spacing, name] of [[8, 'Left'], [4, 'Right'], [2, 'Third']]) jobs.push(await server.submit(flat(spacing, name)));
  for (const id of jobs) await server.follow(id);
  const cancelled = await server.submit(flat(0.05, 'Unbaked'));
  await server.fetch(`/jobs/${cancelled}`, { method: 'DELETE' });
  for (const size of sizes) {
    const page = await open('jobs.html', size);
    const mark = (name) => page.getByRole('button', { name: `Compare ${name}` });
    const marked = async () => Promise.all(['Left', 'Right', 'Third'].map((name) => mark(name).getAttribute('aria-pressed')));
    const link = page.getByRole('link', { name: 'Show side by side' });
    await mark('Left').waitFor();
    assert.equal(await mark('Unbaked').count(), 0, 'there is nothing of it to see');
    assert.ok(await page.isHidden('#pair'));
    await mark('Third').press('Enter');
    assert.match(await page.textContent('#pair-text'), /^Third of .*: mark another one/);
    assert.equal(await link.count(), 0);
    await mark('Third').click();
    assert.ok(await page.isHidden('#pair'), 'it is not marked any more');

    for (const name of ['Left', 'Third', 'Right']) await mark(name).click();
    assert.deepEqual(await marked(), ['true', 'true', 'false'], 'the third one takes the place of the second');
    await page.reload();
    await mark('Left').waitFor();
    assert.deepEqual(await marked(), ['false', 'false', 'false']);
    for (const name of ['Left', 'Right']) await mark(name).click();
    assert.match(await page.textContent('#pair-text'), /^Left of .*, and Right of /);
    assert.deepEqual(await barriers(page), [], `marked at ${size[0]}`);
    assert.equal(await wide(page), false);
    const box = await link.boundingBox();
    assert.ok(box.x >= 0 && box.x + box.width <= size[0] && box.y + box.height <= size[1], 'the bar is in sight');
    await link.click();
    await page.waitForURL(`${server.url}/viewer/?job=${jobs[0]}&with=${jobs[1]}*`);
    await settle(page);
    assert.deepEqual(await page.evaluate(() => globalThis.hoodoo.compare !== null), true);
    assert.deepEqual(page.problems, []);
    await page.end();
  }
  const page = await open('jobs.html');
  for (const name of ['Left', 'Right']) await page.getByRole('button', { name: `Compare ${name}` }).click();
  await page.getByRole('button', { name: 'Remove Left' }).click();
  await page.locator('#remove-dialog').getByRole('button', { name: 'Remove' }).click();
  await page.waitForFunction(() => /^Right of .*: mark another/.test(document.getElementById('pair-text').textContent));
  await page.getByRole('button', { name: 'Clear' }).click();
  assert.ok(await page.isHidden('#pair'));
  assert.deepEqual(page.problems, []);
  await page.end();
});

test('Jobs come page by page', async () => {
  const pages = await Server.start({ data: join(work, 'pages') });
  try {
    for (let i = 0; i < 23; ++i) {
      const body = JSON.stringify({ inputs: { echo: i } });
      const options = { method: 'POST', headers: { 'content-type': 'application/json', prefer: 'respond-async' }, body };
      assert.equal((await pages.fetch('/processes/echo/execution', options)).status, 201);
    }
    const page = await open('jobs.html', sizes[0], pages);
    await page.waitForFunction(() => document.querySelectorAll('.job').length === 20);
    await page.click('#older');
    await page.waitForFunction(() => document.querySelectorAll('.job').length === 3);
    assert.ok(await page.isDisabled('#older'));
    await page.click('#newest');
    await page.waitForFunction(() => document.querySelectorAll('.job').length === 20);
    assert.deepEqual(page.problems, []);
    await page.end();
  } finally {
    await pages.stop('SIGKILL');
  }
});

test('A service with keys asks for one, which is kept until the tab is closed', async () => {
  const keys = join(work, 'keys.json');
  const key = await makeKey(keys, 'somebody');
  const guarded = await Server.start({ data: join(work, 'guarded'), args: ['--keys', keys] });
  try {
    const page = await open('', sizes[0], guarded);
    await page.waitForSelector('#key-dialog[open]');
    await page.keyboard.press('Escape');
    await says(page, 'error-said', /needs a key/);
    await page.click('#key-button');
    await page.fill('#key', 'wrong');
    await page.keyboard.press('Enter');
    await says(page, 'key-why', /not known/);
    await page.evaluate(() => sessionStorage.clear());
    await page.goto(`${guarded.url}/viewer/jobs.html`);
    await page.waitForSelector('#key-dialog[open]');
    await page.keyboard.press('Escape');
    await says(page, 'message', /needs a key/);
    await page.click('#key-button');
    await page.fill('#key', key);
    await page.keyboard.press('Enter');
    await page.waitForSelector('#empty:not([hidden])');
    page.problems.length = 0;   // the browser tells of the refusal
    await page.goto(`${guarded.url}/viewer/submit.html`);
    await page.setInputFiles('#file', dem);
    await says(page, 'upload-message', /is on the server/);
    await page.click('#submit');
    await page.waitForSelector('#job:not([hidden])');
    await page.goto(`${guarded.url}/viewer/`);
    await page.waitForSelector('#jobs a');
    assert.deepEqual(page.problems, []);
    assert.deepEqual(await page.evaluate(() => Object.keys(localStorage)), []);
    await page.end();
    const other = await open('jobs.html', sizes[0], guarded);
    await other.waitForSelector('#key-dialog[open]');
    await other.end();
  } finally {
    await guarded.stop('SIGKILL');
  }
});

test('axe-core finds nothing serious on any page, wide or narrow, and all of it fits', async () => {
  const id = await server.submit(flat(8, 'Seen'));
  await server.follow(id);
  for (const size of sizes) {
    const page = await open('submit.html', size);
    await page.setInputFiles('#file', dem);
    await says(page, 'upload-message', /is on the server/);
    await toLastMember(page);
    await page.keyboard.type(',"bake": 7');   // stands twice, and is no object
    await says(page, 'findings', /Line/);
    assert.deepEqual(await barriers(page), [], `submission at ${size[0]}`);
    assert.equal(await wide(page), false);
    for (const path of ['jobs.html', `?job=${id}`]) {
      await page.goto(`${server.url}/viewer/${path}`);
      if (path === 'jobs.html') await page.waitForSelector('.job');
      else await settle(page);
      assert.deepEqual(await barriers(page), [], `${path} at ${size[0]}`);
      assert.equal(await wide(page), false);
    }
    await page.goto(`${server.url}/viewer/jobs.html`);
    await page.getByRole('button', { name: 'Remove Seen' }).click();
    assert.deepEqual(await barriers(page), [], `dialog at ${size[0]}`);
    assert.deepEqual(page.problems, []);
    await page.end();
  }
});

test('All of it is reached by keyboard', async () => {
  const page = await open('submit.html');
  await says(page, 'verdict', /wrong|baked/);
  const seen = [];
  for (let i = 0; i < 20; ++i) {
    await page.keyboard.press('Tab');
    seen.push(await page.evaluate(() => document.activeElement.id || document.activeElement.className));
  }
  const wanted = ['brand', 'key-button', 'file', 'example', 'editor', 'finding', 'submit', 'priority'];
  const order = wanted.map((name) => seen.indexOf(name));
  assert.ok(order.every((at, i) => at >= 0 && (i === 0 || at > order[i - 1])), `${wanted} in ${seen}`);
  await page.end();
});

/** The viewer's tools and dialogs, each while it is open, for those who use it by a screen reader, by keyboard or in strong light. */
import assert from 'node:assert/strict';
import { mkdir } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { barriers } from './barriers.mjs';
import { launch, openPage, settle } from './browser.mjs';
import { writeDem } from './dem.mjs';
import { makeFolder, makeKey, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const sizes = [[1280, 800], [400, 800]];
const side = 64;   // m
let work, server, browser, first, second;

/** Flat land of two materials, with a ball of so many metres on it. */
const scene = (radius) => ({
  hoodoo: 1, name: `A ball of ${radius} m`, materials: [{ name: 'rock', color: '#9a8877' }, { name: 'ore', color: '#3366cc' }],
  terrains: [{ id: 'land', dem: 'flat.tif' }],
  operations: [{ id: 'ball', op: 'union', material: 'ore', tree: { type: 'sphere', center: [side / 2, side / 2, 10], radius } }],
  bake: { spacing: 2 },
});

before(async () => {
  work = await makeFolder();
  const root = join(work, 'root');
  await mkdir(root);
  await writeDem(join(root, 'flat.tif'), side / 2, 2, () => 10);
  server = await Server.start({ data: join(work, 'data'), roots: [root] });
  [browser, first, second] = await Promise.all([launch(), server.submit(scene(8)), server.submit(scene(10))]);
  for (const id of [first, second]) assert.equal((await server.follow(id)).at(-1).status, 'successful');
});
after(async () => {
  await browser?.close();
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

const seen = (page, selector) => page.waitForSelector(`${selector}:not([hidden])`);
const pick = async (page, times = 1) => {
  await page.locator('#view').focus();
  for (let i = 0; i < times; ++i) {
    if (i > 0) await page.keyboard.press('ArrowLeft');
    await settle(page);
    await page.keyboard.press('Enter');   // the point in the middle
  }
};
/** What opens each, as somebody at a keyboard does. */
const cards = {
  async inspect(page) {
    await page.keyboard.press('KeyI');
    await pick(page);
    await page.waitForFunction(() => globalThis.hoodoo.tools.inspector.found?.complete);
    await page.waitForSelector('#inspect-card .swatch');
  },
  async measure(page) {
    await page.keyboard.press('KeyM');
    await pick(page, 2);
    await page.waitForSelector('#measure-card dd');
  },
  async section(page) {
    await page.keyboard.press('KeyC');
    await seen(page, '#section-card');
  },
  async share(page) {
    await page.keyboard.press('KeyP');
    await page.waitForFunction(() => document.querySelector('#share-card [role=status]').textContent);
  },
  async help(page) {
    await page.keyboard.press('?');
    await page.waitForSelector('#help[open]');
  },
};

for (const size of sizes) {
  const open = async (query) => {
    const page = await openPage(browser, server.url, size);
    await page.goto(`${server.url}/viewer/?job=${first}${query}`);
    await settle(page);
    return page;
  };

  for (const [name, show] of Object.entries(cards)) {
    test(`axe-core finds nothing serious with ${name} open, ${size[0]} pixels wide`, async () => {
      const page = await open('');
      await show(page);
      assert.deepEqual(await barriers(page), []);
      assert.deepEqual(page.problems, []);
      await page.end();
    });
  }

  test(`axe-core finds nothing serious in a comparison, folded and open, with all cards, ${size[0]} pixels wide`, async () => {
    const page = await open(`&with=${second}`);
    await page.waitForFunction(() => globalThis.hoodoo.compare.rows?.length > 0);
    for (const folded of [true, false]) {
      await page.evaluate((state) => { document.getElementById('compare-card').open = !state; }, folded);
      assert.equal(await page.isVisible('#compare-card table'), !folded);
      assert.deepEqual(await barriers(page), [], folded ? 'folded' : 'open');
    }
    for (const name of ['inspect', 'section', 'share']) await cards[name](page);
    assert.deepEqual(await barriers(page), [], 'with all cards');
    assert.deepEqual(page.problems, []);
    await page.end();
  });

  test(`axe-core finds nothing serious in what is said of errors and asked for, ${size[0]} pixels wide`, async () => {
    const keys = join(work, `keys-${size[0]}.json`);
    await makeKey(keys, 'somebody');
    const guarded = await Server.start({ data: join(work, `guarded-${size[0]}`), args: ['--keys', keys] });
    try {
      const page = await openPage(browser, guarded.url, size);
      await page.goto(`${guarded.url}/viewer/`);
      await page.waitForSelector('#key-dialog[open]');
      assert.deepEqual(await barriers(page), [], 'asked for a key');
      await page.keyboard.press('Escape');
      await seen(page, '#error-box');
      assert.deepEqual(await barriers(page), [], 'an error');
      await page.end();
    } finally {
      await guarded.stop('SIGKILL');
    }
  });
}

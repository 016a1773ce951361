/**
 * Takes a picture of a tileset or a scene in the viewer, as those in README.md and schema/examples/README.md:
 *
 *     node picture.mjs DIR|SCENE.json OUT.png 'cam=-60,60,150&at=330,430,30' [WIDTH HEIGHT]
 *
 * A scene is baked into a folder that is gone afterwards. The view is what the viewer shows behind the # of its address.
 */
import { launch, openPage, serveFolders, settle } from './browser.mjs';
import { hoodoo, withFolder } from './hoodoo.mjs';

const [source, file, view = '', width = '1280', height = '640'] = process.argv.slice(2);

async function takePicture(folder) {
  const server = await serveFolders({ '/tileset/': folder });
  const browser = await launch();
  try {
    const page = await openPage(browser, server.url, [Number(width), Number(height)]);
    await page.goto(`${server.url}/viewer/?tileset=/tileset/tileset.json&noui&err=1#${view}`);
    await settle(page);
    await page.screenshot({ path: file });
    if (page.problems.length > 0) throw new Error(page.problems.join('\n'));
  } finally {
    await browser.close();
    await server.close();
  }
}

if (source.endsWith('.json')) {
  await withFolder(async (folder) => {
    const baked = await hoodoo(['bake', source, '-o', folder]);
    if (baked.code !== 0) throw new Error(baked.stderr);
    await takePicture(folder);
  });
} else {
  await takePicture(source);
}

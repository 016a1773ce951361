/**
 * Takes a picture of a tileset in the viewer, as the one in README.md:
 *
 *     node picture.mjs DIR OUT.png 'cam=-60,60,150&at=330,430,30' [WIDTH HEIGHT]
 *
 * The view is what the viewer shows behind the # of its address.
 */
import { launch, openPage, serveFolders, settle } from './browser.mjs';

const [folder, file, view = '', width = '1280', height = '640'] = process.argv.slice(2);
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

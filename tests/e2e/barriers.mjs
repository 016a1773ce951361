/** What keeps people out of a page, in the eyes of axe-core. */
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';

const axe = await readFile(join(import.meta.dirname, 'node_modules/axe-core/axe.min.js'), 'utf8');

/** The serious and critical findings: ["rule: elements"]. */
export async function barriers(page) {
  if (!await page.evaluate(() => 'axe' in globalThis)) await page.evaluate(`${axe};0`);
  const { violations } = await page.evaluate(() => globalThis.axe.run());
  return violations.filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target).join()}`);
}

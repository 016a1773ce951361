/** What somebody does on the page of submission. */
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { basename } from 'node:path';

/** Waits until the element of an id says what the pattern says. */
export const says = (page, id, pattern) => page.waitForFunction(
  ([name, source]) => new RegExp(source).test(document.getElementById(name).textContent), [id, pattern.source]);

/** Writes the scene anew. */
export async function write(page, text) {
  await page.locator('.cm-content').focus();
  await page.keyboard.press('Control+A');
  await page.keyboard.insertText(text);
}
/** The text of the editor, whose lines are elements. */
export const textOf = (page) => page.locator('.cm-content').evaluate((content) => [...content.querySelectorAll('.cm-line')].map((line) => line.textContent).join('\n'));

/** Drops a file, `count` times, as from a file manager. */
export async function drop(page, file, count = 1) {
  const bytes = (await readFile(file)).toString('base64');
  const transfer = await page.evaluateHandle(async ([text, name, times]) => {
    const data = new DataTransfer();
    for (let i = 0; i < times; ++i) {
      data.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name, { type: 'image/tiff' }));
    }
    return data;
  }, [bytes, basename(file), count]);
  await page.dispatchEvent('#drop', 'dragenter', { dataTransfer: transfer });
  assert.ok(await page.locator('#drop.over').count(), 'the zone shows that it takes the file');
  await page.dispatchEvent('#drop', 'drop', { dataTransfer: transfer });
}

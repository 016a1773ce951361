/** server/README.md: its recipes do what they promise, and it leaves no option or request of the service out. */
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { delimiter, dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { command, hoodoo, makeFolder, removeFolder } from './hoodoo.mjs';
import { freePort } from './server.mjs';

const page = await readFile(join(import.meta.dirname, '../../server/README.md'), 'utf8');
const recipes = page.slice(page.indexOf('\n## Recipes'), page.indexOf('\n## The requests'));
const limit = 300_000;   // [ms]
const mark = (i) => `=== block ${i} ended with`;

/** Each block of shell with the heading it stands under and what is expected to be printed. */
function blocks() {
  const found = [];
  for (const section of recipes.split('\n### ').slice(1)) {
    const title = section.slice(0, section.indexOf('\n'));
    for (const [, code, next] of section.matchAll(/```sh\n(.*?)```\n\n([^\n]*)/gs)) {
      const expected = next.startsWith('Expect ') ? [...next.matchAll(/`([^`]+)`/g)].map(([, text]) => text) : [];
      found.push({ title, code, expected });
    }
  }
  return found;
}

/** What the blocks print, each its own, run by one bash as if they were pasted; and with which code each of them ends. */
async function paste(all, cwd) {
  const script = ['exec 2>&1', ...all.map(({ code }, i) => `${code}printf '\n${mark(i)} %s\n' "$?"`)].join('\n');
  const env = { ...process.env, HOODOO: `http://127.0.0.1:${await freePort()}`, PATH: `${dirname(command)}${delimiter}${process.env.PATH}` };
  // A group of its own, so that the service ends with it however it goes.
  const bash = spawn('bash', ['-c', script], { cwd, env, detached: true, stdio: ['ignore', 'pipe', 'inherit'] });
  const end = () => { try { process.kill(-bash.pid, 'SIGKILL'); } catch { /* all of it has ended */ } };
  const timer = setTimeout(end, limit);
  let printed = '';
  for await (const piece of bash.stdout.setEncoding('utf8')) printed += piece;
  clearTimeout(timer);
  end();
  return all.map((_, i) => {
    const from = i === 0 ? 0 : printed.indexOf('\n', printed.indexOf(mark(i - 1))) + 1, to = printed.indexOf(mark(i));
    if (to < 0) return { text: printed.slice(from), code: null };
    return { text: printed.slice(from, to), code: Number(/\d+/.exec(printed.slice(to + mark(i).length))[0]) };
  });
}

/** Those of `wanted` that are not in the text; white space counts as one blank. */
function missing(text, wanted) {
  const plain = text.replace(/\s+/g, ' ');
  return wanted.filter((one) => !plain.includes(one));
}

let work;
const outcomes = [];
before(async () => {
  work = await makeFolder();
  outcomes.push(...await paste(blocks(), work));
});
after(() => removeFolder(work));

for (const [i, { title, code, expected }] of blocks().entries()) {
  test(`${title}, block ${i + 1}, prints what the page says`, () => {
    const { text, code: ended } = outcomes[i];
    assert.ok(expected.length > 0, `the page does not say what to expect of ${code}`);
    assert.equal(ended, 0, `${code}\nprinted\n${text}`);
    assert.deepEqual(missing(text, expected), [], `${code}\nprinted\n${text}`);
  });
}

test('The page has a recipe for all that clients do', () => {
  const all = blocks().map(({ code }) => code).join('');
  for (const what of ['validate-scene', 'bake-terrain', 'analyze-dem', 'diff-tilesets', 'Idempotency-Key', 'Last-Event-ID', 'Prefer: wait', 'If-None-Match', '-r 0-3', '/uploads', '/assets',
                      '-X DELETE', '/events', '/results', 'hoodoo key', '/metrics', '/readyz']) assert.ok(all.includes(what), what);
});

test('Links of the page and of the front page lead to what is there', async () => {
  const top = join(import.meta.dirname, '../..');
  for (const name of ['README.md', 'server/README.md', 'client/README.md']) {
    const text = await readFile(join(top, name), 'utf8');
    const headings = new Set([...text.matchAll(/^#+ (.*)$/gm)].map(([, title]) => `#${title.toLowerCase().replace(/[^\w -]/g, '').replaceAll(' ', '-')}`));
    for (const [, target] of text.matchAll(/\]\((?!https?:)([^)]+)\)/g)) {
      assert.ok(target.startsWith('#') ? headings.has(target) : existsSync(join(top, dirname(name), target)), `${name} leads to ${target}`);
    }
  }
});

test('The page tells of every option of hoodoo serve and hoodoo key, and of no other', async () => {
  const optionsOf = (text) => new Set(text.match(/--[a-z]+(-[a-z]+)*/g));
  for (const name of ['serve', 'key']) {
    const known = optionsOf((await hoodoo([name, '--help'])).stdout);
    known.delete('--help');
    const told = optionsOf(page);
    for (const option of known) assert.ok(told.has(option), `${option} of hoodoo ${name}`);
    for (const [row, of] of page.matchAll(/^\| option of `hoodoo (\w+)`.*?\n\n/gms)) {
      if (of === name) for (const option of optionsOf(row)) if (option !== '---') assert.ok(known.has(option), `hoodoo ${name} has no ${option}`);
    }
  }
});

test('The page tells of every path of the service', async () => {
  const table = /## The requests\n\n(.*?)\n\n/s.exec(page)[1].replaceAll(/\b(ID|NAME|FILE|sha256-HEX)\b/g, '*');
  const told = new Set([...table.matchAll(/\/[\w/*]*/g)].map(([path]) => path));
  const paths = await readFile(join(import.meta.dirname, '../../client/src/api.ts'), 'utf8');   // held to the service by client.test.mjs
  const served = [...paths.matchAll(/^ {4}"(\/[^"]*)": \{/gm)].map(([, path]) => path.replaceAll(/\{\w+\}/g, '*'));
  assert.ok(served.length > 15);
  for (const path of served) assert.ok(told.has(path), `${path} of ${[...told].join(' ')}`);
});

/** What `deploy/` gives to those who run the server, in the eyes of the tools that will read it. */
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { command, example, hoodoo, run as runProgram, withFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const run = promisify(execFile);
const unit = new URL('../../deploy/hoodoo.service', import.meta.url);

test('The options of the systemd unit are options of hoodoo serve', async () => {
  const line = /^ExecStart=(.*)$/m.exec(await readFile(unit, 'utf8'))[1];
  const help = (await hoodoo(['serve', '--help'])).stdout;
  const options = line.match(/--[a-z-]+/g);
  assert.ok(options.length > 3);
  for (const option of options) assert.ok(help.includes(option), option);
});

test('systemd finds no fault with the unit, and little that it could do without', async (t) => {
  const missing = await run('systemd-analyze', ['--version']).then(() => false, () => true);
  if (missing) return t.skip('systemd-analyze is not installed');
  await withFolder(async (folder) => {
    const file = join(folder, 'hoodoo.service');
    await writeFile(file, (await readFile(unit, 'utf8')).replace('/usr/local/bin/hoodoo', command));
    const { stderr } = await run('systemd-analyze', ['verify', file]);
    assert.equal(stderr, '');
    await run('systemd-analyze', ['security', '--offline=yes', '--threshold=15', file]);
  });
});

test('The script for CI bakes a scene as it is and as it was, and tells whether they differ', () => withFolder(async (work) => {
  const root = join(work, 'root'), keys = join(work, 'keys.json'), out = join(work, 'out');
  await mkdir(root);
  assert.equal((await hoodoo(['synthesize', join(root, 'dem.tif')])).code, 0);
  const key = (await hoodoo(['key', keys, 'ci', '--scopes', 'submit'])).stdout.trim();
  const scene = JSON.parse(await readFile(join(example, 'scene.json'), 'utf8'));
  const files = { now: scene, before: { ...scene, bake: { ...scene.bake, spacing: 4 } }, broken: { ...scene, seed: 'x' } };
  for (const [name, value] of Object.entries(files)) await writeFile(join(work, `${name}.json`), JSON.stringify(value));
  const server = await Server.start({ data: join(work, 'data'), roots: [root], args: ['--keys', keys] });
  try {
    const script = new URL('../../deploy/ci/bake-and-diff.sh', import.meta.url).pathname;
    const compare = (first, second, env = {}) => runProgram(script, [`${work}/${first}.json`, `${work}/${second}.json`, out],
                                                           { env: { HOODOO_URL: server.url, HOODOO_KEY: key, ...env } });
    const same = await compare('now', 'now');
    assert.equal(same.code, 0, same.stderr);
    assert.equal(JSON.parse(await readFile(join(out, 'report.json'), 'utf8')).same, true);
    const differs = await compare('now', 'before');
    assert.equal(differs.code, 1, differs.stderr);
    assert.match(await readFile(join(out, 'diff.html'), 'utf8'), /<html/);
    const broken = await compare('broken', 'now');
    assert.equal(broken.code, 2);
    assert.match(broken.stderr, /\/seed/);
    assert.equal((await compare('now', 'now', { HOODOO_KEY: 'hoodoo_wrong' })).code, 2);
  } finally {
    await server.stop();
  }
}));

/** What `deploy/` gives to those who run the server, in the eyes of the tools that will read it. */
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { command, hoodoo, withFolder } from './hoodoo.mjs';

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

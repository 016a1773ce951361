/** Every hostile TIFF given to the command ends in time and memory with an exit code that says what it was. */
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { readdir, writeFile } from 'node:fs/promises';
import { basename, join } from 'node:path';
import { test } from 'node:test';
import { hoodoo, testData, withFolder } from './hoodoo.mjs';

const folder = join(testData, 'hostile_tiff');
const lanes = 2;
// A sanitizer has its own shadow memory and pace.
const bars = process.env.HOODOO_SANITIZED ? { seconds: 600, mebibytes: Infinity } : { seconds: 10, mebibytes: 512 };

const uses = {
  info: (file) => ['info', file],
  bake: async (file, work) => {
    const scene = join(work, 'scene.json');
    await writeFile(scene, JSON.stringify({ hoodoo: 1, terrains: [{ id: 'land', dem: file }] }));
    return ['bake', scene, '-o', join(work, 'out')];
  },
};

/** What is wrong with a run, or nothing. */
function complaint(file, result) {
  if (result.overtime || result.busy > bars.seconds) return `runs for ${result.seconds.toFixed(1)} s`;
  if (result.signal) return `ended by ${result.signal}`;
  if (![0, 2, 3, 4].includes(result.code)) return `exit ${result.code}: ${result.stderr.slice(-2000)}`;
  if (result.code !== 0 && !result.stderr.includes(basename(file))) return `does not name the file: ${result.stderr.slice(0, 300)}`;
  if (result.peak > bars.mebibytes) return `took ${result.peak.toFixed(0)} MiB`;
  return null;
}

for (const [use, argumentsFor] of Object.entries(uses)) {
  test(`hoodoo ${use} ends every hostile TIFF in under ${bars.seconds} s and ${bars.mebibytes} MiB with exit 0, 2, 3 or 4`, async (t) => {
    if (!existsSync(folder)) {
      t.skip(`${folder} is absent: set HOODOO_TEST_DATA`);
      return;
    }
    const files = (await readdir(folder, { recursive: true, withFileTypes: true }))
      .filter((entry) => entry.isFile()).map((entry) => join(entry.parentPath, entry.name)).sort();
    assert.ok(files.length > 100);
    const complaints = [], codes = {};
    let slowest = { busy: 0 }, largest = { peak: 0 };
    const waiting = [...files];
    const lane = async () => {
      for (let file; (file = waiting.shift());) {
        await withFolder(async (work) => {
          const result = await hoodoo(await argumentsFor(file, work), { limit: 6 * 1000 * bars.seconds });
          const what = complaint(file, result);
          if (what) complaints.push(`${file}: ${what}`);
          codes[result.code] = (codes[result.code] ?? 0) + 1;
          if (result.busy > slowest.busy) slowest = { file, ...result };
          if (result.peak > largest.peak) largest = { file, ...result };
        });
      }
    };
    await Promise.all(Array.from({ length: lanes }, lane));
    t.diagnostic(`${files.length} files, exits ${JSON.stringify(codes)}; slowest ${basename(slowest.file)} ` +
                 `${slowest.busy.toFixed(2)} s; largest ${basename(largest.file)} ${largest.peak.toFixed(0)} MiB`);
    assert.deepEqual(complaints, []);
  });
}

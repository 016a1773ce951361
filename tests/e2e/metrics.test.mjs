/** Prometheus' own tool reads the figures of a server that has baked. */
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { join } from 'node:path';
import { test } from 'node:test';
import { exampleScene, makeRoot, run, withFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const env = { ...process.env, PATH: `${process.env.PATH}:/usr/local/sbin` };

/** {code, said} of promtool given a text. */
function promtool(text) {
  return new Promise((resolve, reject) => {
    const child = spawn('promtool', ['check', 'metrics'], { env, stdio: ['pipe', 'pipe', 'pipe'] });
    let said = '';
    for (const stream of [child.stdout, child.stderr]) stream.setEncoding('utf8').on('data', (piece) => { said += piece; });
    child.on('error', reject).on('close', (code) => resolve({ code, said }));
    child.stdin.end(text);
  });
}

test('promtool finds no fault with /metrics after a bake', async (t) => {
  const missing = await run('promtool', ['--version'], { env }).then(({ code }) => code !== 0, () => true);
  if (missing) return t.skip('promtool is not there: deploy/setup.sh takes it out of the Debian package prometheus');
  await withFolder(async (work) => {
    const root = await makeRoot(work);
    const scene = await exampleScene();
    const server = await Server.start({ data: join(work, 'data'), roots: [root] });
    try {
      const id = await server.submit({ ...scene, bake: { ...scene.bake, spacing: 8 } });
      assert.equal((await server.follow(id)).at(-1).status, 'successful');
      await server.fetch('/nothing');
      const text = await (await server.fetch('/metrics')).text();
      assert.match(text, /hoodoo_jobs\{status="successful"\} 1/);
      assert.deepEqual(await promtool(text), { code: 0, said: '' });
      assert.notEqual((await promtool(text.replaceAll('hoodoo_jobs{', 'hoodoo_jobs_total{').replaceAll('hoodoo_jobs ', 'hoodoo_jobs_total '))).code, 0, 'it sees a fault');
    } finally {
      await server.stop();
    }
  });
});

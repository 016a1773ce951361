/** 421 scenes made wrong from the examples and from every node type: each is answered, by 200, 400, 413 or 422, with pointers into it. */
import assert from 'node:assert/strict';
import { readFile, readdir } from 'node:fs/promises';
import { join, resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { examples, makeFolder, makeRoot, removeFolder, seededRandom } from './hoodoo.mjs';
import { mutate } from './mutate.mjs';
import { Memory, assertWell } from './raw.mjs';
import { Server } from './server.mjs';

const count = process.env.HOODOO_SANITIZED ? 60 : 421;
const lanes = 4;
let work, server, memory, good;

/** Scenes that are right: the examples, and one for each node type of the reference pages, in an operation or as a geology. */
async function scenes() {
  const found = await Promise.all(examples().map(async (folder) => JSON.parse(await readFile(join(folder, 'scene.json'), 'utf8'))));
  const nodes = resolve(import.meta.dirname, '../../schema/nodes');
  for (const name of (await readdir(nodes)).filter((one) => one.endsWith('.json')).sort()) {
    const node = JSON.parse(await readFile(join(nodes, name), 'utf8'));
    const base = { hoodoo: 1, terrains: [{ dem: 'dem.tif' }] };
    const wholes = node.hoodoo ? [node] : [{ ...base, operations: [{ op: 'union', tree: node }] }, { ...base, geology: node }];
    const tried = await Promise.all(wholes.map(async (scene) => (await validate(JSON.stringify({ inputs: { scene } }))).json()));
    found.push(wholes[Math.max(0, tried.findIndex(({ valid }) => valid))]);
  }
  return found;
}

before(async () => {
  work = await makeFolder();
  const root = await makeRoot(work);
  server = await Server.start({ data: join(work, 'data'), roots: [root] });
  for (let i = 0; i < 20; ++i) await (await server.fetch('/api')).text();
  memory = new Memory(server.child.pid);
  good = await scenes();
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

/** Whether `pointer` leads to a value of `document`, or to what is missing from one. */
function leads(document, pointer) {
  if (pointer === '') return true;
  if (!pointer.startsWith('/')) return false;
  let value = document;
  const tokens = pointer.slice(1).split('/').map((token) => token.replaceAll('~1', '/').replaceAll('~0', '~'));
  for (const [i, token] of tokens.entries()) {
    if (value === null || typeof value !== 'object') return false;
    const last = i === tokens.length - 1;
    if (!Object.hasOwn(value, token)) return last;
    value = value[token];
  }
  return true;
}

const validate = (body) => server.fetch('/processes/validate-scene/execution', { method: 'POST', headers: { 'content-type': 'application/json', connection: 'close' }, body });

/** What is wrong with the answer to one scene, or nothing; counts the statuses. */
async function complaint(scene, statuses) {
  const response = await validate(JSON.stringify({ inputs: { scene } }));
  const text = await response.text(), { status } = response;
  statuses[status] = (statuses[status] ?? 0) + 1;
  if (![200, 400, 413, 422].includes(status)) return `answers ${status}: ${text.slice(0, 300)}`;
  if (text.includes(work)) return `names a folder of the server: ${text.slice(0, 300)}`;
  if (/root:.*:0:0/.test(text)) return 'gives away a file';
  const answer = JSON.parse(text);
  if (status === 200 && answer.valid !== (answer.problems.length === 0)) return 'is good and bad';
  if (answer.valid) statuses.valid = (statuses.valid ?? 0) + 1;
  const [problems, document] = status === 200 ? [answer.problems, scene] : [answer.errors ?? [], { inputs: { scene } }];
  if ([400, 422].includes(status) && problems.length === 0) return `is refused without a reason: ${text.slice(0, 300)}`;
  for (const { pointer, detail } of problems) {
    if (!detail) return `has a problem without words at ${pointer}`;
    if (!leads(document, pointer)) return `has a problem at ${pointer}, which leads nowhere: ${detail}`;
  }
  return null;
}

test(`${count} mutated scenes are answered, each problem with a pointer that leads into the scene`, async (t) => {
  const seed = Number(process.env.HOODOO_SEED ?? 6), random = seededRandom(seed);
  const waiting = Array.from({ length: count }, (_, i) => ({ i, ...mutate(good[i % good.length], random) }));
  const complaints = [], statuses = {};
  const lane = async () => {
    for (let one; (one = waiting.shift());) {
      const what = await complaint(one.scene, statuses);
      if (what) complaints.push(`${one.i} (${one.how}): ${what}`);
    }
  };
  await Promise.all(Array.from({ length: lanes }, lane));
  t.diagnostic(`seed ${seed}, of ${good.length} scenes; ${JSON.stringify(statuses)}; grown by ${memory.growth().toFixed(1)} MiB`);
  assert.deepEqual(complaints, []);
  assert.ok((statuses.valid ?? 0) < count / 2, 'most of them are wrong');
  await assertWell(server, memory);
});

test('The scenes they are made of are good, but for files that are not here', async () => {
  for (const scene of good) {
    const { valid, problems } = await (await validate(JSON.stringify({ inputs: { scene } }))).json();
    const others = problems?.filter(({ detail }) => !/file|is not there|cannot be|no such/i.test(detail)) ?? [];
    assert.ok(valid || others.length === 0, JSON.stringify([scene.name, others]).slice(0, 600));
  }
});

/** The API as its own OpenAPI document and OGC API - Processes 1.0 describe it. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Contract } from './contract.mjs';
import { exampleScene, makeFolder, makeRoot, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const ogc = 'http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/';
let work, root, server, scene, contract, ask;

before(async () => {
  work = await makeFolder();
  root = await makeRoot(work);
  scene = await exampleScene();
  server = await Server.start({ data: join(work, 'data'), roots: [root] });
  contract = new Contract(await server.json('/api'));
  ask = contract.of(server);
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

const get = async (path, headers) => (await ask(path, { headers })).json();
function execute(process, body, headers = {}) {
  return ask(`/processes/${process}/execution`, {
    method: 'POST', body: JSON.stringify(body), headers: { 'content-type': 'application/json', ...headers },
  });
}
/** Posts what must become a job; gives its id once it has ended well. */
async function finished(process, inputs, more = {}, headers = {}) {
  const response = await execute(process, { inputs, ...more }, headers);
  assert.equal(response.status, 201, await response.clone().text());
  const { jobID } = await response.json();
  const last = (await server.follow(jobID)).at(-1);
  assert.equal(last.status, 'successful', JSON.stringify(last));
  return jobID;
}
/** Answers 400 with these pointers. */
async function refused(process, body, ...pointers) {
  const response = await execute(process, body);
  const problem = await response.json();
  assert.equal(response.status, 400, JSON.stringify([body, problem]));
  assert.deepEqual(problem.errors.map(({ pointer }) => pointer).sort(), pointers.sort(), JSON.stringify(problem));
}

test('The landing page leads to everything by absolute links', async () => {
  const { links } = await get('/');
  for (const { href, rel } of links) {
    assert.ok(href.startsWith(server.url), href);
    assert.equal((await fetch(href)).status, 200, `${rel} ${href}`);
  }
  for (const rel of ['self', 'service-desc', 'http://www.opengis.net/def/rel/ogc/1.0/conformance',
                     'http://www.opengis.net/def/rel/ogc/1.0/processes',
                     'http://www.opengis.net/def/rel/ogc/1.0/job-list']) {
    assert.ok(links.some((link) => link.rel === rel), rel);
  }
  const { conformsTo } = await get('/conformance');
  for (const name of ['core', 'json', 'oas30', 'job-list', 'dismiss', 'ogc-process-description']) {
    assert.ok(conformsTo.includes(`http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/${name}`), name);
  }
});

test('Every process that is listed describes itself', async () => {
  const { processes } = await get('/processes');
  assert.deepEqual(processes.map(({ id }) => id).sort(),
                   ['analyze-dem', 'bake-terrain', 'diff-tilesets', 'echo', 'validate-scene']);
  for (const { id, jobControlOptions } of processes) {
    const full = await get(`/processes/${id}`);
    assert.equal(full.id, id);
    assert.deepEqual(full.jobControlOptions, jobControlOptions);
    assert.ok(Object.keys(full.inputs).length > 0 && Object.keys(full.outputs).length > 0);
  }
  assert.equal((await get('/processes/nothing')).type, `${ogc}no-such-process`);
  assert.equal((await (await execute('nothing', {})).json()).type, `${ogc}no-such-process`);
});

test('echo gives back any JSON, at once or as a job', async () => {
  for (const value of ['text', 1.5, null, true, [1, [2]], { a: { b: [] } }, 'caf\u00e9 \u{1f3d4}']) {
    const answer = await execute('echo', { inputs: { echo: value } });
    assert.equal(answer.status, 200);
    assert.deepEqual(await answer.json(), { echo: value });
    const raw = await execute('echo', { inputs: { echo: value }, response: 'raw' });
    assert.deepEqual(await raw.json(), value);
  }
  const id = await finished('echo', { echo: { a: 1 }, pause: 0.2 }, {}, { prefer: 'respond-async' });
  assert.deepEqual(await get(`/jobs/${id}/results`), { echo: { a: 1 } });
  const start = performance.now();
  await execute('echo', { inputs: { echo: 1, pause: 0.3 } });
  assert.ok(performance.now() - start >= 300);
});

test('What a job echoes is kept, and so it is not large', async () => {
  const async = { prefer: 'respond-async' }, room = 64 * 1024 - 2;
  const id = await finished('echo', { echo: 'x'.repeat(room) }, {}, async);
  assert.deepEqual(await get(`/jobs/${id}/results/echo`), 'x'.repeat(room));
  const refusal = await execute('echo', { inputs: { echo: 'x'.repeat(room + 1) } }, async);
  assert.equal(refusal.status, 413);
  assert.deepEqual((await refusal.json()).errors,
                   [{ pointer: '/inputs/echo', detail: 'must be of at most 65536 bytes as JSON in a job, got 65537; without respond-async it may be larger' }]);
  assert.equal((await execute('echo', { inputs: { echo: 'x'.repeat(room + 1) } })).status, 200);
  await ask(`/jobs/${id}`, { method: 'DELETE' });
});

test('An execution that is none is refused with every pointer', async () => {
  await refused('echo', {}, '/inputs');
  await refused('echo', { inputs: [] }, '/inputs');
  await refused('echo', { inputs: {} }, '/inputs/echo');
  await refused('echo', { inputs: { more: 1, 'a/b': 2 } }, '/inputs/more', '/inputs/a~1b', '/inputs/echo');
  await refused('echo', { inputs: { echo: 1, pause: 11 } }, '/inputs/pause');
  await refused('echo', { inputs: { echo: 1 }, response: 'xml' }, '/response');
  await refused('echo', { inputs: { echo: 1 }, subscriber: { successUri: 'http://127.0.0.1/' } }, '/subscriber');
  await refused('bake-terrain', { inputs: { scene }, response: 'raw' }, '/response');
  await refused('bake-terrain', { inputs: { scene: 1 } }, '/inputs/scene');
  await refused('analyze-dem', { inputs: { routing: 'x' } }, '/inputs/dem');
  await refused('analyze-dem', { inputs: { dem: 'dem.tif', routing: 'x' } }, '/inputs/routing');
  await refused('analyze-dem', { inputs: { dem: 'dem.tif' }, outputs: { bogus: {}, fill: 1, area: { transmissionMode: 'value' } } },
                '/outputs/bogus', '/outputs/fill', '/outputs/area/transmissionMode');
  await refused('bake-terrain', { inputs: { scene }, outputs: { tiles: {} } }, '/outputs/tiles');
  await refused('echo', { inputs: { echo: 1 }, outputs: { echo: { transmissionMode: 'reference' } } }, '/outputs/echo/transmissionMode');
  await refused('validate-scene', { inputs: { scene }, outputs: [] }, '/outputs');
  await refused('echo', { inputs: { echo: 1 }, priorty: 1, 'a/b': 2, processID: 'bake-terrain' }, '/priorty', '/a~1b', '/processID');
  for (const processID of ['echo', `${server.url}/processes/echo`]) {
    assert.equal((await execute('echo', { inputs: { echo: 1 }, processID })).status, 200);
  }
  await refused('diff-tilesets', { inputs: { first: 'x', second: 'y' } }, '/inputs/first');
});

test('References lead to files of this server alone', async () => {
  const hrefs = ['http://127.0.0.1:1/dem.tif', 'https://example.org/dem.tif', 'ftp://a/b', 'file:../secret', 'file:///etc/passwd',
                 'file:/etc/passwd', 'file:nothing.tif', 'file:', `${server.url}/assets/../jobs.db`, 'vsicurl/http://a', 5];
  for (const href of hrefs) {
    await refused('analyze-dem', { inputs: { dem: { href } } }, '/inputs/dem/href');
    await refused('bake-terrain', { inputs: { scene: { href } } }, '/inputs/scene/href');
  }
});

test('A scene may come by reference', async () => {
  const answer = await execute('validate-scene', { inputs: { scene: { href: 'file:scene.json' } } });
  assert.deepEqual(await answer.json(), { valid: true, problems: [] });
});

test('validate-scene lists what is wrong, and says so as a good answer', async () => {
  const answer = await execute('validate-scene', { inputs: { scene: { ...scene, bogus: 1, seed: 'x' } } });
  assert.equal(answer.status, 200);
  const { valid, problems } = await answer.json();
  assert.equal(valid, false);
  assert.deepEqual(problems.map(({ pointer }) => pointer).sort(), ['/bogus', '/seed']);
  assert.equal((await get('/jobs')).jobs.some(({ processID }) => processID === 'validate-scene'), false);
});

test('analyze-dem gives the rasters that are wanted, by reference', async () => {
  const id = await finished('analyze-dem', { dem: { href: 'file:dem.tif' } }, { outputs: { fill: {}, report: {}, sinks: { transmissionMode: 'reference' } } });
  const results = await get(`/jobs/${id}/results`);
  assert.deepEqual(Object.keys(results).sort(), ['fill', 'report', 'sinks']);
  assert.equal((await ask(`/jobs/${id}/results/fill`)).headers.get('location'), results.fill.href);
  assert.equal((await ask(`/jobs/${id}/results/area`)).status, 404);
  const fill = await fetch(results.fill.href);
  assert.match(fill.headers.get('content-type'), /^image\/tiff/);
  assert.equal(Buffer.from(await fill.arrayBuffer()).subarray(0, 2).toString(), 'II');
  assert.match(await (await fetch(results.sinks.href)).text(), /^i,j,elevation,depth,area\n/);
  const report = await (await fetch(results.report.href)).json();
  assert.ok(report.width > 0 && !JSON.stringify(report).includes(work));
  const all = await get(`/jobs/${await finished('analyze-dem', { dem: 'dem.tif' })}/results`);
  assert.deepEqual(Object.keys(all).sort(), ['area', 'fill', 'power', 'report', 'sinks', 'slope']);
});

test('Of every process only the outputs are given that are asked for', async () => {
  const names = async (id) => Object.keys(await get(`/jobs/${id}/results`)).sort();
  const small = { ...scene, bake: { ...scene.bake, spacing: 8 } };
  const valid = await execute('validate-scene', { inputs: { scene }, outputs: { valid: {} } });
  assert.deepEqual(await valid.json(), { valid: true });
  const raw = await execute('validate-scene', { inputs: { scene }, outputs: { valid: {} }, response: 'raw' });
  assert.equal(await raw.json(), true);
  const bake = await finished('bake-terrain', { scene: small }, { outputs: { manifest: {}, report: {} } });
  assert.deepEqual(await names(bake), ['manifest', 'report']);
  assert.equal((await ask(`/jobs/${bake}/results/tileset`)).status, 404);
  const diff = await finished('diff-tilesets', { first: bake, second: bake }, { outputs: { report: {} } });
  assert.deepEqual(await names(diff), ['report']);
  assert.equal((await ask(`/jobs/${diff}/files/diff.html`)).status, 404, 'no page was made');
  assert.deepEqual(await names(await finished('analyze-dem', { dem: 'dem.tif' }, { outputs: { report: {} } })), ['report']);
  assert.deepEqual(await names(await finished('echo', { echo: 1 }, { outputs: { echo: {} } }, { prefer: 'respond-async' })), ['echo']);
});

let bakes;
test('diff-tilesets compares two jobs', async () => {
  const other = { ...scene, bake: { ...scene.bake, spacing: 8 } };
  const coarse = { ...scene, bake: { ...scene.bake, spacing: 8 }, operations: [] };
  bakes = [await finished('bake-terrain', { scene: other }), await finished('bake-terrain', { scene: coarse })];
  const [first, second] = bakes;
  const same = await get(`/jobs/${await finished('diff-tilesets', { first, second: first })}/results`);
  assert.equal((await (await fetch(same.report.href)).json()).same, true);
  const inputs = { first: { href: `${server.url}/jobs/${first}/results/tileset` }, second: { href: `${server.url}/jobs/${second}` } };
  const differs = await get(`/jobs/${await finished('diff-tilesets', inputs)}/results`);
  const report = await (await fetch(differs.report.href)).json();
  assert.equal(report.same, false);
  assert.ok(!JSON.stringify(report).includes(work));
  const page = await fetch(differs.page.href);
  assert.match(page.headers.get('content-type'), /^text\/html/);
  assert.match(page.headers.get('content-security-policy'), /sandbox/);
});

test('The list of jobs is paged, and filtered', async () => {
  const all = (await get('/jobs?limit=10000')).jobs;
  const seen = [];
  for (let path = '/jobs?limit=2'; path;) {
    const page = await get(path);
    assert.ok(page.jobs.length <= 2);
    seen.push(...page.jobs);
    path = page.links.find(({ rel }) => rel === 'next')?.href.slice(server.url.length);
  }
  assert.deepEqual(seen.map(({ jobID }) => jobID), all.map(({ jobID }) => jobID));
  const some = async (query) => (await get(`/jobs?limit=1000&${query}`)).jobs;
  assert.ok((await some('processID=bake-terrain')).every(({ processID }) => processID === 'bake-terrain'));
  const two = all.filter(({ processID }) => ['echo', 'bake-terrain'].includes(processID));
  assert.ok(two.length > 0 && two.length < all.length);
  assert.equal((await some('processID=echo,bake-terrain')).length, two.length);
  assert.equal((await some('status=failed')).length, 0);
  assert.equal((await some('status=successful&type=process')).length, all.length);
  assert.equal((await some('type=other')).length, 0);
  assert.equal((await some('minDuration=100')).length, 0);
  assert.equal((await some('maxDuration=1000')).length, all.length);
  const [newest] = all;
  assert.deepEqual((await some(`datetime=${newest.created}/..`)).map(({ jobID }) => jobID), [newest.jobID]);
  assert.equal((await some('datetime=../2001-01-01T00:00:00Z')).length, 0);
  for (const query of ['limit=0', 'limit=x', 'status=odd', 'datetime=soon', 'bogus=1', 'minDuration=-1', 'limit=%zz']) {
    assert.equal((await ask(`/jobs?${query}`)).status, 400, query);
  }
  const problems = async (query) => (await get(`/jobs?${query}`)).errors.map(({ detail, ...place }) => place);
  assert.deepEqual(await problems('limit=0&datetime=soon'), [{ parameter: 'datetime' }, { parameter: 'limit' }]);
  const odd = await (await fetch(`${server.url}/jobs?limit=%zz`)).json();   // by way of a proxy it is encoded anew
  assert.deepEqual(odd.errors, [{ detail: 'is not encoded as a URL is' }]);
  assert.equal((await get('/jobs?limit=20000')).jobs.length, all.length, 'as many as there may be');
});

test('A document that has not changed is not sent again', async () => {
  for (const path of ['/', '/api', '/processes', '/processes/echo', '/jobs', `/jobs/${bakes[0]}`, `/jobs/${bakes[0]}/results`]) {
    const etag = (await server.fetch(path)).headers.get('etag');
    assert.match(etag, /^"[0-9a-f]+(-\w+)?"$/, path);
    const again = await server.fetch(path, { headers: { 'if-none-match': etag } });
    assert.equal(again.status, 304, path);
    assert.equal((await again.text()).length, 0);
  }
});

test('A client may wait for the end of a job, or for its next change', async () => {
  const answer = await execute('echo', { inputs: { echo: 1, pause: 1 } }, { prefer: 'respond-async' });
  const { jobID } = await answer.json();
  const start = performance.now();
  const waited = await ask(`/jobs/${jobID}`, { headers: { prefer: 'wait=20' } });
  assert.equal((await waited.json()).status, 'successful');
  assert.equal(waited.headers.get('preference-applied'), 'wait=20');
  assert.ok(performance.now() - start < 15_000);
  const slow = (await (await execute('echo', { inputs: { echo: 1, pause: 10 } }, { prefer: 'respond-async' })).json()).jobID;
  await server.follow(slow, ({ status }) => status === 'running');
  assert.equal((await (await ask(`/jobs/${slow}`, { headers: { prefer: 'wait=1' } })).json()).status, 'running');
  const etag = (await ask(`/jobs/${slow}`)).headers.get('etag');
  const change = ask(`/jobs/${slow}`, { headers: { prefer: 'wait=20', 'if-none-match': etag } });
  assert.equal((await ask(`/jobs/${slow}`, { method: 'DELETE' })).status, 200);
  assert.equal((await (await change).json()).status, 'dismissed');
});

test('What is not there says so in the words of the standard', async () => {
  const missing = '0'.repeat(32);
  for (const path of [`/jobs/${missing}`, `/jobs/${missing}/results`, `/jobs/${missing}/events`, '/jobs/x']) {
    assert.equal((await get(path)).type, `${ogc}no-such-job`, path);
  }
  const answer = await execute('echo', { inputs: { echo: 1, pause: 10 } }, { prefer: 'respond-async' });
  const { jobID } = await answer.json();
  assert.equal((await get(`/jobs/${jobID}/results`)).type, `${ogc}result-not-ready`);
  await ask(`/jobs/${jobID}`, { method: 'DELETE' });
  assert.equal((await ask(`/jobs/${jobID}/results`)).status, 409);
  assert.equal((await ask(`/jobs/${bakes[0]}/results/nothing`)).status, 404);
});

/** An asset at once, and one in parts. */
async function sendAssets() {
  const bytes = Buffer.from('abc'), digest = createHash('sha256').update(bytes).digest('hex');
  const path = `/assets/sha256-${digest}`, type = { 'content-type': 'application/octet-stream' };
  for (const status of [201, 204]) assert.equal((await ask(path, { method: 'PUT', headers: type, body: bytes })).status, status);
  assert.equal((await ask(path.replace(/.$/, (end) => (end === '0' ? '1' : '0')), { method: 'PUT', headers: type, body: bytes })).status, 422);
  for (const method of ['GET', 'HEAD']) assert.equal((await ask(path, { method })).status, 200);
  assert.equal((await ask(`/assets?id=sha256-${digest}`)).status, 200);
  const fetched = (more) => ({ method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify({ href: 'http://127.0.0.1:9/dem.tif', ...more }) });
  assert.equal((await ask('/assets', fetched({ id: `sha256-${digest}` }))).status, 200, 'it is there');
  assert.equal((await ask('/assets', fetched())).status, 422, 'nobody may be asked');
  const tus = { 'tus-resumable': '1.0.0' };
  assert.equal((await ask('/uploads', { method: 'OPTIONS' })).status, 204);
  const made = await ask('/uploads', { method: 'POST', headers: { ...tus, 'upload-length': '3' } });
  assert.equal(made.status, 201);
  const upload = made.headers.get('location').slice(server.url.length);
  const part = { method: 'PATCH', headers: { ...tus, 'content-type': 'application/offset+octet-stream', 'upload-offset': '0' }, body: bytes };
  assert.equal((await ask(upload, part)).status, 204);
  assert.equal((await ask(upload, { ...part, body: Buffer.from('x') })).status, 409);
  assert.equal((await ask(upload, { method: 'HEAD', headers: tus })).headers.get('upload-offset'), '3');
  assert.equal((await ask(upload, { method: 'DELETE', headers: tus })).status, 204);
  for (const status of [204, 404]) assert.equal((await ask(path, { method: 'DELETE' })).status, status);
}

test('Every operation of the document has been asked, and answered as it says', async () => {
  for (const path of ['/healthz', '/readyz', '/metrics', '/tilesets', '/conformance', `/jobs/${bakes[0]}/results/report`]) await ask(path);
  await ask(`/jobs/${bakes[0]}/tiles/tileset.json`);
  await ask('/tilesets/none/tileset.json');
  await ask(`/jobs/${bakes[0]}/files/none.tif`);
  await ask(`/jobs/${bakes[0]}/events`);
  await sendAssets();
  const asked = [...contract.seen].map((text) => text.split(' ').slice(0, 2).join(' '));
  for (const [path, operations] of Object.entries(contract.document.paths)) {
    for (const method of Object.keys(operations)) {
      assert.ok(path === '/api' || asked.includes(`${method.toUpperCase()} ${path}`), `${method} ${path} was not asked`);
    }
  }
});

/**
 * Requirements of OGC API - Processes 1.0 (OGC 18-062r2), by their names there, asked of the server. Its schemas, in ogc.mjs, are held
 * against every answer that Server.fetch gives to any other test, too.
 */
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { makeFolder, makeRoot, removeFolder } from './hoodoo.mjs';
import { checkAnswer, exceptions, relations, wrongWith } from './ogc.mjs';
import { Server } from './server.mjs';

let work, server;
const seen = new Set();

before(async () => {
  work = await makeFolder();
  const root = await makeRoot(work);
  server = await Server.start({ data: join(work, 'data'), roots: [root] });
});
after(async () => {
  await server?.stop('SIGKILL');
  await removeFolder(work);
});

/** An answer, which is as the standard says. */
async function ask(path, options = {}) {
  const response = await server.unchecked(path, options);
  seen.add(await checkAnswer(options.method ?? 'GET', path.split('?')[0], response));
  return response;
}
const get = async (path) => (await ask(path)).json();
const execute = (process, inputs, headers = {}, more = {}) => ask(`/processes/${process}/execution`, {
  method: 'POST', headers: { 'content-type': 'application/json', ...headers }, body: JSON.stringify({ inputs, ...more }),
});
const asynchronous = { prefer: 'respond-async' };
/** A job that goes on until it is dismissed, or for ten seconds. */
async function startPause() {
  const response = await execute('echo', { echo: 1, pause: 10 }, asynchronous);
  assert.equal(response.status, 201);
  return (await response.json()).jobID;
}
const dismiss = (id) => ask(`/jobs/${id}`, { method: 'DELETE' });
const linkOf = ({ links }, rel) => links.find((link) => link.rel === rel)?.href;

test('/req/core/landingpage-op, landingpage-success: GET / is 200 with links to the API, conformance and processes', async () => {
  const response = await ask('/');
  assert.equal(response.status, 200);
  const page = await response.json();
  for (const rel of ['service-desc', `${relations}conformance`, `${relations}processes`]) assert.equal((await fetch(linkOf(page, rel))).status, 200, rel);
  assert.ok(linkOf(page, `${relations}job-list`));
});

test('/req/core/api-definition-op, api-definition-success: the API is described where service-desc says, as OpenAPI 3.0', async () => {
  const response = await fetch(linkOf(await get('/'), 'service-desc'));
  assert.equal(response.status, 200);
  assert.match(response.headers.get('content-type'), /^application\/vnd\.oai\.openapi\+json;\s*version=3\.0/);
  const document = await response.json();
  assert.match(document.openapi, /^3\.0\.\d$/);
  for (const path of ['/', '/conformance', '/processes', '/jobs']) assert.ok(document.paths[path].get, path);
});

test('/req/core/conformance-op, conformance-success: every class that is declared is one of the standard', async () => {
  const { conformsTo } = await get('/conformance');
  const classes = ['core', 'ogc-process-description', 'json', 'html', 'oas30', 'job-list', 'callback', 'dismiss'];
  for (const name of conformsTo) assert.ok(classes.includes(name.replace('http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/', '')), name);
});

test('/req/core/http: methods that a resource does not have are 405 with Allow', async () => {
  for (const [method, path] of [['POST', '/processes'], ['PUT', '/jobs'], ['DELETE', '/'], ['GET', '/processes/echo/execution']]) {
    const response = await ask(path, { method, body: method === 'GET' ? undefined : '{}' });
    assert.equal(response.status, 405, `${method} ${path}`);
    assert.ok(response.headers.get('allow').length > 0);
  }
});

test('/req/core/process-list, process-list-success: the list has a summary of every process, with links to it', async () => {
  const { processes } = await get('/processes');
  for (const process of processes) assert.equal((await (await fetch(linkOf(process, 'self'))).json()).id, process.id);
  assert.ok(processes.some(({ id }) => id === 'echo'));
});

test('/req/core/process-description-op, process-description-success: each describes its inputs and outputs by JSON Schemas', async () => {
  for (const { id } of (await get('/processes')).processes) {
    const process = await get(`/processes/${id}`);
    assert.equal(process.id, id);
    assert.equal(linkOf(process, `${relations}execute`), `${server.url}/processes/${id}/execution`);
  }
});

test('/req/core/process-exception/no-such-process: another one is 404 of that type, for its description and its execution', async () => {
  for (const response of [await ask('/processes/none'), await execute('none', {})]) {
    assert.equal(response.status, 404);
    assert.equal((await response.json()).type, `${exceptions}no-such-process`);
  }
});

test('/req/core/process-execute-default-execution-mode: what can only be done asynchronously is, unasked; what can be both is not', async () => {
  const { jobControlOptions } = await get('/processes/analyze-dem');
  assert.ok(!jobControlOptions.includes('sync-execute'));
  assert.equal((await execute('analyze-dem', { dem: 'dem.tif' })).status, 201);
  assert.equal((await execute('echo', { echo: 1 })).status, 200);
});

test('/req/core/process-execute-auto-execution-mode, process-execute-success-async: 201, Location, statusInfo, Preference-Applied', async () => {
  const response = await execute('echo', { echo: 1 }, asynchronous);
  assert.equal(response.status, 201);
  assert.equal(response.headers.get('preference-applied'), 'respond-async');
  const info = await response.json();
  assert.equal(response.headers.get('location'), `${server.url}/jobs/${info.jobID}`);
  assert.equal(info.processID, 'echo');
});

test('/req/core/process-execute-sync-document, process-execute-sync-raw-value-one: the results, or the one result by itself', async () => {
  for (const value of ['text', 1.5, true, [1, 2], { a: { b: 1 } }, { bbox: [1, 2, 3, 4], crs: 'http://www.opengis.net/def/crs/OGC/1.3/CRS84' }, { value: 'AAEC', encoding: 'base64', mediaType: 'application/octet-stream' }]) {
    assert.deepEqual(await (await execute('echo', { echo: value })).json(), { echo: value });
    assert.deepEqual(await (await execute('echo', { echo: value }, {}, { response: 'raw' })).json(), value);
  }
});

test('/req/core/process-execute-inputs, input-validation: an input that is missing, unknown or of another type is 400', async () => {
  for (const [process, inputs] of [['echo', {}], ['echo', { echo: 1, other: 2 }], ['analyze-dem', { dem: 5 }], ['analyze-dem', { dem: 'dem.tif', routing: 5 }], ['bake-terrain', { scene: [] }]]) {
    assert.equal((await execute(process, inputs)).status, 400, JSON.stringify(inputs));
  }
});

test('/req/core/process-execute-input-inline-object, mixed-type: an input by value and one by reference do the same', async () => {
  const done = async (dem) => {
    const { jobID } = await (await execute('analyze-dem', { dem }, {}, { outputs: { sinks: {} } })).json();
    await server.follow(jobID);
    return (await fetch((await get(`/jobs/${jobID}/results`)).sinks.href)).text();
  };
  assert.equal(await done('dem.tif'), await done({ href: 'file:dem.tif', type: 'image/tiff; application=geotiff' }));
});

test('/req/core/job-op, job-success, job-results-op, job-results-async-document: status to the end, then a link to the results, which are there', async () => {
  const { jobID } = await (await execute('echo', { echo: { a: 1 } }, asynchronous)).json();
  await server.follow(jobID);
  const info = await get(`/jobs/${jobID}`);
  assert.equal(info.status, 'successful');
  assert.equal(linkOf(info, `${relations}results`), `${server.url}/jobs/${jobID}/results`);
  assert.deepEqual(await get(`/jobs/${jobID}/results`), { echo: { a: 1 } });
});

test('/req/core/job-exception-no-such-job, job-results-exception/no-such-job: 404 of that type', async () => {
  for (const path of [`/jobs/${'0'.repeat(32)}`, `/jobs/${'0'.repeat(32)}/results`, '/jobs/none', '/jobs/none/results']) {
    const response = await ask(path);
    assert.equal(response.status, 404, path);
    assert.equal((await response.json()).type, `${exceptions}no-such-job`, path);
  }
  const response = await dismiss('none');
  assert.equal(response.status, 404);
  assert.equal((await response.json()).type, `${exceptions}no-such-job`);
});

test('/req/core/job-results-exception/results-not-ready: the results of a running job are 404 of that type', async () => {
  const id = await startPause();
  const response = await ask(`/jobs/${id}/results`);
  assert.equal(response.status, 404);
  assert.equal((await response.json()).type, `${exceptions}result-not-ready`);
  await dismiss(id);
});

test('/req/core/job-results-failed: the results of a job that failed are an exception of its kind', async () => {
  const scene = { hoodoo: 1, terrains: [{ dem: 'dem.tif' }], bake: { spacing: 1e-3 } };
  const response = await execute('bake-terrain', { scene });
  if (response.status === 201) {
    const { jobID } = await response.json();
    assert.equal((await server.follow(jobID)).at(-1).status, 'failed');
    const failed = await ask(`/jobs/${jobID}/results`);
    assert.ok(failed.status >= 400 && failed.status !== 404, `${failed.status}`);
  } else {
    assert.equal(response.status, 422);  // known before it began
  }
});

test('/req/dismiss/job-dismiss-op, job-dismiss-success: DELETE is 200 with the status dismissed', async () => {
  const id = await startPause();
  const response = await dismiss(id);
  assert.equal(response.status, 200);
  assert.equal((await response.json()).status, 'dismissed');
  assert.ok([404, 409].includes((await ask(`/jobs/${id}/results`)).status));
});

test('/req/job-list/job-list-op, job-list-success, links: every job is on the list once, page by page', async () => {
  const wanted = [];
  for (let i = 0; i < 5; ++i) wanted.push((await (await execute('echo', { echo: i }, asynchronous)).json()).jobID);
  const found = [];
  for (let path = '/jobs?limit=2'; path;) {
    const page = await get(path);
    assert.ok(page.jobs.length <= 2);
    found.push(...page.jobs.map(({ jobID }) => jobID));
    path = linkOf(page, 'next')?.slice(server.url.length);
  }
  assert.equal(new Set(found).size, found.length);
  for (const id of wanted) assert.ok(found.includes(id));
});

test('/req/job-list/limit-definition, limit-response: 1 to 10,000, 10 unasked; what is no such number is 400', async () => {
  for (let i = 0; i < 6; ++i) await execute('echo', { echo: i }, asynchronous);
  assert.equal((await get('/jobs')).jobs.length, 10);
  assert.equal((await get('/jobs?limit=1')).jobs.length, 1);
  assert.ok((await get('/jobs?limit=10000')).jobs.length > 10);
  for (const limit of ['0', '-1', 'x', '']) assert.equal((await ask(`/jobs?limit=${limit}`)).status, 400, limit);
});

test('/req/job-list/type-, processID-, status-, datetime-, duration-response: a filter lets through what fits, and no more', async () => {
  await server.follow((await get('/jobs?limit=1')).jobs[0].jobID);
  const list = async (query) => (await get(`/jobs?limit=1000&${query}`)).jobs;
  const all = await list('');
  const fits = async (query, test_) => assert.deepEqual((await list(query)).map(({ jobID }) => jobID), (await list('')).filter(test_).map(({ jobID }) => jobID), query);
  await fits('processID=echo', ({ processID }) => processID === 'echo');
  await fits('processID=echo&processID=analyze-dem', ({ processID }) => ['echo', 'analyze-dem'].includes(processID));
  await fits('status=successful', ({ status }) => status === 'successful');
  await fits('status=dismissed,failed', ({ status }) => status === 'dismissed' || status === 'failed');
  await fits('type=process', () => true);
  const { created } = all[Math.floor(all.length / 2)];
  await fits(`datetime=${created}/..`, (one) => one.created >= created);
  await fits(`datetime=../${created}`, (one) => one.created <= created);
  await fits('minDuration=3600', () => false);
  await fits('status=successful&maxDuration=3600', ({ status }) => status === 'successful');
});

test('Every document of the standard was among the answers, and the schemas refuse what is none', () => {
  for (const name of ['landingPage', 'confClasses', 'processList', 'process', 'statusInfo', 'jobList', 'results', 'exception']) assert.ok(seen.has(name), name);
  const info = { jobID: 'a', id: 'a', processingEntityType: 'ogc-api-processes', type: 'process', status: 'running', started: '2026-01-01T00:00:00Z' };
  assert.equal(wrongWith('statusInfo', info), '');
  for (const wrong of [{ ...info, jobID: undefined }, { ...info, id: undefined }, { ...info, status: 'done' }, { ...info, type: 'job' }, { ...info, progress: 101 }, { ...info, created: 'today' },
                       { ...info, status: 'successful', progress: 100, finished: '2026-01-01T00:00:00Z', links: [] }]) {
    assert.notEqual(wrongWith('statusInfo', JSON.parse(JSON.stringify(wrong))), '', JSON.stringify(wrong));
  }
  assert.notEqual(wrongWith('landingPage', { links: [] }), '');
  assert.notEqual(wrongWith('processList', { processes: [{ id: 'a' }], links: [] }), '');
  assert.notEqual(wrongWith('exception', { title: 'x' }), '');
  assert.notEqual(wrongWith('results', { a: { href: '/relative' } }), '');
});

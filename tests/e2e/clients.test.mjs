/** The API in the eyes of tools that nobody here wrote. */
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { makeFolder, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const tools = join(dirname(fileURLToPath(import.meta.url)), 'node_modules');
let work, server, document;

before(async () => {
  work = await makeFolder();
  server = await Server.start({ data: join(work, 'data') });
  document = join(work, 'api.json');
  await writeFile(document, await (await server.fetch('/api')).text());
});
after(async () => {
  await server?.stop();
  await removeFolder(work);
});

/** {code, text} of a command in the test's folder. */
const run = (command, args) => new Promise((resolve) => {
  const env = { ...process.env, REDOCLY_TELEMETRY: 'off', REDOCLY_SUPPRESS_UPDATE_NOTICE: 'true' };
  execFile(command, args, { cwd: work, env }, (error, stdout, stderr) => resolve({ code: error ? error.code : 0, text: stdout + stderr }));
});

test('Redocly finds no fault with the OpenAPI document', async () => {
  const { code, text } = await run(process.execPath, [join(tools, '@redocly/cli/bin/cli.js'), 'lint', '--format=json', document]);
  assert.equal(code, 0, text);
  const { totals } = JSON.parse(text.slice(text.indexOf('{'), text.lastIndexOf('}') + 1));
  assert.deepEqual({ errors: totals.errors, warnings: totals.warnings }, { errors: 0, warnings: 0 }, text);
});

test('Spectral finds no fault with it', async () => {
  await writeFile(join(work, 'rules.yaml'), 'extends: ["spectral:oas"]\n');
  const { code, text } = await run(process.execPath, [join(tools, '@stoplight/spectral-cli/dist/index.js'), 'lint', '--ruleset', 'rules.yaml',
                                                      '--fail-severity', 'hint', document]);
  assert.equal(code, 0, text);
  assert.match(text, /No results/);
});

test('OWSLib reads the landing page, the processes and the jobs', async () => {
  const { jobID } = await (await server.fetch('/processes/echo/execution', {
    method: 'POST', headers: { 'content-type': 'application/json', prefer: 'respond-async' }, body: JSON.stringify({ inputs: { echo: 1 } }),
  })).json();
  const script = join(work, 'read.py');
  await writeFile(script, `
import json, sys
from owslib.ogcapi.processes import Processes
service = Processes(sys.argv[1])
print(json.dumps({
  'links': [link['rel'] for link in service.links],
  'conforms': service.conformance()['conformsTo'],
  'processes': [one['id'] for one in service.processes()['processes']],
  'inputs': sorted(service.process('bake-terrain')['inputs']),
  'job': service._request('jobs')['jobs'][0]['jobID'],
}))
`);
  const { code, text } = await run('/usr/bin/python3', [script, `${server.url}/`]);
  assert.equal(code, 0, text);
  const read = JSON.parse(text);
  assert.ok(read.links.includes('service-desc'), text);
  assert.ok(read.conforms.some((one) => one.endsWith('/conf/core')), text);
  assert.deepEqual(read.processes.sort(), ['analyze-dem', 'bake-terrain', 'diff-tilesets', 'echo', 'validate-scene']);
  assert.ok(read.inputs.includes('scene'));
  assert.equal(read.job, jobID);
});

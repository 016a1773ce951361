/** What `deploy/` gives to those who run the server, in the eyes of the tools that will read it. */
import assert from 'node:assert/strict';
import { execFile, spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { access, constants, mkdir, readFile, readdir, stat, writeFile } from 'node:fs/promises';
import { basename, join, resolve } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { parse } from '@stoplight/yaml';
import { Ajv } from 'ajv';
import { command, exampleScene, hoodoo, makeKey, makeRoot, run as runProgram, withFolder } from './hoodoo.mjs';
import { Server, freePort } from './server.mjs';

const run = promisify(execFile);
const unit = new URL('../../deploy/hoodoo.service', import.meta.url);

test('The options of the systemd unit are options of hoodoo serve', async () => {
  const line = /^ExecStart=(.*)$/m.exec(await readFile(unit, 'utf8'))[1];
  const help = (await hoodoo(['serve', '--help'])).stdout;
  const options = line.match(/--[a-z-]+/g);
  assert.ok(options.length > 3);
  for (const option of options) assert.ok(help.includes(option), option);
});

test('systemd finds no fault with the unit, and little that it could do without', async () => {
  await withFolder(async (folder) => {
    const file = join(folder, 'hoodoo.service');
    await writeFile(file, (await readFile(unit, 'utf8')).replace('/usr/local/bin/hoodoo', command));
    const { stderr } = await run('systemd-analyze', ['verify', file]);
    assert.equal(stderr, '');
    await run('systemd-analyze', ['security', '--offline=yes', '--threshold=15', file]);
  });
});

test('The account of the unit is one that systemd makes', async () => {
  const [, user] = /^User=(.+)$/m.exec(await readFile(unit, 'utf8'));
  const accounts = new URL('../../deploy/hoodoo.sysusers', import.meta.url).pathname;
  assert.match(await readFile(accounts, 'utf8'), new RegExp(`^u ${user} - `, 'm'));
  await withFolder(async (root) => {
    await mkdir(join(root, 'etc'));
    await run('systemd-sysusers', [`--root=${root}`, accounts]);
    assert.match(await readFile(join(root, 'etc/passwd'), 'utf8'), new RegExp(`^${user}:.*:/var/lib/hoodoo:`, 'm'));
  });
});

/** What `hoodoo diff --json --html` prints of the two tilesets that the server of a folder was asked last to compare. */
async function printed(data) {
  const asked = [];
  for (const id of await readdir(join(data, 'jobs'))) {
    const file = join(data, 'jobs', id, 'inputs.json');
    if (existsSync(file)) asked.push({ at: (await stat(file)).mtimeMs, ...JSON.parse(await readFile(file, 'utf8')) });
  }
  const { first, second } = asked.sort((a, b) => b.at - a.at)[0];
  return JSON.parse((await hoodoo(['diff', first, second, '--json', '--html', join(data, 'printed.html')])).stdout);
}

test('The script for CI bakes a scene as it is and as it was, and tells whether they differ', () => withFolder(async (work) => {
  const root = await makeRoot(work), keys = join(work, 'keys.json'), out = join(work, 'out');
  const key = await makeKey(keys, 'ci', '--scopes', 'submit');
  const scene = await exampleScene();
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
    assert.deepEqual(JSON.parse(await readFile(join(out, 'report.json'), 'utf8')), await printed(join(work, 'data')));
    const broken = await compare('broken', 'now');
    assert.equal(broken.code, 2);
    assert.match(broken.stderr, /\/seed/);
    assert.equal((await compare('now', 'now', { HOODOO_KEY: 'hoodoo_wrong' })).code, 2);
  } finally {
    await server.stop();
  }
}));

test('The workflow for CI runs the script that lies beside it, on what it makes, and keeps what comes of it', async () => {
  const folder = resolve(import.meta.dirname, '../../deploy/ci'), text_ = await readFile(join(folder, 'terrain.yml'), 'utf8');
  const { on, env = {}, jobs: { diff: job } } = parse(text_);
  const runs = job.steps.filter((step) => step.run).map((step) => step.run), given = { ...env, ...job.env };
  const [comment] = text_.split('\nname:');
  const [, script, ...files] = /(\S+\.sh) (\S+) (\S+) (\S+)/.exec(runs.find((line) => line.includes('.sh')));
  await access(join(folder, script), constants.X_OK);
  assert.ok(comment.includes(basename(script)), 'it says to bring it along');
  const source = await readFile(join(folder, script), 'utf8');
  for (const [, name] of source.matchAll(/\$\{(HOODOO_\w+)/g)) {
    assert.match(given[name], new RegExp(`^\\$\\{\\{ (vars|secrets)\\.${name} \\}\\}$`));
    assert.ok(comment.includes(name), `it says to set ${name}`);
  }
  const [now, was, out] = files;
  assert.deepEqual(on.pull_request.paths, [now]);
  const [, shown, made] = /^git show "\S+:(\S+)" > (\S+)$/.exec(runs[0]);
  assert.deepEqual([shown, made], [now, was]);
  assert.equal(job.steps.at(-1).with.path, out);
  assert.equal(job.steps[0].with['fetch-depth'], 0, 'the base is there to show');
});

// --- deploy/container/compose.yaml

const containers = resolve(import.meta.dirname, '../../deploy/container');
const composeText = await readFile(join(containers, 'compose.yaml'), 'utf8');
const compose = parse(composeText);
const { hoodoo: ours, nginx } = compose.services;
/** Of a volume in its short form, [SOURCE:]TARGET[:ro]. */
const mountsOf = ({ volumes }) => volumes.map((text) => {
  const [source, target, mode = 'rw'] = text.split(':');
  return { source, target, mode };
});

const list = { type: 'array', minItems: 1, items: { type: 'string' } };
const text = { type: 'string' }, duration = { type: 'string', pattern: '^([0-9]+(us|ms|s|m|h))+$' };
const closed = (properties, required = []) => ({ type: 'object', properties, required, additionalProperties: false });
const mount = { type: 'string', pattern: '^(\\.{1,2}/[^:]+|[a-z][a-z0-9_.-]*):/[^:]+(:r[ow])?$' };
/** As far as the file makes use of it, the Compose Specification. */
const specification = closed({
  services: { type: 'object', additionalProperties: closed({
    image: text, command: list, build: closed({ context: text, dockerfile: text }, ['context']), volumes: { ...list, items: mount },
    ports: { ...list, items: { type: 'string', pattern: '^[0-9]+:[0-9]+$' } }, tmpfs: list, read_only: { type: 'boolean' }, cap_drop: list,
    security_opt: list, pids_limit: { type: 'integer' }, stop_grace_period: duration, restart: { enum: ['no', 'always', 'on-failure', 'unless-stopped'] },
    healthcheck: closed({ test: list, interval: duration, timeout: duration }, ['test']),
    network_mode: { type: 'string', pattern: '^(host|none|service:[a-z]+)$' },
    depends_on: { type: 'object', additionalProperties: closed({
      condition: { enum: ['service_started', 'service_healthy', 'service_completed_successfully'] }, restart: { type: 'boolean' },
    }, ['condition']) },
  }) },
  volumes: { type: 'object', additionalProperties: { type: ['null', 'object'] } },
}, ['services']);

test('The compose file is one by the specification, and what its services name of each other is there', () => {
  const ajv = new Ajv({ strict: false, allErrors: true });
  assert.ok(ajv.validate(specification, compose), JSON.stringify(ajv.errors));
  for (const [name, service] of Object.entries(compose.services)) {
    const others = [...Object.keys(service.depends_on ?? {}), ...service.network_mode?.startsWith('service:') ? [service.network_mode.slice(8)] : []];
    for (const other of others) assert.ok(other in compose.services && other !== name, `${name} needs ${other}`);
    for (const { source } of mountsOf(service)) assert.ok(source.startsWith('.') || source in compose.volumes, `${name} mounts ${source}`);
  }
  assert.ok(ours.healthcheck, 'nginx waits until it is well');
  // Who shares the network of another has no ports of its own.
  assert.equal(nginx.network_mode, 'service:hoodoo');
  assert.equal(nginx.ports, undefined);
});

test('The files of the compose file are there, or it says who brings them', () => {
  assert.ok(existsSync(resolve(containers, ours.build.context, ours.build.dockerfile)));
  const [comment] = composeText.split('services:');
  for (const { source } of [...mountsOf(ours), ...mountsOf(nginx)]) {
    if (!source.startsWith('.')) continue;
    const brought = comment.includes(source.split('/').at(-1));
    assert.ok(brought || existsSync(resolve(containers, source)), source);
  }
});

test('The compose file, the Dockerfile and the configuration of nginx are of one mind', async () => {
  const dockerfile = await readFile(join(containers, 'Dockerfile'), 'utf8');
  const settings = await readFile(join(containers, '../nginx/hoodoo.conf'), 'utf8');
  const option = (name) => ours.command[ours.command.indexOf(name) + 1];
  const targets = mountsOf(ours).map(({ target }) => target);
  for (const folder of JSON.parse(/^VOLUME (.*)$/m.exec(dockerfile)[1])) assert.ok(targets.includes(folder), `${folder} would be lost with the container`);
  for (const file of [option('--data'), option('--keys'), option('--root')]) {
    assert.ok(targets.some((target) => file === target || file.startsWith(`${target}/`)), `${file} is on no volume`);
  }
  assert.equal(settings.match(/^ *server (\S+);$/m)[1], option('--listen'));
  assert.deepEqual(ours.ports, [`443:${/listen (\d+) ssl/.exec(settings)[1]}`]);
  const seen = mountsOf(nginx).map(({ target }) => target);
  for (const [, file] of settings.matchAll(/^ *ssl_certificate(?:_key)? +(\S+);$/gm)) assert.ok(seen.includes(file), file);
  const data = mountsOf(ours).find(({ target }) => target === option('--data')).source;
  assert.deepEqual(mountsOf(nginx).find(({ source }) => source === data), { source: data, target: /^ *root (\S+);$/m.exec(settings)[1], mode: 'ro' });
});

/** Words of the compose file as they are here: variables at their defaults, folders below `work`, another port. */
function here(words, work, port) {
  return words.map((word) => word.replace(/\$\{\w+:-([^}]*)\}/g, '$1').replace(/^(?=\/(var|etc|srv)\/)/, work).replaceAll(/(127\.0\.0\.1[:/]|localhost:)8080/g, `$1${port}`));
}

test('The service starts with the options of the compose file, its key is let in, and its health is seen', () => withFolder(async (work) => {
  for (const { target } of mountsOf(ours)) await mkdir(join(work, target), { recursive: true });
  const port = await freePort(), [, making] = /docker compose run --rm hoodoo (key .*)$/m.exec(composeText);
  const made = await hoodoo(here(making.split(' '), work, port));
  assert.equal(made.code, 0, made.stderr);
  const [kind, ...check] = here(ours.healthcheck.test, work, port);
  assert.equal(kind, 'CMD');
  const healthy = () => run(check[0], check.slice(1)).then(() => true, () => false);
  assert.equal(await healthy(), false, 'nothing listens yet');
  const child = spawn(command, here(ours.command, work, port), { stdio: ['ignore', 'pipe', 'ignore'] });
  try {
    await new Promise((done, failed) => child.stdout.once('data', done).once('end', () => failed(new Error('it ended'))));
    assert.equal(await healthy(), true);
    const ask = (key) => fetch(`http://127.0.0.1:${port}/jobs`, { headers: { authorization: `Bearer ${key}` } });
    assert.deepEqual([(await ask(made.stdout.trim())).status, (await ask('hoodoo_wrong')).status], [200, 401]);
    const { links } = await (await fetch(`http://127.0.0.1:${port}/`)).json();
    assert.ok(links.every(({ href }) => href.startsWith('https://localhost/')), 'it is known by its public address');
  } finally {
    const over = new Promise((done) => child.once('close', done));
    child.kill('SIGKILL');
    await over;
  }
}));

/**
 * Starts `hoodoo serve` on a free port and talks to it. With HOODOO_PRISM, the file of Stoplight's command `prism`, by way of its
 * proxy, which answers 500 in place of what is not as the OpenAPI document says; but for files, streams,
 * HEAD and bodies that are no JSON or larger than 1 MB, which it cannot pass on. What the document does not know must be refused.
 */
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtemp, writeFile } from 'node:fs/promises';
import { request } from 'node:http';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { command } from './hoodoo.mjs';
import { checkAnswer } from './ogc.mjs';

export async function freePort() {
  const server = createServer().listen(0, '127.0.0.1');
  await new Promise((done) => server.once('listening', done));
  const { port } = server.address();
  await new Promise((done) => server.close(done));
  return port;
}

const answersFiles = /^\/(viewer|uploads|assets\/|tilesets\/|jobs\/\w+\/(tiles|files|events|results\/.))/;

function passesPrism({ method, body }) {
  if (method === 'HEAD') return false;
  if (body === undefined) return true;
  if (typeof body !== 'string' || body.length > 1e6) return false;
  try { JSON.parse(body); return true; } catch { return false; }
}

export class Server {
  /** Options: data, roots [], args [], under [], a command that is to start it. Resolves when the server says that it listens. */
  static async start({ data, roots = [], args = [], under = [] }) {
    const server = new Server();
    const options = ['serve', '--listen', '127.0.0.1:0', '--data', data,
                     ...roots.flatMap((root) => ['--root', root]),
                     ...process.env.HOODOO_SANITIZED ? ['--job-memory', '0'] : [], ...args];
    const [program, ...words] = [...under, command, ...options];
    server.child = spawn(program, words, { stdio: ['ignore', 'pipe', 'pipe'] });
    server.stderr = '';
    server.child.stderr.setEncoding('utf8').on('data', (text) => { server.stderr += text; });
    server.ended = new Promise((resolve) => {
      server.child.on('close', (code, signal) => resolve({ code, signal }));
    });
    let said = '';
    server.url = await new Promise((resolve, reject) => {
      server.child.stdout.setEncoding('utf8').on('data', (text) => {
        const found = /http:\/\/[^\s/]+/.exec(said += text);
        if (found) resolve(found[0]);
      });
      server.ended.then(() => reject(new Error(`the server ended: ${server.stderr}`)));
    });
    if (process.env.HOODOO_PRISM) await server.watch(process.env.HOODOO_PRISM);
    return server;
  }

  async watch(prism) {
    const document = join(await mkdtemp(join(tmpdir(), 'hoodoo-prism-')), 'api.json');
    await writeFile(document, await (await this.fetch('/api')).text());
    const port = await freePort();
    const proxy = spawn(process.execPath, [prism, 'proxy', document, this.url, '--port', port, '--errors', '--validate-request', 'false'], { stdio: 'ignore' });
    this.ended.then(() => proxy.kill());
    this.proxy = `http://127.0.0.1:${port}`;
    while (!await fetch(`${this.proxy}/healthz`).then(() => true, () => false)) await sleep(50);
  }

  /** Sends a signal and waits for the end: {code, signal}. */
  async stop(signal = 'SIGTERM') {
    this.child.kill(signal);
    return this.ended;
  }

  /** An answer, held to the standard where that says what it is like. */
  async fetch(path, options) {
    const response = await this.unchecked(path, options);
    await checkAnswer(options?.method ?? 'GET', path.split('?')[0], response);
    return response;
  }
  async unchecked(path, options = {}) {
    const ask = (url) => fetch(url + path, { redirect: 'manual', ...options });
    if (!this.proxy || !passesPrism(options) || answersFiles.test(path)) return ask(this.url);
    const watched = await ask(this.proxy);
    const said = watched.status < 400 ? '' : await watched.clone().text(), what = `${options.method ?? 'GET'} ${path}`;
    const [, kind] = /stoplight\.io\/prism\/errors#(\w+)/.exec(said) ?? [];
    if (!kind) return watched;
    assert.ok(kind.startsWith('NO_'), `${what} is not as the OpenAPI document says: ${said}`);
    const answer = await ask(this.url);
    assert.ok(answer.status >= 400, `${what}, which is not in the OpenAPI document, answers ${answer.status}`);
    return answer;
  }
  async json(path) {
    const response = await this.fetch(path);
    assert.equal(response.status, 200, `${path} answers ${response.status}`);
    return response.json();
  }
  /** `more` goes beside the inputs. */
  post(scene, more = {}, headers = {}) {
    return this.send(JSON.stringify({ inputs: { scene }, ...more }), headers);
  }
  send(body, headers = {}) {
    return this.fetch('/processes/bake-terrain/execution',
                      { method: 'POST', headers: { 'content-type': 'application/json', ...headers }, body });
  }
  /** Posts a scene that must be taken; gives the job's id. */
  async submit(scene, more) {
    const response = await this.post(scene, more);
    assert.equal(response.status, 201, await response.clone().text());
    return (await response.json()).jobID;
  }

  /** Asks until `done(info)`; gives every answer on the way. */
  async follow(id, done = ({ status }) => status !== 'accepted' && status !== 'running', seconds = 300) {
    const seen = [];
    for (const end = Date.now() + 1000 * seconds; Date.now() < end; await sleep(50)) {
      seen.push(await this.json(`/jobs/${id}`));
      if (done(seen.at(-1))) return seen;
    }
    throw new Error(`the job is still ${JSON.stringify(seen.at(-1))}`);
  }

  /** Sends a path as it is, which fetch would tidy up: {status, body}. */
  raw(path, method = 'GET') {
    const { hostname, port } = new URL(this.url);
    return new Promise((resolve, reject) => {
      request({ hostname, port, path, method }, (response) => {
        let body = '';
        response.setEncoding('utf8').on('data', (text) => { body += text; });
        response.on('end', () => resolve({ status: response.statusCode, body }));
      }).on('error', reject).end();
    });
  }
}

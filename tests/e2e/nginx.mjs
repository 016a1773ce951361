/** Starts nginx with deploy/nginx/hoodoo.conf before a server: on a free port, with its own certificate and folder. */
import assert from 'node:assert/strict';
import { execFile, spawn } from 'node:child_process';
import { chmod, mkdir, readFile, writeFile } from 'node:fs/promises';
import { request } from 'node:https';
import { dirname, join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { promisify } from 'node:util';

const run = promisify(execFile);
const configuration = new URL('../../deploy/nginx/hoodoo.conf', import.meta.url);
const environment = { ...process.env, PATH: `${process.env.PATH}:/usr/local/sbin:/usr/sbin` };

export class Nginx {
  /**
   * `port` is nginx's own, `upstream` hoodoo's, `data` hoodoo's folder, `more` lines of the http block. The limits of rates and of
   * connections stay unless `limits` is false. `plain` is a port to listen at without TLS, too.
   */
  static async start({ folder, port, upstream, data, more = '', limits = true, plain }) {
    const nginx = new Nginx();
    await mkdir(folder, { recursive: true });
    // Workers have an account of their own, as on a real machine; only the folder of the test is nobody else's.
    for (const path of [dirname(folder), dirname(data)]) await chmod(path, 0o755);
    const [key, certificate] = ['key.pem', 'certificate.pem'].map((name) => join(folder, name));
    await run('openssl', ['req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2', '-subj', '/CN=127.0.0.1', '-addext',
                          'subjectAltName=IP:127.0.0.1', '-keyout', key, '-out', certificate]);
    let site = await readFile(configuration, 'utf8');
    const put = (from, to) => {
      assert.ok(site.includes(from), `${from} is not in the configuration`);
      site = site.replaceAll(from, to);
    };
    put('listen 443 ssl http2;', `listen 127.0.0.1:${port} ssl http2;${plain ? ` listen 127.0.0.1:${plain};` : ''}`);
    put('server_name hoodoo.example;', 'server_name 127.0.0.1;');
    put('/etc/ssl/certs/hoodoo.pem', certificate);
    put('/etc/ssl/private/hoodoo.key', key);
    put('server 127.0.0.1:8080;', `server 127.0.0.1:${upstream};`);
    put('/var/lib/hoodoo', data);
    if (!limits) site = site.replace(/^\s*limit_(req|conn) .*$/gm, '');
    await writeFile(join(folder, 'site.conf'), site);
    const scratch = ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi'].map((name) => `${name}_temp_path ${folder}/${name};`);
    await writeFile(join(folder, 'nginx.conf'), `
${process.getuid() === 0 ? 'user nobody nogroup;' : ''}
daemon off;
pid ${folder}/pid;
lock_file ${folder}/lock;
worker_processes 1;
worker_rlimit_nofile 20000;
error_log stderr warn;
events { worker_connections 8192; }
http { access_log off; ${scratch.join(' ')} ${more} include ${folder}/site.conf; }
`);
    nginx.certificate = await readFile(certificate);
    nginx.url = `https://127.0.0.1:${port}`;
    nginx.child = spawn('nginx', ['-p', folder, '-c', join(folder, 'nginx.conf'), '-e', 'stderr'], { env: environment, stdio: ['ignore', 'ignore', 'pipe'] });
    nginx.stderr = '';
    nginx.child.stderr.setEncoding('utf8').on('data', (text) => { nginx.stderr += text; });
    nginx.ended = new Promise((done, fail) => nginx.child.once('close', done).once('error', fail));
    for (const end = Date.now() + 10_000;; await sleep(20)) {
      const up = await nginx.ask('/').then(() => true, () => false);
      if (up) return nginx;
      assert.ok(nginx.child.exitCode === null && Date.now() < end, `nginx does not answer: ${nginx.stderr}`);
    }
  }

  /** {status, headers, body} of a request as it is; `on` takes pieces as they come. */
  ask(path, { method = 'GET', headers = {}, body, on, agent } = {}) {
    const { hostname, port } = new URL(this.url);
    return new Promise((resolve, reject) => {
      const asked = request({ hostname, port, path, method, headers, agent, ca: this.certificate }, (response) => {
        const pieces = [];
        response.on('data', (piece) => { pieces.push(piece); on?.(piece); });
        response.on('end', () => resolve({ status: response.statusCode, headers: response.headers, body: Buffer.concat(pieces) }));
        response.on('error', reject);
      });
      asked.on('error', reject).end(body);
    });
  }

  async stop() {
    this.child.kill('SIGTERM');
    await this.ended;
  }
}

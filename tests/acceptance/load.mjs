/**
 * Does the server answer while a crowd hangs on it? 500 listeners to a job's events, 2,000 connections that say nothing and 200
 * clients that send a byte at a time, while a bake runs: how long /healthz takes, and what memory the server has. Prints a Markdown
 * table; ends with 1 when the 99th percentile is over 50 ms, memory was ever over 300 MiB, or the crowd was not there. With --nginx all
 * of it goes through nginx with deploy/nginx/hoodoo.conf, but for its limits for each address. Run by hand, under `ulimit -n 20000`:
 *
 *     node load.mjs [--nginx] [--listeners N] [--idle N] [--slow N] [--seconds N]
 */
import { mkdir, readFile } from 'node:fs/promises';
import { Agent, get } from 'node:http';
import { connect } from 'node:net';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { parseArgs } from 'node:util';
import { Worker, isMainThread, parentPort, workerData } from 'node:worker_threads';
import { example, hoodoo, makeFolder, removeFolder } from '../e2e/hoodoo.mjs';
import { Nginx } from '../e2e/nginx.mjs';
import { Server, freePort } from '../e2e/server.mjs';

const slowest = 50, mostMemory = 300;   // [ms], [MiB]
const present = 0.95;   // of the crowd; those that the server closes for their silence come back
const { values: options } = parseArgs({
  options: {
    listeners: { type: 'string', default: '500' }, idle: { type: 'string', default: '2000' }, slow: { type: 'string', default: '200' },
    seconds: { type: 'string', default: '20' }, nginx: { type: 'boolean', default: false },
  },
});

/** Milliseconds that /healthz takes on a connection of its own each time: median, 99th percentile, longest. */
async function probe({ url, seconds }) {
  const agent = new Agent({ keepAlive: false }), times = [];
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; await sleep(10)) {
    const from = performance.now();
    await new Promise((done, fail) => {
      get(`${url}/healthz`, { agent }, (response) => response.resume().on('end', done)).on('error', fail);
    });
    times.push(performance.now() - from);
  }
  times.sort((a, b) => a - b);
  return [0.5, 0.99, 1].map((q) => times[Math.min(times.length - 1, Math.floor(q * times.length))]);
}

// On a thread of its own, so that what the crowd costs this side is not measured.
if (!isMainThread) {
  parentPort.postMessage(await probe(workerData));
  process.exit(0);
}
const probeElsewhere = (seconds) => new Promise((done, fail) => {
  new Worker(new URL(import.meta.url), { workerData: { url, seconds } }).once('message', done).once('error', fail);
});

const crowd = Number(options.listeners) + Number(options.idle) + Number(options.slow);
const openFiles = Number(/Max open files\s+(\d+)/.exec(await readFile('/proc/self/limits', 'utf8'))[1]);
// The server takes a third of what it may open for connections.
if (openFiles < 3 * crowd + 500) {
  console.error(`only ${openFiles} files may be open, which is too few for ${crowd} connections: ulimit -n ${3 * crowd + 500}`);
  process.exit(2);
}

const work = await makeFolder(), root = join(work, 'root');
await mkdir(root);
await hoodoo(['synthesize', join(root, 'dem.tif')]);
const scene = JSON.parse(await readFile(join(example, 'scene.json'), 'utf8'));
const data = join(work, 'data'), plain = options.nginx ? await freePort() : null;
const server = await Server.start({ data, roots: [root], args: plain ? ['--public-url', `http://127.0.0.1:${plain}`] : [] });
const nginx = plain && await Nginx.start({
  folder: join(work, 'nginx'), port: await freePort(), plain, upstream: new URL(server.url).port, data, limits: false,
});
const url = plain ? `http://127.0.0.1:${plain}` : server.url;
const { hostname, port } = new URL(url);
const sockets = new Set();
let answered = 0;

/** A connection to the server that stays; one that the server closes is opened again. */
function hold(begin) {
  const socket = connect(Number(port), hostname, () => begin(socket));
  socket.on('error', () => {});
  socket.on('data', (data) => { if (data.includes('event: ')) ++answered; });
  socket.on('close', () => {
    sockets.delete(socket);
    if (!ending) hold(begin);
  });
  sockets.add(socket);
}
let ending = false;

const memory = async () => {
  const status = await readFile(`/proc/${server.child.pid}/status`, 'utf8');
  const of = (name) => Number(new RegExp(`${name}:\\s+(\\d+)`).exec(status)[1]);
  return { mib: of('VmRSS') / 1024, peak: of('VmHWM') / 1024, threads: of('Threads') };
};
/** Connections that are open: as the server counts them or, where they are nginx's, as this side does. */
async function connections() {
  if (plain) return [...sockets].filter(({ readyState }) => readyState !== 'opening').length;
  return Number(/^hoodoo_http_connections (\d+)$/m.exec(await (await fetch(`${server.url}/metrics`)).text())[1]);
}
/** The median of connections while `busy` lasts. */
async function connectionsDuring(busy) {
  const counts = [];
  let over = false;
  busy.finally(() => { over = true; }).catch(() => {});
  for (; !over; await sleep(200)) counts.push(await connections());
  return counts.sort((a, b) => a - b)[Math.floor(counts.length / 2)];
}

let worst = 0;
console.log('| clients | connections | /healthz median | 99 % | longest | memory | threads |\n|---|---|---|---|---|---|---|');
const row = async (what, seconds) => {
  const probing = probeElsewhere(seconds);
  const [times, open] = await Promise.all([probing, connectionsDuring(probing)]), { mib, threads } = await memory();
  worst = Math.max(worst, times[1]);
  console.log(`| ${what} | ${open} | ${times.map((t) => `${t.toFixed(1)} ms`).join(' | ')} | ${mib.toFixed(0)} MiB | ${threads} |`);
  return open;
};
const wrong = [];
const expect = (well, what) => { if (!well) wrong.push(what); };
try {
  await row('none', 3);
  const id = await server.submit({ ...scene, bake: { ...scene.bake, spacing: 0.25 } });
  await row('none, a bake runs', 5);
  for (let i = 0; i < Number(options.listeners); ++i) {
    hold((socket) => socket.write(`GET /jobs/${id}/events HTTP/1.1\r\nHost: ${hostname}:${port}\r\n\r\n`));
  }
  for (let i = 0; i < Number(options.idle); ++i) hold(() => {});
  for (let i = 0; i < Number(options.slow); ++i) {
    hold((socket) => {
      socket.write('GET / HTTP/1.1\r\nX: ');
      const timer = setInterval(() => socket.write('x'), 1000);
      socket.on('close', () => clearInterval(timer));
    });
  }
  await sleep(3000);
  const open = await row(`${options.listeners} listeners, ${options.idle} idle, ${options.slow} slow, a bake runs`, Number(options.seconds));
  const { status } = await server.json(`/jobs/${id}`);
  const { peak } = await memory();
  console.log(`the job is ${status}; ${answered} pieces of events came; ${peak.toFixed(0)} MiB at most`);
  expect(open >= present * crowd, `${open} of ${crowd} connections were there`);
  expect(status === 'running', `the bake was ${status} before the end`);
  expect(answered >= Number(options.listeners), `${answered} pieces of events for ${options.listeners} listeners`);
  expect(worst <= slowest, `/healthz took ${worst.toFixed(1)} ms, more than ${slowest} ms`);
  expect(peak <= mostMemory, `${peak.toFixed(0)} MiB of memory, more than ${mostMemory} MiB`);
  await server.fetch(`/jobs/${id}`, { method: 'DELETE' });
} finally {
  ending = true;
  for (const socket of sockets) socket.destroy();
  await nginx?.stop();
  await server.stop('SIGKILL');
  await removeFolder(work);
}
for (const what of wrong) console.error(what);
process.exit(wrong.length === 0 ? 0 : 1);

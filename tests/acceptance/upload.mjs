/**
 * How fast is an upload, and in how much memory? A file is hashed (`sha256sum`) and copied (`cp`) on the disk of the server's data, and
 * put by curl as an asset, which hashes it, writes it and waits for the disk; then once more in parts, by tus. Prints a Markdown table;
 * ends with 1 when the put takes over twice the time of the two commands together, or the server grows by 32 MiB or more. Run by hand:
 *
 *     node upload.mjs [--mib N] [--rounds N] [--folder DIR]
 */
import { createHash, randomBytes } from 'node:crypto';
import { mkdtemp, open, readFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { removeFolder, run } from '../e2e/hoodoo.mjs';
import { Server } from '../e2e/server.mjs';

const leastRate = 0.5, mostGrowth = 32;   // [MiB]
const { values: options } = parseArgs({
  options: {
    mib: { type: 'string', default: '1024' }, rounds: { type: 'string', default: '3' }, folder: { type: 'string', default: tmpdir() },
  },
});
const mebibyte = 2 ** 20, mib = Number(options.mib), parts = 4;
const work = await mkdtemp(join(options.folder, 'hoodoo-upload-')), file = join(work, 'file'), copy = join(work, 'copy');

/** Writes random bytes; gives their SHA-256. */
async function write() {
  const hash = createHash('sha256'), handle = await open(file, 'w');
  for (let i = 0; i < mib; ++i) {
    const piece = randomBytes(mebibyte);
    hash.update(piece);
    await handle.write(piece);
  }
  await handle.sync();
  await handle.close();
  return hash.digest('hex');
}
/** Seconds that a command takes, which must end well. */
async function time(program, ...args) {
  const from = performance.now(), { code, stdout, stderr } = await run(program, args);
  const seconds = (performance.now() - from) / 1000;
  if (code !== 0) throw new Error(`${program} ends with ${code}: ${stderr}`);
  return { seconds, stdout };
}
/** Seconds that a request of curl takes, which must be answered so. */
async function curl(status, ...args) {
  const { seconds, stdout } = await time('curl', '-s', '-o', '/dev/null', '-w', '%{http_code}', ...args);
  if (stdout !== String(status)) throw new Error(`curl ${args.join(' ')} is answered ${stdout}`);
  return seconds;
}
/** [MiB] that a server takes now, and has taken at most. */
async function memory(server) {
  const status = await readFile(`/proc/${server.child.pid}/status`, 'utf8');
  return ['VmRSS', 'VmHWM'].map((name) => Number(new RegExp(`${name}:\\s+(\\d+)`).exec(status)[1]) / 1024);
}

/** Seconds that an upload in parts takes. */
async function inParts(server, digest) {
  const from = performance.now(), tus = { 'tus-resumable': '1.0.0' };
  const made = await server.fetch('/uploads', { method: 'POST', headers: {
    ...tus, 'upload-length': String(mib * mebibyte), 'upload-metadata': `sha256 ${btoa(digest)}` } });
  const size = mib / parts, place = made.headers.get('location');
  let cut = 0;   // the parts are cut beside the clock
  for (let i = 0; i < parts; ++i) {
    cut += (await time('dd', `if=${file}`, `of=${copy}`, 'bs=1M', `skip=${i * size}`, `count=${size}`)).seconds;
    await curl(204, '-X', 'PATCH', '-T', copy, '-H', 'Tus-Resumable: 1.0.0', '-H', `Upload-Offset: ${i * size * mebibyte}`,
               '-H', 'Content-Type: application/offset+octet-stream', place);
  }
  return (performance.now() - from) / 1000 - cut;
}

/** One round on data of its own. */
async function round(digest, n) {
  const hashed = (await time('sha256sum', file)).seconds, copied = (await time('cp', file, copy)).seconds;
  await time('sync', copy);
  const server = await Server.start({ data: join(work, `data-${n}`) });
  try {
    await server.fetch('/healthz');
    const [idle] = await memory(server);
    const put = await curl(201, '-T', file, `${server.url}/assets/sha256-${digest}`);
    const again = await curl(204, '-T', file, `${server.url}/assets/sha256-${digest}`);
    await time('rm', '-f', join(work, `data-${n}/assets/sha256-${digest}`));
    const resumed = await inParts(server, digest);
    const growth = (await memory(server))[1] - idle, rate = (hashed + copied) / put;
    const seconds = [hashed, copied, put, again, resumed].map((s) => `${s.toFixed(2)} s`);
    console.log(`| ${seconds.join(' | ')} | ${rate.toFixed(2)} | ${idle.toFixed(0)} MiB | ${growth.toFixed(1)} MiB |`);
    return rate >= leastRate && growth < mostGrowth;
  } finally {
    await server.stop('SIGKILL');
    await removeFolder(join(work, `data-${n}`));
  }
}

let well = true;
try {
  const digest = await write();
  console.log(`${mib} MiB\n\n| sha256sum | cp | PUT | PUT again | ${parts} parts by tus | sha256sum + cp / PUT | idle | growth |`);
  console.log('|---|---|---|---|---|---|---|---|');
  for (let n = 0; n < Number(options.rounds); ++n) well = await round(digest, n) && well;
} finally {
  await removeFolder(work);
}
process.exit(well ? 0 : 1);

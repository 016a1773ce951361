/** Runs the built command (HOODOO_COMMAND) and measures it; makes what it works on. */
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { createHash } from 'node:crypto';
import { copyFile, mkdir, readFile, readdir, mkdtemp, rm } from 'node:fs/promises';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, relative, resolve } from 'node:path';

const here = import.meta.dirname;
const ticksPerSecond = 100;   // of /proc, on every Linux
export const command = process.env.HOODOO_COMMAND ?? resolve(here, '../../build/release/hoodoo');
export const testData = process.env.HOODOO_TEST_DATA ?? resolve(here, '../../../shared/data');
export const example = resolve(here, '../../schema/examples/first-light');

/** The folders of all bundled examples. */
export function examples() {
  const all = resolve(here, '../../schema/examples');
  return readdirSync(all).sort().map((name) => join(all, name)).filter((folder) => existsSync(join(folder, 'scene.json')));
}

/**
 * Runs `hoodoo ...args`. Options: cwd, env (added), uid (of the user to run as), kill: {after [ms], signal}, limit [ms] after which it is
 * killed, onStart(child). Gives {code, signal, stdout, stderr, seconds, processor, busy, peak [MiB], overtime}:
 * by the clock, of processors, and the less of the two, which tells most on a machine with other things to do.
 */
export function hoodoo(args, options = {}) {
  return run(command, args, options);
}

export function run(program, args, { cwd, env = {}, uid, kill, limit, onStart } = {}) {
  return new Promise((resolve_, reject) => {
    const start = performance.now();
    const child = spawn(program, args, { cwd, uid, env: { ...process.env, ...env }, stdio: ['ignore', 'pipe', 'pipe'] });
    const result = { stdout: '', stderr: '', peak: 0, overtime: false };
    for (const name of ['stdout', 'stderr']) {
      child[name].setEncoding('utf8').on('data', (text) => { result[name] += text; });
    }
    let processor = Infinity;
    // The kernel keeps the largest resident size while the process lives.
    const watch = () => {
      try {
        const fields = readFileSync(`/proc/${child.pid}/stat`, 'utf8').replace(/.*\) /s, '').split(' ');
        processor = (Number(fields[11]) + Number(fields[12])) / ticksPerSecond;
        const peak = /VmHWM:\s+(\d+) kB/.exec(readFileSync(`/proc/${child.pid}/status`, 'utf8'));
        if (peak) result.peak = Math.max(result.peak, Number(peak[1]) / 1024);
      } catch { /* it has ended */ }
    };
    const timers = [setInterval(watch, 5)];
    if (kill) timers.push(setTimeout(() => child.kill(kill.signal), kill.after));
    if (limit) {
      timers.push(setTimeout(() => {
        result.overtime = true;
        child.kill('SIGKILL');
      }, limit));
    }
    const stop = () => timers.forEach(clearTimeout);
    child.on('error', (error) => { stop(); reject(error); });
    child.on('close', (code, signal) => {
      stop();
      const seconds = (performance.now() - start) / 1000;
      resolve_({ ...result, code, signal, seconds, processor, busy: Math.min(seconds, processor) });
    });
    onStart?.(child);
  });
}

export const makeFolder = () => mkdtemp(join(tmpdir(), 'hoodoo-e2e-'));
export const removeFolder = (folder) => rm(folder, { recursive: true, force: true });

/** Calls `use(folder)` with a temporary folder that is gone afterwards. */
export async function withFolder(use) {
  const folder = await makeFolder();
  try {
    return await use(folder);
  } finally {
    await removeFolder(folder);
  }
}

/** A command that must end well; gives what it printed. */
async function succeeds(args) {
  const { code, stdout, stderr } = await hoodoo(args);
  assert.equal(code, 0, stderr);
  return stdout;
}
/** Writes the sample DEM; gives the file. */
export async function synthesize(file, ...options) {
  await succeeds(['synthesize', file, ...options]);
  return file;
}
/** A folder `root` in `work` for a server to look into, with the first example, scene.json and dem.tif; gives its name. */
export async function makeRoot(work) {
  const root = join(work, 'root');
  await mkdir(root);
  await copyFile(join(example, 'scene.json'), join(root, 'scene.json'));
  await synthesize(join(root, 'dem.tif'));
  return root;
}
/** The scene of the first example. */
export const exampleScene = async () => JSON.parse(await readFile(join(example, 'scene.json'), 'utf8'));
/** A key of the service in a file of keys. */
export const makeKey = async (file, name, ...options) => (await succeeds(['key', file, name, ...options])).trim();

/** SHA-256 of every file below `folder`, hidden ones too: {relative name: digest}. */
export async function digests(folder) {
  const entries = await readdir(folder, { recursive: true, withFileTypes: true });
  const files = entries.filter((entry) => !entry.isDirectory())
    .map((entry) => join(entry.parentPath, entry.name)).sort();
  const found = {};
  for (const file of files) {
    found[relative(folder, file)] = createHash('sha256').update(await readFile(file)).digest('hex');
  }
  return found;
}

/** Random numbers in [0, 1) by a seed (mulberry32). */
export function seededRandom(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

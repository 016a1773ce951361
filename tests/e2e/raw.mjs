/** Talks to a server byte by byte, as those do who mean it no good, and watches its memory. */
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { connect } from 'node:net';
import { setTimeout as sleep } from 'node:timers/promises';

/** The answers in `bytes`: {status, headers, body (text), whole}. Answers to HEAD cannot be told from others. */
export function answersIn(bytes) {
  const answers = [];
  let text = bytes.toString('latin1');
  while (text.startsWith('HTTP/1.1 ')) {
    const end = text.indexOf('\r\n\r\n');
    if (end < 0) break;
    const [line, ...lines] = text.slice(0, end).split('\r\n');
    const headers = Object.fromEntries(lines.map((one) => [one.slice(0, one.indexOf(':')).toLowerCase(), one.slice(one.indexOf(':') + 1).trim()]));
    const status = Number(line.split(' ')[1]);
    text = text.slice(end + 4);
    let length = Number(headers['content-length'] ?? 0), whole = text.length >= length;
    if (headers['transfer-encoding'] === 'chunked') {
      length = text.indexOf('0\r\n\r\n') + 5;
      whole = length > 4;
    }
    answers.push({ status, headers, body: text.slice(0, length), whole });
    text = text.slice(length);
  }
  answers.rest = text;
  return answers;
}

/**
 * Sends `parts`, a text, bytes or an iterable of them, with no more in flight than the other side takes, and gives the answers once it
 * has closed, after the last answer that `enough(answers)` asks for, or after `patience` [s]. {answers, closed, seconds, sent [bytes]}
 */
export async function converse(url, parts, { enough = () => false, patience = 30, end = false } = {}) {
  const { hostname, port } = new URL(url);
  const from = performance.now(), socket = connect(Number(port), hostname), pieces = [];
  let closed = false, wake = () => {}, sent = 0;
  socket.on('error', () => {});
  socket.on('data', (piece) => { pieces.push(piece); wake(); });
  socket.on('end', () => { closed = true; wake(); });
  socket.on('close', () => { closed = true; wake(); });
  const over = () => closed || enough(answersIn(Buffer.concat(pieces)));
  const given = typeof parts === 'string' || Buffer.isBuffer(parts) ? [parts] : parts;
  const last = from + 1000 * patience;
  for await (const part of given) {
    if (over() || performance.now() > last) break;
    const bytes = Buffer.isBuffer(part) ? part : Buffer.from(part, 'latin1');
    sent += bytes.length;
    const taken = socket.write(bytes);
    await new Promise(setImmediate);   // what has come is read between two writes
    if (taken || socket.writableLength === 0) continue;
    await Promise.race([new Promise((done) => { socket.once('drain', done); wake = done; }), sleep(Math.max(0, last - performance.now()), null, { ref: false })]);
  }
  if (end && !closed) socket.end();
  while (!over() && performance.now() < last) {
    await Promise.race([new Promise((done) => { wake = done; }), sleep(100)]);
  }
  socket.destroy();
  return { answers: answersIn(Buffer.concat(pieces)), closed, seconds: (performance.now() - from) / 1000, sent };
}

/** The same piece `count` times. */
export function* times(count, piece) {
  const bytes = Buffer.from(piece, 'latin1');
  for (let i = 0; i < count; ++i) yield bytes;
}

/** Memory of a process, and of nothing it has started. */
export class Memory {
  constructor(pid) {
    this.pid = pid;
    this.idle = this.now().resident;
  }
  now() {
    const status = readFileSync(`/proc/${this.pid}/status`, 'utf8');
    const of = (name) => Number(new RegExp(`${name}:\\s+(\\d+) kB`).exec(status)[1]) / 1024;
    return { resident: of('VmRSS'), most: of('VmHWM') };
  }
  /** [MiB] by which it has ever been larger than idle. */
  growth() { return this.now().most - this.idle; }
}

/** A server is as it should be: it answers, and has not grown by 64 MiB. */
export async function assertWell(server, memory) {
  // A connection of its own: one that is kept may be closed while this process is busy.
  const { answers } = await converse(server.url, `GET /healthz HTTP/1.1\r\nHost: ${new URL(server.url).host}\r\nConnection: close\r\n\r\n`);
  assert.equal(answers.length, 1, 'it does not answer');
  assert.equal(answers[0].status, 200);
  assert.deepEqual(JSON.parse(answers[0].body), { status: 'ok' });
  // A sanitizer keeps what is freed for a while.
  if (!process.env.HOODOO_SANITIZED) assert.ok(memory.growth() < 64, `it has grown by ${memory.growth().toFixed(1)} MiB`);
}

/** An answer without a word of what went wrong inside. */
export function assertDiscreet({ status, headers, body }) {
  if (status >= 400) {
    assert.equal(headers['content-type'], 'application/problem+json', body);
    assert.equal(JSON.parse(Buffer.from(body, 'latin1').toString()).status, status);
  }
  for (const word of ['std::', 'nlohmann', 'json.exception', '.cpp', 'terminate', '/tmp/', 'sqlite', 'basic_string']) {
    assert.ok(!body.includes(word), `${word} in ${body.slice(0, 400)}`);
  }
}

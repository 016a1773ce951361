/** Assets and uploads in parts, each by a single request to a server. */
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readdir } from 'node:fs/promises';
import { request } from 'node:http';
import { join } from 'node:path';

export const mebibyte = 2 ** 20;
export const offsetType = 'application/offset+octet-stream';
export const tus = { 'tus-resumable': '1.0.0' };
export const hash = (bytes, form = 'hex') => createHash('sha256').update(bytes).digest(form);
export const nameOf = (bytes) => `sha256-${hash(bytes)}`;
export const metadata = (bytes) => `filename ${btoa('dem.tif')},sha256 ${btoa(hash(bytes))}`;

/**
 * One request, {status, headers, text, continued}: also an answer that comes before the body was sent, which fetch may not see.
 * Without `body` nothing but the head is sent, whatever Content-Length says.
 */
export function ask(server, method, path, headers = {}, body = undefined) {
  return new Promise((resolve, reject) => {
    let answered = false, continued = false;
    const given = Object.fromEntries(Object.entries(headers).filter(([, value]) => value !== undefined));
    const asking = request(new URL(path, server.url), { method, headers: given, agent: false });
    asking.on('continue', () => {
      continued = true;
      asking.end(body);
    });
    asking.on('error', (error) => { if (!answered) reject(error); });
    asking.on('response', async (response) => {
      answered = true;
      const text = (await response.setEncoding('utf8').toArray()).join('');
      asking.destroy();
      resolve({ status: response.statusCode, headers: response.headers, text, continued });
    });
    if (headers.expect) asking.flushHeaders();
    else asking.end(body);
  });
}

export const put = (server, bytes, { name = nameOf(bytes), ...headers } = {}) =>
  ask(server, 'PUT', `/assets/${name}`, { 'content-length': bytes.length, ...headers }, bytes);

/** The path of a new upload. */
export async function create(server, bytes, headers = { 'upload-metadata': metadata(bytes) }) {
  const made = await ask(server, 'POST', '/uploads', { ...tus, 'upload-length': bytes.length, 'content-length': 0, ...headers });
  assert.equal(made.status, 201, made.text);
  assert.ok(made.headers.location.startsWith(`${server.url}/uploads/`));
  return made.headers.location.slice(server.url.length);
}
export const patch = (server, path, offset, bytes, headers = {}) =>
  ask(server, 'PATCH', path, { ...tus, 'content-type': offsetType, 'upload-offset': offset, 'content-length': bytes.length, ...headers }, bytes);
export async function offsetOf(server, path) {
  const { status, headers } = await ask(server, 'HEAD', path, tus);
  assert.equal(status, 200);
  assert.equal(headers['cache-control'], 'no-store');
  return Number(headers['upload-offset']);
}

/** Names of all that a server keeps for assets in its folder. */
export async function kept(data) {
  return { assets: await readdir(join(data, 'assets')), uploads: await readdir(join(data, 'uploads')) };
}

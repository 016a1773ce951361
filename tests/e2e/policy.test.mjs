/** What the viewer's pages may do by their Content-Security-Policy: as it is written, and as a browser keeps it. */
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { createServer } from 'node:http';
import { join, resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { launch, openPage } from './browser.mjs';
import { makeFolder, removeFolder } from './hoodoo.mjs';
import { Server } from './server.mjs';

const sources = resolve(import.meta.dirname, '../../server/viewer');
const pages = readdirSync(sources).filter((name) => name.endsWith('.html'));
let work, server, browser, stranger, asked;

before(async () => {
  work = await makeFolder();
  server = await Server.start({ data: join(work, 'data') });
  browser = await launch();
  // Another origin, which lets every page read it.
  stranger = createServer(({ url }, response) => {
    asked.push(url);
    response.writeHead(200, { 'content-type': 'text/html', 'access-control-allow-origin': '*' }).end('<!doctype html><title>Stranger</title>');
  });
  await new Promise((done) => { stranger.listen(0, '127.0.0.1', done); });
});
after(async () => {
  stranger?.closeAllConnections();
  stranger?.close();
  await browser?.close();
  await server?.stop('SIGKILL');
  await removeFolder(work);
});
const at = (path, host = '127.0.0.1') => `http://${host}:${stranger.address().port}${path}`;

/** {directive: [source]} */
const parse = (policy) => Object.fromEntries(policy.split(';').map((text) => text.trim().split(/\s+/)).map(([name, ...list]) => [name, list]));

for (const name of pages) {
  test(`${name} says, before its first script, that nothing is let but what it names`, () => {
    const text = readFileSync(join(sources, name), 'utf8'), [head] = text.split('<script');
    const policies = [...head.matchAll(/<meta http-equiv="Content-Security-Policy" content="([^"]*)">/g)];
    assert.equal(policies.length, 1);
    const policy = parse(policies[0][1]);
    assert.deepEqual(policy['default-src'], ["'none'"]);
    const own = /^('self'|'wasm-unsafe-eval'|'sha256-[^']+'|blob:|data:)$/;   // no unsafe-inline, no unsafe-eval, no host
    for (const [directive, list] of Object.entries(policy)) {
      if (directive !== 'default-src') for (const source of list) assert.match(source, own, directive);
    }
    assert.deepEqual(policy['script-src'].filter((source) => /:/.test(source)), [], 'no script out of data');
  });
}

/** Has a page run a script of its own text, and read the stranger: {ran, read, violated}, the directives that kept it from it. */
const attempt = (page) => page.evaluate(async (url) => {
  const violated = [];
  document.addEventListener('securitypolicyviolation', ({ effectiveDirective }) => violated.push(effectiveDirective));
  const script = document.createElement('script');
  script.textContent = 'globalThis.ran = true;';
  document.head.append(script);
  const read = await fetch(url).then(({ ok }) => ok, () => false);
  await new Promise((done) => { setTimeout(done, 100); });   // violations are told a little later
  return { ran: globalThis.ran === true, read, violated: [...new Set(violated)].sort() };
}, at('/data'));

test('In a browser no page runs a script of its own text, or reads another origin', async () => {
  asked = [];
  const free = await openPage(browser, at('', 'localhost'));
  await free.goto(at('/', 'localhost'));
  assert.deepEqual(await attempt(free), { ran: true, read: true, violated: [] }, 'a page without a policy may do both');
  assert.ok(asked.includes('/data'));
  await free.end();
  for (const name of pages) {
    asked = [];
    const page = await openPage(browser, server.url);
    await page.goto(`${server.url}/viewer/${name}`);
    assert.deepEqual(await attempt(page), { ran: false, read: false, violated: ['connect-src', 'script-src-elem'] }, name);
    assert.deepEqual(asked, [], 'nothing was sent');
    await page.end();
  }
});

test('A page of the viewer is in no frame of another one, by its header', async () => {
  asked = [];
  const page = await openPage(browser, server.url);
  await page.goto(at('/'));
  const framed = async (url) => {
    await page.evaluate((src) => new Promise((done) => {
      const frame = document.createElement('iframe');
      frame.addEventListener('load', done, { once: true });
      frame.src = src;
      document.body.replaceChildren(frame);
    }), url);
    return page.frames().at(-1).url();
  };
  assert.equal(await framed(at('/inner')), at('/inner'));
  for (const name of pages) {
    const policy = parse((await server.fetch(`/viewer/${name}`)).headers.get('content-security-policy'));
    for (const directive of ['frame-ancestors', 'base-uri', 'form-action']) assert.deepEqual(policy[directive], ["'none'"], name);
    assert.match(await framed(`${server.url}/viewer/${name}`), /^chrome-error:/, name);
  }
  await page.end();
});

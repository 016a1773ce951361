// The service this page comes from, and the key that was entered for it, kept until the tab is closed.
import { Hoodoo, Problem } from './client.js';

const NAME = 'hoodoo-key';
const element = (id) => document.getElementById(id);

// The process whose jobs have a terrain to show.
export const BAKE = 'bake-terrain';

export const service = new Hoodoo(new URL('..', import.meta.url), { key: () => sessionStorage.getItem(NAME) });

// Asks for a key; resolves to false where none was entered.
function askForKey(why) {
  const dialog = element('key-dialog');
  element('key-why').textContent = why;
  element('key').value = sessionStorage.getItem(NAME) ?? '';
  if (!dialog.open) dialog.showModal();
  return new Promise((done) => {
    dialog.addEventListener('close', () => {
      const entered = dialog.returnValue === 'use';
      const key = element('key').value.trim();
      if (entered && key) sessionStorage.setItem(NAME, key);
      else if (entered) sessionStorage.removeItem(NAME);
      dialog.returnValue = '';
      done(entered);
    }, { once: true });
  });
}

export const isMissing = (error) => error instanceof Problem && error.status === 404;
export const isRefused = (error) => error instanceof Problem && (error.status === 401 || error.status === 403);

// What is to be said of a request that was refused for want of a key, or with a wrong one.
function refusal({ status, detail }) {
  if (status !== 401) return detail;
  return sessionStorage.getItem(NAME) ? 'This key is not known here.' : 'This service needs a key.';
}

// What `call` gives; a key is asked for where it needs one. Errors: those of `call`.
export async function withKey(call) {
  for (;;) {
    try {
      return await call();
    } catch (error) {
      if (!isRefused(error) || !await askForKey(refusal(error))) throw error;
    }
  }
}

export const AWAY = 'The server does not answer.';

// Says what went wrong in words for who looks at the page.
export function explain(error) {
  if (isRefused(error)) return refusal(error);
  if (error instanceof Problem) return error.message;
  return error instanceof TypeError ? AWAY : String(error.message ?? error);
}

// The button by which a key is entered; `then` is called with it changed.
export function offerKey(then) {
  element('key-button').addEventListener('click', async () => {
    if (await askForKey('The key is kept until this tab is closed.')) then();
  });
}

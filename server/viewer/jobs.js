// The list of jobs: how far each is, to cancel, to remove, to look at, to compare.
import { Hoodoo } from './client.js';
import { Pair } from './pair.js';
import { BAKE, explain, isRefused, offerKey, service, withKey } from './session.js';

const BUSY_MS = 1000, CALM_MS = 5000;
const PAGE = 20;
const element = (id) => document.getElementById(id);
const time = new Intl.DateTimeFormat('en-GB', { dateStyle: 'medium', timeStyle: 'short' });
const make = (tag, className, text = '') => Object.assign(document.createElement(tag), { className, textContent: text });

const shown = new Map();  // the row of each job on the page, by its id
const page = new URLSearchParams(location.search);
const pair = new Pair();
let timer = 0, asking = null;

function duration(job) {
  if (!job.started) return '';
  const seconds = Math.max(0, Math.round((Date.parse(job.finished ?? job.updated) - Date.parse(job.started)) / 1000));
  return seconds < 60 ? `${seconds} s` : `${Math.floor(seconds / 60)} min ${seconds % 60} s`;
}

class Row {
  constructor(id) {
    this.id = id;
    this.item = make('li', 'job card');
    this.title = make('h2', 'job-title');
    this.status = make('span', 'badge');
    this.message = make('p', 'job-message');
    this.progress = Object.assign(make('progress'), { max: 100 });
    this.facts = make('p', 'job-facts');
    this.open = make('a', 'button', 'Open');
    this.mark = Object.assign(make('button', 'mark', 'Compare'), { type: 'button' });
    this.mark.addEventListener('click', () => pair.toggle(this.id, `${this.title.textContent} of ${time.format(new Date(this.job.created))}`));
    this.end = Object.assign(make('button', ''), { type: 'button' });
    this.end.addEventListener('click', () => this.#end());
    const actions = make('div', 'job-actions');
    actions.append(this.open, this.mark, this.end);
    const head = make('div', 'job-head');
    head.append(this.title, this.status);
    this.item.append(head, this.message, this.progress, this.facts, actions);
  }

  show(job) {
    this.job = job;
    const name = job.title || job.processID, ended = Hoodoo.hasEnded(job);
    this.title.textContent = this.title.title = name;
    this.status.textContent = job.status;
    this.status.dataset.status = job.status;
    this.message.textContent = job.message;
    this.progress.hidden = ended;
    this.progress.value = job.progress ?? 0;
    this.progress.setAttribute('aria-label', `Progress of ${name}`);
    const priority = job.priority ? [`priority ${job.priority}`] : [];
    this.facts.textContent = [job.processID, time.format(new Date(job.created)), duration(job), ...priority].filter(Boolean).join(' · ');
    this.open.hidden = job.processID !== BAKE || !(job.tiles?.done > 0);
    this.open.href = `./?job=${job.jobID}`;
    this.open.setAttribute('aria-label', `Open ${name} in the viewer`);
    this.mark.hidden = this.open.hidden;
    this.mark.setAttribute('aria-label', `Compare ${name}`);
    this.showMark();
    this.end.textContent = ended ? 'Remove' : 'Cancel';
    this.end.setAttribute('aria-label', `${this.end.textContent} ${name}`);
  }

  showMark() {
    this.mark.setAttribute('aria-pressed', pair.has(this.id));
  }

  async #end() {
    const ended = Hoodoo.hasEnded(this.job);
    if (this.ending) return;
    if (ended && !await confirmRemoval(this.title.textContent)) return;
    this.#setEnding(true);
    try {
      await withKey(() => service.dismiss(this.id));
      say(`${this.title.textContent} is ${ended ? 'removed' : 'cancelled'}.`);
      if (ended) {
        pair.forget(this.id);
        element('status').focus();  // where the row was nothing is left
      }
    } catch (error) {
      say(explain(error), true);
    } finally {
      this.#setEnding(false);
      update();
    }
  }
  // Not `disabled`, with which the button would lose the focus.
  #setEnding(on) {
    this.ending = on;
    this.end.setAttribute('aria-disabled', on);
  }
}

function confirmRemoval(name) {
  const dialog = element('remove-dialog');
  element('remove-name').textContent = name;
  dialog.returnValue = '';
  dialog.showModal();
  return new Promise((done) => {
    dialog.addEventListener('close', () => done(dialog.returnValue === 'remove'), { once: true });
  });
}

function say(text, bad = false) {
  element('message').textContent = text;
  element('message').dataset.kind = bad ? 'bad' : '';
}

function show({ jobs, before }) {
  const items = jobs.map((job) => {
    if (!shown.has(job.jobID)) shown.set(job.jobID, new Row(job.jobID));
    const row = shown.get(job.jobID);
    row.show(job);
    return row.item;
  });
  const ids = new Set(jobs.map(({ jobID }) => jobID));
  for (const [id, { item }] of shown) {
    if (ids.has(id)) continue;
    item.remove();
    shown.delete(id);
  }
  // Only what moves is moved, so that the focus stays where it is.
  items.forEach((item, i) => {
    const list = element('list');
    if (list.children[i] !== item) list.insertBefore(item, list.children[i] ?? null);
  });
  element('empty').hidden = jobs.length > 0;
  element('pages').hidden = !page.has('before') && before === undefined;
  element('newest').toggleAttribute('disabled', !page.has('before'));
  element('older').toggleAttribute('disabled', before === undefined);
  element('older').dataset.before = before ?? '';
  return jobs.some((job) => !Hoodoo.hasEnded(job));
}

async function update() {
  clearTimeout(timer);
  asking?.abort();
  const mine = asking = new AbortController();
  const query = { limit: PAGE };
  if (page.has('before')) query.before = Number(page.get('before'));
  if (page.get('status')) query.status = page.get('status').split(',');
  let busy = false;
  try {
    busy = show(await withKey(() => service.jobs(query, { signal: mine.signal })));
    if (element('message').dataset.kind === 'bad') say('');
  } catch (error) {
    if (mine.signal.aborted) return;
    say(explain(error), true);
    if (isRefused(error)) return;  // no key was entered
  }
  if (!document.hidden && asking === mine) timer = setTimeout(update, busy ? BUSY_MS : CALM_MS);
}

function go(name, value) {
  if (value) page.set(name, value);
  else page.delete(name);
  if (name === 'status') page.delete('before');
  history.replaceState(null, '', page.size ? `?${page}` : location.pathname);
  update();
}

pair.addEventListener('change', () => shown.forEach((row) => row.showMark()));
element('status').value = page.get('status') ?? '';
element('status').addEventListener('change', ({ target }) => go('status', target.value));
element('newest').addEventListener('click', () => go('before', null));
element('older').addEventListener('click', ({ target }) => go('before', target.dataset.before));
document.addEventListener('visibilitychange', update);
offerKey(update);
update();

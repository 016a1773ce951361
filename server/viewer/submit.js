// A new bake: its scene, its elevations, and how it goes.
import { Hoodoo, Problem } from './client.js';
import { DropZone } from './dem.js';
import { Editor } from './editor.js';
import { listExamples, openExample } from './examples.js';
import { marksOf, unreadable } from './findings.js';
import { AWAY, explain, isRefused, offerKey, service, withKey } from './session.js';

const CHECK_MS = 500, AGAIN_MS = 3000;
const SCENE = '/inputs/scene';  // in a request
const DRAFT = 'hoodoo-draft';
const SMALLEST = '{\n  "hoodoo": 1,\n  "name": "New terrain",\n  "terrains": [\n    {"id": "land", "dem": "dem.tif"}\n  ],\n  "bake": {"spacing": 2}\n}\n';
const element = (id) => document.getElementById(id);
const make = (tag, properties = {}) => Object.assign(document.createElement(tag), properties);

let timer = 0, noJson = false, waiting = null, checking = new AbortController(), following = new AbortController();
const editor = new Editor(element('editor'), changed);
const drops = new DropZone(assetReady);

// --- what is wrong with the scene

function changed() {
  sessionStorage.setItem(DRAFT, editor.text);
  clearTimeout(timer);
  checking.abort();
  const marks = unreadable(editor.state);
  if (marks.length > 0 || noJson) showMarks(marks);
  noJson = marks.length > 0;
  if (noJson) return;
  element('findings').classList.add('old');  // of the text before
  if (waiting) placeAsset(waiting);
  showTerrains();
  showVerdict('Checking.', '');
  timer = setTimeout(check, CHECK_MS);
}

// Asks the service, which knows more than a schema does: files, names that are used, sizes.
async function check() {
  const mine = checking = new AbortController();
  try {
    const findings = await service.validate(JSON.parse(editor.text), { signal: mine.signal });
    showMarks(marksOf(findings, editor.state));
  } catch (error) {
    if (mine.signal.aborted) return;
    const errors = error instanceof Problem ? inScene(error.errors) : [];
    if (errors.length > 0) return showMarks(marksOf(errors, editor.state));
    showVerdict(isRefused(error) ? 'It is checked when it is submitted.' : explain(error), isRefused(error) ? '' : 'bad');
    if (explain(error) === AWAY) timer = setTimeout(check, AGAIN_MS);
  }
}

// Errors of a request, as they are in the scene that it held.
function inScene(errors) {
  return errors.filter(({ pointer }) => pointer.startsWith(SCENE))
    .map(({ pointer, detail }) => ({ pointer: pointer.slice(SCENE.length), detail }));
}

function showVerdict(text, kind) {
  element('verdict').textContent = text;
  element('verdict').dataset.kind = kind;
}

function showMarks(marks) {
  editor.mark(marks);
  element('findings').classList.remove('old');
  element('findings').replaceChildren(...marks.map(({ from, message, pointer }) => {
    const button = make('button', { type: 'button', className: 'finding' });
    button.append(make('span', { className: 'line', textContent: `Line ${editor.lineOf(from)}` }));
    if (pointer) button.append(make('code', { textContent: pointer }));
    button.append(make('span', { textContent: message }));
    button.addEventListener('click', () => editor.reveal(from));
    const item = make('li');
    item.append(button);
    return item;
  }));
  const count = marks.length;
  if (count === 0) showVerdict('The scene can be baked.', 'good');
  else showVerdict(count === 1 ? 'One thing is wrong.' : `${count} things are wrong.`, 'bad');
}

// --- elevations

// A field for the elevations of each terrain; what is written there is written into the scene.
function showTerrains() {
  const scene = JSON.parse(editor.text);
  const terrains = (Array.isArray(scene?.terrains) ? scene.terrains : []).map((terrain) => terrain ?? {});
  element('terrains').hidden = terrains.length === 0;
  element('target-field').hidden = terrains.length < 2;
  const fields = element('terrain-fields'), target = element('target');
  const ids = JSON.stringify(terrains.map(({ id }) => id));
  if (fields.dataset.ids !== ids) {
    fields.dataset.ids = ids;
    fields.replaceChildren(...terrains.map(({ id }, i) => terrainField(String(id ?? i + 1), i)));
    target.replaceChildren(...terrains.map(({ id }, i) => make('option', { value: i, textContent: id ?? i + 1 })));
  }
  for (const [i, { dem }] of terrains.entries()) {
    const input = fields.children[i].querySelector('input');
    if (document.activeElement !== input) input.value = typeof dem === 'string' ? dem : '';
  }
}
function terrainField(name, i) {
  const label = make('label', { className: 'field', textContent: `${name}: ` });
  const input = make('input', { type: 'text', spellcheck: false, autocomplete: 'off' });
  input.setAttribute('list', 'assets');
  input.setAttribute('aria-label', `Elevations of ${name}`);
  input.addEventListener('change', () => editor.setString(`/terrains/${i}/dem`, input.value.trim()));
  label.append(input);
  return label;
}

function assetReady(name, file) {
  if (![...element('assets').children].some(({ value }) => value === name)) {
    element('assets').append(make('option', { value: name, label: file.name }));
  }
  placeAsset(name);
}
// Into the chosen terrain; while the text cannot be read it waits until it can.
function placeAsset(name) {
  const unread = unreadable(editor.state).length > 0;
  waiting = unread ? name : null;
  if (unread) return drops.add('It is put into the scene when that has been put right.');
  const terrain = element('target').value || 0;
  drops.add('');
  if (editor.setString(`/terrains/${terrain}/dem`, name)) return check();
  drops.add(`The scene has no terrain to put it in; its name is ${name}.`);
}

// --- examples

async function offerExamples() {
  const examples = await listExamples();
  element('example').append(...examples.map(({ name, title }) => make('option', { value: name, textContent: title })));
  element('example').addEventListener('change', async ({ target }) => {
    const example = examples.find(({ name }) => name === target.value);
    if (!example) return;
    try {
      const { text, file } = await openExample(example);
      editor.text = text;
      if (file) await drops.take(file);
      else drops.ask();
    } catch (error) {
      showVerdict(explain(error), 'bad');
    }
  });
}

// --- submission

async function submit() {
  const unread = unreadable(editor.state);
  if (unread.length > 0) {
    showMarks(unread);
    editor.reveal(unread[0].from);
    return say('The scene cannot be read.', 'bad');
  }
  if (!element('priority').reportValidity()) return say('The priority is a whole number from -10 to 10.', 'bad');
  const scene = JSON.parse(editor.text), priority = Number(element('priority').value);
  element('submit').disabled = true;
  say('Sending.', '');
  try {
    const job = await withKey(() => service.submit(scene, { priority }));
    say('The job was taken.', 'good');
    showMarks([]);
    follow(job);
  } catch (problem) {
    refuse(problem);
  } finally {
    element('submit').disabled = false;
  }
}
function say(text, kind) {
  element('submit-message').textContent = text;
  element('submit-message').dataset.kind = kind;
}

// What is wrong with the scene is marked in it, all else said beside the button.
function refuse(problem) {
  const errors = problem instanceof Problem ? problem.errors : [];
  const inside = errors.filter(({ pointer }) => pointer.startsWith(SCENE));
  if (inside.length < errors.length || inside.length === 0) say(explain(problem), 'bad');
  else say(problem.detail, 'bad');
  if (inside.length === 0) return;
  clearTimeout(timer);
  checking.abort();
  const marks = marksOf(inScene(inside), editor.state);
  showMarks(marks);
  editor.reveal(marks[0].from);
}

async function follow(first) {
  following.abort();
  const mine = following = new AbortController();
  let known = first;
  const onRetry = () => { element('job-message').textContent = `${AWAY} Trying again.`; };
  const onConnect = () => showJob(known);
  element('job').hidden = false;
  showJob(first);
  element('job').scrollIntoView({ block: 'nearest' });
  try {
    for await (const job of service.follow(first.jobID, { signal: mine.signal, onRetry, onConnect })) showJob(known = job);
  } catch (error) {
    if (!mine.signal.aborted) element('job-message').textContent = explain(error);
  }
}
function showJob(job) {
  const ended = Hoodoo.hasEnded(job);
  element('job').dataset.id = job.jobID;
  element('job-title').textContent = element('job-title').title = job.title || job.jobID;
  element('job-status').textContent = job.status;
  element('job-status').dataset.status = job.status;
  element('job-message').textContent = job.message;
  element('job-progress').value = job.progress ?? 0;
  element('job-progress').hidden = ended;
  element('job-open').href = `./?job=${job.jobID}`;
  element('job-cancel').hidden = ended;
}

element('submit').addEventListener('click', submit);
element('job-cancel').addEventListener('click', async () => {
  try {
    showJob(await withKey(() => service.dismiss(element('job').dataset.id)));
  } catch (error) {
    element('job-message').textContent = explain(error);
  }
});
offerKey(check);
offerExamples().catch((error) => showVerdict(explain(error), 'bad'));
editor.text = sessionStorage.getItem(DRAFT) || SMALLEST;

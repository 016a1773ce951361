// The panel: what can be set, and what is on screen.
import { isNarrow, make } from './card.js';
import { Hoodoo } from './client.js';
import { levelColour, MODES } from './colours.js';
import { isShortcut } from './keys.js';

const element = (id) => document.getElementById(id);
const number = new Intl.NumberFormat('en', { maximumFractionDigits: 1, notation: 'compact' });

const SWITCHES = { KeyX: 'wireframe', KeyB: 'bounds', KeyK: 'skirts', KeyL: 'shadows', KeyG: 'fog' };
const MOST_TITLE = 80; // letters of the title of the window
// The slider is logarithmic: 1 to 64 pixels.
const pixels = (slider) => 2 ** slider;

function jobLink({ jobID, title, status, created }) {
  const state = make('small', {}, `${status}, ${created.slice(0, 19).replace('T', ' ')}`);
  return make('a', { href: `?job=${jobID}`, title: title || jobID }, make('span', { className: 'name' }, title || jobID), state);
}

export class Panel {
  // `actions` has a function for each thing that can be set.
  constructor(actions) {
    this.actions = actions;
    for (const id of Object.values(SWITCHES)) {
      element(id).addEventListener('change', (event) => actions[id](event.target.checked));
    }
    for (const group of ['navigation', 'colours']) {
      element(group).addEventListener('change', (event) => actions[group](event.target.value));
    }
    element('home').addEventListener('click', () => actions.home());
    element('error').addEventListener('input', () => this.#setError());
    element('fold').addEventListener('click', () => this.fold());
    addEventListener('keydown', (event) => this.#key(event));
    element('error-close').addEventListener('click', () => { this.error_message = ''; });
    if (isNarrow()) this.fold();
    this.#setError();
  }

  choose(group, value) {
    const input = element(group).querySelector(`input[value="${CSS.escape(value)}"]`);
    if (!input || input.checked) return;
    input.checked = true;
    this.actions[group](value);
  }
  // The switches that stand otherwise than at first, as in the address: wireframe,-skirts.
  get switches() {
    const turned = Object.values(SWITCHES).map(element).filter(({ checked, defaultChecked }) => checked !== defaultChecked);
    return turned.map(({ id, checked }) => (checked ? id : `-${id}`)).join() || null;
  }
  set switches(text) {
    const said = (text ?? '').split(',');
    for (const input of Object.values(SWITCHES).map(element)) {
      const wanted = said.includes(input.id) || (input.defaultChecked && !said.includes(`-${input.id}`));
      if (input.checked !== wanted) input.click();
    }
  }
  get error() {
    return pixels(Number(element('error').value));
  }
  set error(value) {
    element('error').value = Math.log2(value);
    this.#setError();
  }
  #setError() {
    element('error-text').value = `${number.format(this.error)} px`;
    this.actions.error(this.error);
  }

  fold(unfolded = element('fold').getAttribute('aria-expanded') !== 'true') {
    element('fold').setAttribute('aria-expanded', String(unfolded));
    element('controls').hidden = !unfolded;
  }
  #key(event) {
    if (!isShortcut(event) || event.repeat) return;
    if (event.key === '?') element('help').showModal();
    else if (event.code in SWITCHES) element(SWITCHES[event.code]).click();
    else if (event.code === 'KeyO') this.choose('navigation', 'orbit');
    else if (event.code === 'KeyF') this.choose('navigation', 'fly');
    else if (event.code === 'KeyH') this.actions.home();
    else if (event.code === 'KeyU') element('panel').hidden = !element('panel').hidden;
    else if (/^Digit[1-4]$/.test(event.code)) this.choose('colours', MODES[Number(event.code[5]) - 1]);
  }

  set title(text) {
    element('title').textContent = element('title').title = text;
    document.title = `${text.length > MOST_TITLE ? `${text.slice(0, MOST_TITLE)}…` : text} - hoodoo`;
  }
  set error_message(text) {
    element('error-said').textContent = text;
    element('error-box').hidden = !text;
  }

  showJob(info) {
    const ended = Hoodoo.hasEnded(info), failed = ended && info.status !== 'successful';
    element('job').hidden = false;
    element('job-status').textContent = element('job-status').dataset.status = info.status;
    element('message').textContent = info.message;
    element('progress').value = info.progress ?? 0;
    element('progress').hidden = ended;
    element('incomplete').hidden = !failed || !(info.tiles?.done > 0);
    if (info.title) this.title = info.title;
  }
  // In place of how far a job is, which nobody knows then.
  showAway() {
    element('job').hidden = false;
    element('message').textContent = 'The server does not answer; trying again.';
    element('progress').hidden = true;
  }

  showJobs({ jobs, before }) {
    const links = jobs.map((job) => jobLink(job));
    if (links.length === 0) links.push('There are no jobs yet.');
    if (before !== undefined) links.push(make('a', { href: 'jobs.html' }, 'All jobs'));
    element('jobs').replaceChildren(...links);
    element('jobs').hidden = false;
  }
  // Where no job is shown there is nothing to set.
  showNoControls() {
    element('controls').hidden = element('fold').hidden = true;
  }
  offerKey() {
    element('key-button').hidden = false;
  }

  showStatistics({ tiles, triangles, bytes, levels, materials }, rate) {
    const rows = { Tiles: number.format(tiles), Triangles: number.format(triangles),
      Loaded: `${number.format(bytes)}B`, Frames: rate };
    element('statistics').replaceChildren(...Object.entries(rows).flatMap(([name, value]) => {
      const term = document.createElement('dt');
      const text = document.createElement('dd');
      term.textContent = name;
      text.textContent = value;
      return [term, text];
    }));
    this.#showLevels(levels);
    this.#showLegend(materials);
  }

  #showLevels(levels) {
    const most = Math.max(1, ...levels);
    element('levels').replaceChildren(...levels.map((count, level) => {
      const bar = document.createElement('div');
      const fill = document.createElement('div');
      const name = document.createElement('div');
      bar.className = 'bar';
      fill.className = 'fill';
      name.className = 'name';
      fill.style.height = `${(100 * count) / most}%`;
      fill.style.background = levelColour(level);
      name.textContent = count;
      bar.title = `${count} tiles ${level} steps below the coarsest`;
      bar.append(fill, name);
      return bar;
    }));
  }

  #showLegend(materials) {
    const shown = element('colours').querySelector('input:checked').value === 'materials';
    element('legend').hidden = !shown || materials.size === 0;
    element('legend').replaceChildren(...[...materials].sort().map(([name, colour]) => {
      const item = document.createElement('li');
      const swatch = document.createElement('span');
      swatch.className = 'swatch';
      swatch.style.background = colour;
      item.append(swatch, name);
      return item;
    }));
  }
}

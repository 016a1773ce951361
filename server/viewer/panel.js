// The panel: what can be set, and what is on screen.
import { levelColour, MODES } from './colours.js';

const element = (id) => document.getElementById(id);
const number = new Intl.NumberFormat('en', { maximumFractionDigits: 1, notation: 'compact' });

const SWITCHES = { KeyX: 'wireframe', KeyB: 'bounds', KeyK: 'skirts', KeyL: 'shadows', KeyG: 'fog' };
// The slider is logarithmic: 1 to 64 pixels.
const pixels = (slider) => 2 ** slider;

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
    element('fold').addEventListener('click', () => this.#fold());
    addEventListener('keydown', (event) => this.#key(event));
    if (matchMedia('(max-width: 480px)').matches) this.#fold();
    this.#setError();
  }

  choose(group, value) {
    const input = element(group).querySelector(`input[value="${CSS.escape(value)}"]`);
    if (!input || input.checked) return;
    input.checked = true;
    this.actions[group](value);
  }
  set error(value) {
    element('error').value = Math.log2(value);
    this.#setError();
  }
  #setError() {
    const value = pixels(Number(element('error').value));
    element('error-text').value = `${number.format(value)} px`;
    this.actions.error(value);
  }

  #fold() {
    const unfolded = element('fold').getAttribute('aria-expanded') !== 'true';
    element('fold').setAttribute('aria-expanded', String(unfolded));
    element('controls').hidden = !unfolded;
  }
  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    if (event.key === '?') element('help').showModal();
    else if (event.code in SWITCHES) element(SWITCHES[event.code]).click();
    else if (event.code === 'KeyO') this.choose('navigation', 'orbit');
    else if (event.code === 'KeyF') this.choose('navigation', 'fly');
    else if (event.code === 'KeyH') this.actions.home();
    else if (event.code === 'KeyU') element('panel').hidden = !element('panel').hidden;
    else if (/^Digit[1-4]$/.test(event.code)) this.choose('colours', MODES[Number(event.code[5]) - 1]);
  }

  set title(text) {
    element('title').textContent = text;
    document.title = `${text} - hoodoo`;
  }
  set error_message(text) {
    element('error-box').textContent = text;
    element('error-box').hidden = !text;
  }

  showJob(info) {
    element('job').hidden = false;
    element('message').textContent = info.message;
    element('progress').value = info.progress ?? 0;
    element('progress').hidden = info.status !== 'running' && info.status !== 'accepted';
    if (info.title) this.title = info.title;
  }

  showJobs(jobs) {
    const links = jobs.map((job) => {
      const link = document.createElement('a');
      link.href = `?job=${job.jobID}`;
      link.textContent = job.title || job.jobID;
      const state = document.createElement('small');
      state.textContent = `${job.status}, ${job.created.slice(0, 19).replace('T', ' ')}`;
      link.append(state);
      return link;
    });
    if (links.length === 0) links.push('There are no jobs yet.');
    element('jobs').replaceChildren(...links);
    element('jobs').hidden = false;
    element('controls').hidden = true;
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

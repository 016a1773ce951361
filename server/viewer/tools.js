// The tools, their buttons, their keys, and what of them stands in the address.
import { Vector3 } from 'three';

import { Inspector } from './inspect.js';
import { isShortcut } from './keys.js';
import { Measure } from './measure.js';
import { Picker } from './pick.js';
import { Section } from './section.js';
import { Share } from './share.js';
import { Underground } from './underground.js';

const element = (id) => document.getElementById(id);
const KEYS = { KeyI: 'inspect', KeyM: 'measure', KeyC: 'section', KeyZ: 'underground', KeyP: 'share' };
const STEP = 0.01; // of the world's size, by which , and . move the cut

const toText = (point) => point.toArray().map((value) => value.toFixed(2)).join(',');
const toPoints = (text) => (text ?? '').split(';').map((part) => part.split(',').map(Number))
  .filter((numbers) => numbers.length === 3 && numbers.every(Number.isFinite)).map((numbers) => new Vector3(...numbers));

export class Tools {
  // `changed` is called when the address should say something else; `address()` gives it.
  constructor(stage, terrains, manifests, { changed, address }) {
    Object.assign(this, { stage, changed, address });
    this.section = new Section(stage, terrains);
    this.underground = new Underground(stage, terrains);
    this.inspector = new Inspector(stage, terrains, manifests, element('inspect-card'));
    this.measure = new Measure(stage, element('measure-card'));
    this.share = new Share(element('share-card'));
    this.picker = new Picker(stage, terrains, this.section);
    this.picker.addEventListener('pick', ({ place }) => this.#pick(place));
    this.picker.addEventListener('miss', () => this.#miss());
    this.active = null; // what a click does: inspect, measure or nothing
    for (const name of Object.values(KEYS)) element(`tool-${name}`).addEventListener('click', () => this.use(name));
    element('tool-help').addEventListener('click', () => element('help').showModal());
    for (const button of document.querySelectorAll('.card .close')) {
      button.addEventListener('click', () => this.#close(button.closest('.card').id.replace('-card', '')));
    }
    for (const id of ['section-axis', 'section-level', 'section-flip']) {
      for (const type of ['click', 'input']) element(id).addEventListener(type, () => this.changed());
    }
    addEventListener('keydown', (event) => this.#key(event));
  }

  use(name) {
    if (name === 'inspect' || name === 'measure') this.#activate(this.active === name ? null : name);
    else if (name === 'section') this.section.cut(this.section.axis === null ? 0 : null);
    else if (name === 'underground') this.setUnderground(!this.underground.on);
    else this.share.show(this.address());
    this.#press();
    this.changed();
  }
  #activate(name) {
    this.active = name;
    if (name === 'inspect') this.inspector.wait();
    else this.inspector.clear();
    if (name !== 'measure') this.measure.set([]);
    else element('measure-card').hidden = false;
    this.stage.renderer.domElement.classList.toggle('picking', name !== null);
  }
  setUnderground(on) {
    this.underground.set(on);
    this.section.setUnderground(on);
    this.#press();
  }

  // The focus goes back to the button of the tool, where it was in the card.
  #close(name) {
    if (element(`${name}-card`).contains(document.activeElement)) element(`tool-${name}`).focus();
    if (name === this.active) this.use(name);
    else if (name === 'section') this.section.cut(null);
    else element(`${name}-card`).hidden = true;
    this.#press();
    this.changed();
  }
  #press() {
    const on = { inspect: this.active === 'inspect', measure: this.active === 'measure',
      section: this.section.axis !== null, underground: this.underground.on };
    for (const [name, state] of Object.entries(on)) element(`tool-${name}`).setAttribute('aria-pressed', String(state));
  }
  #pick(place) {
    if (this.active === 'inspect') this.inspector.show(place);
    if (this.active === 'measure') this.measure.add(place.point);
    if (this.active) this.changed();
  }

  #miss() {
    if (this.active === 'inspect') this.inspector.miss();
  }
  // The card that stands over the others first.
  #putAway() {
    if (!element('share-card').hidden) this.#close('share');
    else if (this.active) this.use(this.active);
    else if (this.section.axis !== null) this.#close('section');
  }

  #key(event) {
    if (event.code === 'Escape' && !document.querySelector('dialog[open]')) return this.#putAway();
    if (!isShortcut(event)) return;
    if (event.code === 'Comma' || event.code === 'Period') {
      this.section.move(event.code === 'Comma' ? -STEP : STEP);
      this.changed();
    } else if (event.repeat) {
      return;
    } else if (event.code in KEYS) {
      this.#cycle(KEYS[event.code]);
    } else if (event.code === 'KeyV' && this.section.axis !== null) {
      this.section.flip();
      this.changed();
    } else if (event.code === 'Enter' && this.active && !event.target.matches?.('button, a, input')) {
      this.picker.pickCentre();
    }
  }
  // The key of the section goes on through the axes before it ends the cut.
  #cycle(name) {
    const { axis } = this.section;
    if (name !== 'section' || axis === null || axis === 2) return this.use(name);
    this.section.cut(axis + 1);
    this.changed();
  }

  // Before a frame.
  update() {
    this.section.update();
    this.underground.follow();
  }

  // What the address says of them, and back.
  get state() {
    return {
      cut: this.section.text, under: this.underground.on ? '1' : null,
      measure: this.measure.points.length > 0 ? this.measure.points.map(toText).join(';') : null,
    };
  }
  restore({ cut, under, measure }) {
    this.section.restore(cut);
    this.setUnderground(under === '1');
    const points = toPoints(measure).slice(0, 2);
    if (points.length > 0) this.#activate('measure');
    if (points.length > 0) this.measure.set(points);
    this.#press();
  }
}

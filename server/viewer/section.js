// The cross-section: a plane along two axes that cuts the world open; which side stays can be turned.
import { Plane, Vector3 } from 'three';

import { setSurfaces } from './colours.js';
import { Cut } from './cut.js';

const AXES = ['x', 'y', 'z'];
const STEPS = 1000; // of the slider
const element = (id) => document.getElementById(id);

export class Section {
  constructor(stage, terrains) {
    Object.assign(this, { stage, terrains });
    this.axis = null; // 0, 1, 2, or null: no cut
    this.level = 0; // metres
    this.flipped = false;
    this.underground = false;
    this.plane = null;
    this.cuts = terrains.map((terrain) => new Cut(terrain));
    this.cuts.forEach((cut, i) => terrains[i].root.add(cut));
    for (const terrain of terrains) terrain.addEventListener('change', () => { this.stale = true; });
    element('section-axis').addEventListener('change', ({ target }) => this.cut(AXES.indexOf(target.value)));
    element('section-level').addEventListener('input', ({ target }) => this.#slide(Number(target.value)));
    element('section-flip').addEventListener('click', () => this.flip());
  }

  // Of all that is shown.
  get box() {
    return this.terrains.reduce((all, { box }) => (box ? all?.union(box) ?? box.clone() : all), null);
  }

  // Cuts through the middle, or at `level`, so that the camera looks at the face of the cut.
  cut(axis, level, flipped) {
    const { box } = this;
    this.axis = box ? axis : null;
    if (this.axis !== null) {
      this.level = level ?? box.getCenter(new Vector3()).getComponent(axis);
      this.flipped = flipped ?? this.stage.camera.position.getComponent(axis) < this.level;
    }
    this.#apply();
  }
  flip() {
    this.flipped = !this.flipped;
    this.#apply();
  }
  // By parts of the world's size.
  move(part) {
    if (this.axis === null) return;
    const [low, high] = this.#range();
    this.level = Math.min(high, Math.max(low, this.level + part * (high - low)));
    this.#apply();
  }
  // Inner sides are drawn underground, too.
  setUnderground(on) {
    this.underground = on;
    this.#apply();
  }

  #range() {
    const { min, max } = this.box;
    return [min.getComponent(this.axis), max.getComponent(this.axis)];
  }
  #slide(step) {
    const [low, high] = this.#range();
    this.level = low + (step / STEPS) * (high - low);
    this.#apply();
  }

  #apply() {
    if (this.axis === null) {
      this.plane = null;
    } else {
      const sign = this.flipped ? 1 : -1;
      this.plane = new Plane(new Vector3().setComponent(this.axis, sign), -sign * this.level);
    }
    setSurfaces({ plane: this.plane, bothSides: this.plane !== null || this.underground });
    for (const terrain of this.terrains) terrain.setLook({ cut: this.plane !== null });
    this.#fill();
    this.stale = true;
    this.stage.shadowsChanged();
  }
  #fill() {
    element('section-card').hidden = this.axis === null;
    if (this.axis === null || !this.box) return;
    const [low, high] = this.#range();
    element('section-axis').querySelector(`[value=${AXES[this.axis]}]`).checked = true;
    element('section-level').value = (STEPS * (this.level - low)) / (high - low);
    element('section-text').value = `${AXES[this.axis]} = ${this.level.toFixed(1)} m`;
  }

  // Before a frame: follows the tiles on screen.
  update() {
    if (!this.stale) return;
    this.stale = false;
    const { box } = this;
    this.#fill(); // the world of a running job may have grown
    for (const cut of this.cuts) {
      if (this.axis === null || !box) cut.hide();
      else cut.show(this.axis, this.level, box);
    }
    this.stage.needsRender = true;
  }

  // As in the address: x,123.4 and a minus behind it where the other side stays.
  get text() {
    return this.axis === null ? null : `${AXES[this.axis]},${this.level.toFixed(2)}${this.flipped ? ',-' : ''}`;
  }
  restore(text) {
    const [axis, level, flipped] = (text ?? '').split(',');
    const known = AXES.indexOf(axis);
    if (known < 0 || !Number.isFinite(Number(level))) this.cut(null);
    else this.cut(known, Number(level), flipped === '-');
  }
}

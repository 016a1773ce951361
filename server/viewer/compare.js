// Two tilesets side by side: tiles whose bytes differ are tinted, and listed.
import { Box3, Vector3 } from 'three';

import { isNarrow, make } from './card.js';

const MOST_ROWS = 300;
const ORDER = ['changed', 'added', 'gone'];
const count = new Intl.NumberFormat('en');

const sameLattice = (a, b) => JSON.stringify([a.lattice, a.frame]) === JSON.stringify([b.lattice, b.frame]);

// [{key, change, before, after}] by level and place, of what two bakes have; null where their tiles are of different places.
export function differences(first, second) {
  if (!sameLattice(first.header, second.header)) return null;
  const keys = new Set([...first.tiles.keys(), ...second.tiles.keys()]);
  const found = [];
  for (const key of keys) {
    const before = first.tiles.get(key), after = second.tiles.get(key);
    if (before && after && before.digests.join() === after.digests.join()) continue;
    found.push({ key, change: !before ? 'added' : !after ? 'gone' : 'changed', before, after });
  }
  const place = ({ key }) => key.split('/').map(Number);
  return found.sort((a, b) => {
    const [p, q] = [place(a), place(b)], k = p.findIndex((value, i) => value !== q[i]);
    return k < 0 ? 0 : p[k] - q[k];
  });
}

// For terrains: the change of each content.
function tints(rows, side) {
  const tint = new Map();
  for (const row of rows) for (const digest of row[side]?.digests ?? []) tint.set(digest, row.change);
  return tint;
}

export class Compare {
  // `look(box)` shows a part of the world.
  constructor(stage, terrains, manifests, look) {
    Object.assign(this, { terrains, manifests, look });
    this.rows = null; // once both are read
    this.card = document.getElementById('compare-card');
    this.card.hidden = false;
    this.card.open = !isNarrow();
    document.body.classList.add('split');
    stage.setPanes(terrains.map((shown) => () => terrains.forEach((terrain) => { terrain.root.visible = terrain === shown; })));
    this.labels = ['A', 'B'].map((name, i) => document.body.appendChild(make('p', { className: `pane pane-${i}`, textContent: name })));
    for (const terrain of terrains) terrain.addEventListener('open', () => this.read());
  }

  name(index, text) {
    this.labels[index].textContent = `${'AB'[index]}: ${text}`;
  }

  // Compares what the two have by now; of several calls the last one counts.
  async read() {
    const mine = this.reading = {};
    const bakes = await Promise.all(this.terrains.map((terrain) => this.manifests.get(terrain)?.known));
    if (this.reading !== mine) return;
    if (bakes.some((bake) => !bake)) return this.#say('Waiting for both bakes.');
    this.rows = differences(...bakes);
    if (!this.rows) return this.#say('The two have different lattices: their tiles do not cover the same places.');
    this.terrains.forEach((terrain, i) => terrain.setLook({ changes: tints(this.rows, ['before', 'after'][i]) }));
    const all = Math.max(...bakes.map(({ tiles }) => tiles.size));
    const parts = ORDER.map((change) => `${this.rows.filter((row) => row.change === change).length} ${change}`);
    this.#say(this.rows.length === 0 ? `All ${all} tiles are the same.` : `Of ${all} tiles: ${parts.join(', ')}.`);
    this.#list();
  }

  #say(text) {
    this.card.querySelector('[role=status]').textContent = text;
  }
  #list() {
    const number = (tile) => (tile ? count.format(tile.triangles) : '\u2014');
    const rows = this.rows.slice(0, MOST_ROWS).map((row) => {
      const button = make('button', { type: 'button', title: 'Look at it' }, row.key);
      button.addEventListener('click', () => this.#lookAt(row));
      const change = make('td', { className: row.change }, row.change);
      return make('tr', {}, make('td', {}, button), change, make('td', {}, number(row.before)), make('td', {}, number(row.after)));
    });
    if (this.rows.length > MOST_ROWS) {
      rows.push(make('tr', {}, make('td', { colSpan: 4 }, `and ${this.rows.length - MOST_ROWS} more`)));
    }
    this.card.querySelector('tbody').replaceChildren(...rows);
    this.card.querySelector('table').hidden = rows.length === 0;
  }
  #lookAt({ before, after }) {
    const { box } = after ?? before;
    this.look(new Box3(new Vector3(...box.slice(0, 3)), new Vector3(...box.slice(3))));
  }
}

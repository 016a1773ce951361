/** Hash tables in typed arrays: a level has millions of vertices and edges. */

const mix = (h) => {
  h = Math.imul(h ^ (h >>> 16), 0x7feb352d);
  h = Math.imul(h ^ (h >>> 15), 0x846ca68b);
  return (h ^ (h >>> 16)) >>> 0;
};
const hash2 = (a, b) => mix(mix(a) ^ Math.imul(b, 0x9e3779b1));
const hash3 = (a, b, c) => mix(hash2(a, b) ^ Math.imul(c, 0x85ebca6b));

const grown = (array) => {
  const larger = new array.constructor(array.length * 2);
  larger.set(array);
  return larger;
};
/** A power of two at least twice `count`. */
const slotsFor = (count) => 2 ** Math.ceil(Math.log2(Math.max(16, 2 * count)));

/** A typed array that grows. */
export class Column {
  constructor(Type, capacity = 1024) {
    this.data = new Type(capacity);
    this.length = 0;
  }
  push(value) {
    if (this.length === this.data.length) this.data = grown(this.data);
    this.data[this.length++] = value;
  }
}

/** Whole-number points, each stored once. */
export class PointTable {
  constructor() {
    this.count = 0;
    this.points = new Int32Array(3 * 4096);
    this.slots = new Int32Array(slotsFor(4096)).fill(-1);
  }

  /** The number of point (x, y, z), given on first sight. */
  id(x, y, z) {
    const mask = this.slots.length - 1;
    let slot = hash3(x, y, z) & mask;
    for (let id; (id = this.slots[slot]) >= 0; slot = (slot + 1) & mask) {
      const p = 3 * id;
      if (this.points[p] === x && this.points[p + 1] === y && this.points[p + 2] === z) return id;
    }
    const id = this.count++;
    if (3 * this.count > this.points.length) this.points = grown(this.points);
    this.points.set([x, y, z], 3 * id);
    this.slots[slot] = id;
    if (2 * this.count > this.slots.length) this.#rehash();
    return id;
  }

  #rehash() {
    this.slots = new Int32Array(2 * this.slots.length).fill(-1);
    const mask = this.slots.length - 1;
    for (let id = 0; id < this.count; ++id) {
      let slot = hash3(this.points[3 * id], this.points[3 * id + 1], this.points[3 * id + 2]) & mask;
      while (this.slots[slot] >= 0) slot = (slot + 1) & mask;
      this.slots[slot] = id;
    }
  }
}

/** Edges between numbered points: how often each is walked upward and downward, and its first corner. */
export class EdgeTable {
  /** `most`: no more edges than this will come. */
  constructor(most) {
    const slots = slotsFor(most);
    this.low = new Int32Array(slots).fill(-1);
    this.high = new Int32Array(slots);
    this.corner = new Int32Array(slots);
    this.up = new Uint8Array(slots);
    this.down = new Uint8Array(slots);
    this.count = 0;
  }

  /** Adds the edge from `from` to `to` that starts at `corner` of a face; gives its slot. */
  add(from, to, corner) {
    const low = Math.min(from, to), high = Math.max(from, to), mask = this.low.length - 1;
    let slot = hash2(low, high) & mask;
    while (this.low[slot] >= 0 && (this.low[slot] !== low || this.high[slot] !== high)) {
      slot = (slot + 1) & mask;
    }
    if (this.low[slot] < 0) {
      this.low[slot] = low;
      this.high[slot] = high;
      this.corner[slot] = corner;
      ++this.count;
    }
    const walks = from < to ? this.up : this.down;
    if (walks[slot] < 255) ++walks[slot];
    return slot;
  }

  /** Calls `visit(slot)` for every edge. */
  forEach(visit) {
    for (let slot = 0; slot < this.low.length; ++slot) if (this.low[slot] >= 0) visit(slot);
  }
}

/** Counts the faces of `corners` (three point numbers each) that name the same points as an earlier one. */
export const countDuplicateFaces = (corners, faces) => {
  const slots = new Int32Array(slotsFor(faces)).fill(-1), mask = slots.length - 1;
  const sorted = (face) => {
    let a = corners[3 * face], b = corners[3 * face + 1], c = corners[3 * face + 2];
    if (a > b) [a, b] = [b, a];
    if (b > c) [b, c] = [c, b];
    if (a > b) [a, b] = [b, a];
    return [a, b, c];
  };
  let duplicates = 0;
  for (let face = 0; face < faces; ++face) {
    const [a, b, c] = sorted(face);
    let slot = hash3(a, b, c) & mask;
    for (; slots[slot] >= 0; slot = (slot + 1) & mask) {
      const [d, e, f] = sorted(slots[slot]);
      if (a === d && b === e && c === f) break;
    }
    if (slots[slot] >= 0) ++duplicates;
    else slots[slot] = face;
  }
  return duplicates;
};

/** Disjoint sets of 0 .. count-1. */
export class DisjointSets {
  constructor(count) {
    this.parent = new Int32Array(count);
    for (let i = 0; i < count; ++i) this.parent[i] = i;
  }
  find(i) {
    while (this.parent[i] !== i) i = this.parent[i] = this.parent[this.parent[i]];
    return i;
  }
  unite(i, j) {
    const a = this.find(i), b = this.find(j);
    if (a !== b) this.parent[Math.max(a, b)] = Math.min(a, b);
  }
}

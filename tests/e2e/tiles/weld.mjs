/** One level of a tileset welded by exact position: is it one closed, oriented, manifold surface? */
import { Column, DisjointSets, EdgeTable, PointTable, countDuplicateFaces } from './tables.mjs';

const sides = ['west', 'east', 'south', 'north'];
export const opposite = { west: 'east', east: 'west', south: 'north', north: 'south' };

/**
 * `units`: steps per lattice cell; `cells`: along a tile's side. Tiles come one by one through `add`; then `finish` says what was found.
 * Coordinates are whole steps in the scene frame.
 */
export class Level {
  constructor(units, cells) {
    this.units = units;
    this.size = units * cells;
    this.points = new PointTable();
    this.corners = new Column(Int32Array);
    this.owners = new Column(Int32Array);   // per face: number of its tile
    this.tiles = [];
    this.borders = new Map();   // "x/y" -> side -> Map(point -> [normals as text])
    this.degenerate = 0;
  }

  /** `tile`: {x, y, steps, triangles, borders: side -> {vertices, normals}} as examine.mjs gives it. */
  add(tile) {
    const { steps, triangles } = tile;
    const owner = this.tiles.push({ x: tile.x, y: tile.y }) - 1;
    const ids = new Int32Array(steps.length / 3);
    for (let i = 0; i < ids.length; ++i) {
      ids[i] = this.points.id(steps[3 * i], steps[3 * i + 1], steps[3 * i + 2]);
    }
    for (let i = 0; i < triangles.length; i += 3) {
      const a = ids[triangles[i]], b = ids[triangles[i + 1]], c = ids[triangles[i + 2]];
      if (this.#isDegenerate(a, b, c)) {
        ++this.degenerate;
        continue;
      }
      this.corners.push(a);
      this.corners.push(b);
      this.corners.push(c);
      this.owners.push(owner);
    }
    const key = `${tile.x}/${tile.y}`;
    const borders = this.borders.get(key) ?? Object.fromEntries(sides.map((s) => [s, new Map()]));
    this.borders.set(key, borders);
    for (const side of sides) {
      const { vertices, normals } = tile.borders[side];
      for (let i = 0; i < vertices.length; ++i) {
        const point = ids[vertices[i]], normal = normals.subarray(3 * i, 3 * i + 3).join();
        const known = borders[side].get(point);
        if (!known) borders[side].set(point, [normal]);
        else if (!known.includes(normal)) known.push(normal);
      }
    }
  }

  /** No area, to the last step: the products stay below 2^53. */
  #isDegenerate(a, b, c) {
    if (a === b || b === c || c === a) return true;
    const p = this.points.points;
    const side = (i, k) => p[3 * i + k] - p[3 * a + k];
    const [ux, uy, uz, vx, vy, vz] = [side(b, 0), side(b, 1), side(b, 2), side(c, 0), side(c, 1), side(c, 2)];
    return uy * vz === uz * vy && uz * vx === ux * vz && ux * vy === uy * vx;
  }

  finish() {
    const faces = this.corners.length / 3, corner = this.corners.data;
    const edges = new EdgeTable(3 * faces);
    const fans = new DisjointSets(3 * faces), parts = new DisjointSets(this.points.count);
    const next = (c) => c - (c % 3) + ((c + 1) % 3);
    for (let c = 0; c < 3 * faces; ++c) {
      const from = corner[c], to = corner[next(c)];
      const slot = edges.add(from, to, c);
      parts.unite(from, to);
      // Corners of one point belong to one fan where their faces share an edge there.
      const first = edges.corner[slot];
      if (first === c) continue;
      const same = corner[first] === from;
      fans.unite(c, same ? first : next(first));
      fans.unite(next(c), same ? next(first) : first);
    }
    const open = this.#openEdges(edges);
    const used = new Uint8Array(this.points.count), fanOf = new Int32Array(this.points.count).fill(-1);
    const pinched = new Set();
    for (let c = 0; c < 3 * faces; ++c) {
      const point = corner[c], fan = fans.find(c);
      used[point] = 1;
      if (fanOf[point] < 0) fanOf[point] = fan;
      else if (fanOf[point] !== fan && !open.at[point]) pinched.add(point);
    }
    let vertices = 0, components = 0;
    for (let i = 0; i < used.length; ++i) {
      vertices += used[i];
      components += used[i] && parts.find(i) === i ? 1 : 0;
    }
    return {
      faces, vertices, edges: edges.count, euler: vertices - edges.count + faces, components,
      degenerate: this.degenerate, duplicate: countDuplicateFaces(corner, faces), pinched: pinched.size,
      overused: open.overused, turned: open.turned, openEdges: open.count, openLoops: open.loops,
      openOffLattice: open.offLattice, openInside: open.inside, cracks: open.cracks,
      ...this.#matchBorders(open.at),
    };
  }

  /** Edges that have not two faces walking them in opposite directions. */
  #openEdges(edges) {
    const { points } = this.points, { units, size } = this;
    const found = { count: 0, overused: 0, turned: 0, offLattice: 0, inside: 0, cracks: 0, loops: 0 };
    found.at = new Uint8Array(this.points.count);   // 1: on an open edge in a plane of x, 2: of y
    const rims = new DisjointSets(this.points.count), columns = new Map();
    const outline = this.#outline();
    edges.forEach((slot) => {
      const walks = edges.up[slot] + edges.down[slot];
      if (walks > 2) ++found.overused;
      else if (walks === 2 && edges.up[slot] !== 1) ++found.turned;
      if (walks !== 1) return;
      ++found.count;
      const a = edges.low[slot], b = edges.high[slot];
      const tile = this.tiles[this.owners.data[Math.floor(edges.corner[slot] / 3)]];
      rims.unite(a, b);
      const onPlane = (k) => points[3 * a + k] === points[3 * b + k] && points[3 * a + k] % units === 0;
      const axes = [0, 1].filter(onPlane);
      if (axes.length === 0) ++found.offLattice;
      let atEdge = false;
      for (const k of axes) {
        found.at[a] |= 1 << k;
        found.at[b] |= 1 << k;
        const plane = points[3 * a + k];
        atEdge ||= plane === outline[k] || plane === outline[2 + k];
        if (axes.length > 1 || plane % size !== 0) continue;
        const side = (k === 0 ? tile.x : tile.y) * size === plane ? 2 : 1;
        const along = [points[3 * a + 1 - k], points[3 * b + 1 - k]].sort((p, q) => p - q);
        for (let column = Math.floor(along[0] / units); column * units < along[1]; ++column) {
          const name = `${k} ${plane} ${column}`;
          columns.set(name, (columns.get(name) ?? 0) | side);
        }
      }
      if (!atEdge) ++found.inside;
    });
    // Where the world ends between two tiles, one of them has nothing in that column of the lattice.
    // Open on both sides: a crack.
    for (const both of columns.values()) if (both === 3) ++found.cracks;
    for (let i = 0; i < found.at.length; ++i) if (found.at[i] && rims.find(i) === i) ++found.loops;
    return found;
  }

  /** Low and high x and y of all points: [x, y, X, Y]. */
  #outline() {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 0; i < this.points.count; ++i) {
      for (let k = 0; k < 2; ++k) {
        box[k] = Math.min(box[k], this.points.points[3 * i + k]);
        box[2 + k] = Math.max(box[2 + k], this.points.points[3 * i + k]);
      }
    }
    return box;
  }

  /** Every vertex on a plane between two tiles has a partner there with the same normal, to the bit. */
  #matchBorders(open) {
    const found = { borderVertices: 0, positionMismatches: 0, normalMismatches: 0 };
    const compare = (own, other, bit) => {
      for (const [point, normals] of own) {
        const partner = other.get(point);
        if (!partner && open[point] & bit) continue;   // the world ends there: see `cracks`
        found.borderVertices += normals.length;
        if (!partner) found.positionMismatches += normals.length;
        else found.normalMismatches += normals.filter((n) => !partner.includes(n)).length;
      }
    };
    for (const [key, borders] of this.borders) {
      const [x, y] = key.split('/').map(Number);
      for (const [side, dx, dy, bit] of [['east', 1, 0, 1], ['north', 0, 1, 2]]) {
        const neighbour = this.borders.get(`${x + dx}/${y + dy}`);
        if (!neighbour) continue;
        compare(borders[side], neighbour[opposite[side]], bit);
        compare(neighbour[opposite[side]], borders[side], bit);
      }
    }
    return found;
  }
}

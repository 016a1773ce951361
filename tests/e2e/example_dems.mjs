/**
 * Writes the DEMs of those examples that need another landscape than the coast of `hoodoo synthesize`:
 *
 *     node example_dems.mjs [NAME ...]
 *
 * Each is a formula and noise, rounded to 1/32 m so that it packs well. Lengths in metres, y to the north.
 */
import { join, resolve } from 'node:path';
import { writeDem } from './dem.mjs';

const folder = resolve(import.meta.dirname, '../../schema/examples');

const clamp = (t, low, high) => Math.min(Math.max(t, low), high);
const mix = (a, b, t) => a + (b - a) * t;

/** 0 at `from`, 1 at `to`, flat at both. */
function step(from, to, value) {
  const t = clamp((value - from) / (to - from), 0, 1);
  return t * t * (3 - 2 * t);
}

/** A number in [-1, 1) of a lattice point. */
function lattice(i, j, seed) {
  let h = Math.imul(i, 0x9e3779b1) ^ Math.imul(j, 0x85ebca6b) ^ Math.imul(seed, 0xc2b2ae35);
  h = Math.imul(h ^ (h >>> 15), 0x2c1b3c6d);
  h = Math.imul(h ^ (h >>> 12), 0x297a2d39);
  return ((h ^ (h >>> 15)) >>> 0) / 2 ** 31 - 1;
}

/** Value noise in [-1, 1]; `octaves` layers, each half as large and half as high. */
function noise(x, y, wavelength, octaves, seed) {
  let sum = 0, most = 0;
  for (let k = 0, height = 1, scale = 1 / wavelength; k < octaves; ++k, height /= 2, scale *= 2) {
    const i = Math.floor(x * scale), j = Math.floor(y * scale);
    const u = step(0, 1, x * scale - i), v = step(0, 1, y * scale - j), s = seed * 16 + k;
    sum += height * mix(mix(lattice(i, j, s), lattice(i + 1, j, s), u), mix(lattice(i, j + 1, s), lattice(i + 1, j + 1, s), u), v);
    most += height;
  }
  return sum / most;
}

/** Distance to the curve y = middle(x), across its own direction. */
const across = (x, y, middle) => Math.abs(y - middle(x)) / Math.hypot(1, middle(x + 0.5) - middle(x - 0.5));

/** How deep (x, y) lies in a bowl, from 0 at its rim to 1. */
const bowl = (x, y, [bx, by, radius]) => 1 - step(0.15 * radius, radius, Math.hypot(x - bx, y - by));

/** A narrow canyon that winds through a bare plateau. */
function slotCanyon(x, y) {
  const middle = (at) => 190 + 52 * Math.sin(at / 40) + 24 * Math.sin(at / 19 + 1.2);
  const off = across(x, y, middle) + 4 * noise(x, y, 30, 2, 1);
  const floor = 16 - x / 30 + noise(x, y, 14, 2, 2) - 1.5 * (1 - step(0, 5, off));
  const top = 78 + 12 * noise(x, y, 120, 3, 3) + 2 * noise(x, y, 24, 2, 4);
  return mix(floor, top, 0.66 * step(8, 20, off) + 0.1 * step(20, 40, off) + 0.24 * step(34, 80, off));
}

/** A broad canyon whose river swings from wall to wall, on its way south. */
function broadCanyon(x, y) {
  const river = (at) => 250 + 98 * Math.sin(at / 72 - 1.9);
  const valley = (at) => 250 + 44 * Math.sin(at / 72 - 1.9);
  const off = across(y, x, valley) + 9 * noise(x, y, 70, 3, 11), bed = across(y, x, river);
  const floor = 10 + y / 45 + 0.03 * bed + 0.4 * noise(x, y, 25, 3, 12) - 1.2 * (1 - step(3, 14, bed));
  const top = 66 + 8 * noise(x, y, 130, 3, 13);
  return mix(floor, top, 0.62 * step(54, 70, off) + 0.06 * step(70, 84, off) + 0.32 * step(84, 100, off));
}

/** A plateau pitted by dolines that ends in a cliff over a valley. */
function dolines(x, y) {
  const pits = [[222, 128, 30], [262, 80, 28], [330, 190, 40], [235, 236, 28], [345, 300, 36], [240, 345, 32], [420, 120, 30], [415, 245, 24], [400, 390, 38], [305, 420, 24]];
  const edge = 165 + 34 * noise(0, y, 110, 2, 21) + 10 * noise(x, y, 34, 2, 22);
  let plateau = 92 + 7 * noise(x, y, 130, 3, 23) + noise(x, y, 18, 2, 24);
  for (const pit of pits) plateau -= 0.42 * pit[2] * bowl(x + 4 * noise(x, y, 30, 2, 25), y, pit);
  const valley = 8 + 0.05 * x + 4 * noise(x, y, 60, 3, 26);
  return mix(valley, plateau, 0.12 * step(-75, -10, x - edge) + 0.88 * step(-9, 13, x - edge));
}

/** Level ground with three funnels. */
function funnels(x, y) {
  let ground = 100 + 2.5 * noise(x, y, 80, 3, 31) + 0.6 * noise(x, y, 16, 2, 32);
  for (const pit of [[82, 56, 17], [86, 104, 21], [84, 152, 15]]) ground -= 0.5 * pit[2] * bowl(x, y, pit);
  return ground;
}

/** A low cliff with bays over a shallow sea. */
function bays(x, y) {
  const shore = 150 + 26 * noise(0, y, 90, 2, 41) + 7 * noise(x, y, 26, 3, 42);
  const sea = -3 - 0.02 * (150 - x) + 0.6 * noise(x, y, 20, 2, 43);
  return mix(sea, 27 + 4 * noise(x, y, 90, 3, 44) + 0.02 * x, step(-7, 7, x - shore));
}

/** Two walls of rock on either side of a dry valley. */
function gap(x, y) {
  const off = Math.abs(x - 200 - 22 * Math.sin(y / 70) - 12 * noise(0, y, 80, 2, 51)) + 7 * noise(x, y, 40, 3, 52);
  const floor = 12 + 0.02 * y + 0.05 * off + 2 * noise(x, y, 40, 3, 53);
  const top = 74 + 7 * noise(x, y, 110, 3, 54);
  return mix(floor, top, 0.12 * step(20, 40, off) + 0.68 * step(36, 54, off) + 0.2 * step(60, 78, off));
}

/** An amphitheatre below a rim: ribs run down from it to badlands. */
function ribs(x, y) {
  const wander = 7 * noise(x, y, 60, 2, 61);
  const rib = 1 - Math.abs(Math.sin((Math.PI * (y + wander)) / 27));
  const rim = 196 + 16 * noise(0, y, 70, 2, 62);
  const fall = 10 + 44 * step(20, rim - 16, x + 6 * noise(x, y, 30, 2, 63)) + 22 * step(rim - 14, rim + 4, x);
  const tall = 15 * step(30, 90, x) * (1 - step(rim - 40, rim - 4, x));
  return fall + tall * rib ** 1.6 + noise(x, y, 18, 3, 64);
}

const dems = {
  'slot-canyon': [200, 2, slotCanyon],
  'canyon-overhangs': [200, 2.5, broadCanyon],
  'karst-plateau': [200, 2.5, dolines],
  'karst-section': [104, 2, funnels],
  'hoodoo-blocks': [130, 2, ribs],
  'rock-bridge': [160, 2.5, gap],
  'sea-cave': [150, 2, bays],
};

for (const name of process.argv.length > 2 ? process.argv.slice(2) : Object.keys(dems)) {
  const [side, spacing, height] = dems[name];
  const at = (i, j) => height((i + 0.5) * spacing, (side - 0.5 - j) * spacing);
  await writeDem(join(folder, name, 'dem.tif'), side, spacing, (i, j) => Math.round(32 * at(i, j)) / 32, { deflated: true });
}

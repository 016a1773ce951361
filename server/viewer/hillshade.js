// A small picture of an elevation model: the light from the north-west on it.
import { fromBlob } from './vendor/geotiff.js';

const SIDE = 480;
const MOST_PIXELS = 48e6;  // read at once, where a file has no overview
const METRES_PER_DEGREE = 111_320;
const LIGHT = [-0.5, 0.5, Math.SQRT1_2];
const LOW = [84, 104, 82], MIDDLE = [186, 152, 106], HIGH = [244, 238, 228];

// Of all pictures of the file, the smallest that is large enough.
async function choose(tiff) {
  const full = await tiff.getImage(0);
  let chosen = full;
  for (let i = 1; i < await tiff.getImageCount(); ++i) {
    const image = await tiff.getImage(i);
    const [width, height] = [image.getWidth(), image.getHeight()];
    const same = Math.abs(width / height - full.getWidth() / full.getHeight()) < 0.05;
    if (same && Math.max(width, height) >= SIDE && width < chosen.getWidth()) chosen = image;
  }
  return { full, chosen };
}

// What of it is read: all, or as much from its middle as can be.
function windowOf(width, height) {
  if (width * height <= MOST_PIXELS) return [0, 0, width, height];
  const side = Math.floor(Math.sqrt(MOST_PIXELS) / 4);
  const [w, h] = [Math.min(width, side), Math.min(height, side)];
  const [x, y] = [Math.floor((width - w) / 2), Math.floor((height - h) / 2)];
  return [x, y, x + w, y + h];
}

// Metres per pixel [x, y] of the full picture.
function spacingOf(image) {
  try {
    const [x, y] = image.getResolution().map(Math.abs);
    if (image.getGeoKeys()?.GTModelTypeGeoKey !== 2) return [x, y];
    const [, south, , north] = image.getBoundingBox();
    return [x * METRES_PER_DEGREE * Math.cos((south + north) * Math.PI / 360), y * METRES_PER_DEGREE];
  } catch {
    return null;  // it has no place
  }
}

// The surface of a GeoTIFF: {heights, width, height, spacing, size, part}, NaN where nothing is known.
export async function readRelief(file) {
  const { full, chosen } = await choose(await fromBlob(file));
  const [width, height] = [chosen.getWidth(), chosen.getHeight()];
  const window = windowOf(width, height);
  const [w, h] = [window[2] - window[0], window[3] - window[1]];
  const scale = Math.min(1, SIDE / Math.max(w, h));
  const to = [Math.max(1, Math.round(w * scale)), Math.max(1, Math.round(h * scale))];
  const read = await chosen.readRasters({ window, width: to[0], height: to[1], samples: [0], interleave: true });
  const none = full.getGDALNoData();
  const heights = Float32Array.from(read, (value) => (value === none || Math.abs(value) > 1e6 ? NaN : value));
  const spacing = spacingOf(full);
  const shown = spacing ?? [1, 1];
  return {
    heights, width: to[0], height: to[1], size: [full.getWidth(), full.getHeight()], spacing, part: w < width || h < height,
    step: [shown[0] * full.getWidth() / width * w / to[0], shown[1] * full.getHeight() / height * h / to[1]],
  };
}

const mix = (a, b, t) => a.map((value, i) => value + (b[i] - value) * t);
const tint = (t) => (t < 0.5 ? mix(LOW, MIDDLE, 2 * t) : mix(MIDDLE, HIGH, 2 * t - 1));

// Its picture: {rgba, least, most, holes}, clear where nothing is known; `holes` is the share of that.
export function shade({ heights, width, height, step }) {
  let least = Infinity, most = -Infinity, known = 0;
  for (const z of heights) {
    if (Number.isNaN(z)) continue;
    least = Math.min(least, z);
    most = Math.max(most, z);
    ++known;
  }
  const rgba = new Uint8ClampedArray(4 * width * height);
  const at = (i, j, other) => {
    const z = heights[Math.min(Math.max(j, 0), height - 1) * width + Math.min(Math.max(i, 0), width - 1)];
    return Number.isNaN(z) ? other : z;
  };
  for (let j = 0; j < height; ++j) {
    for (let i = 0; i < width; ++i) {
      const k = j * width + i, z = heights[k];
      if (Number.isNaN(z)) continue;
      const east = (at(i + 1, j, z) - at(i - 1, j, z)) / (2 * step[0]);
      const north = (at(i, j - 1, z) - at(i, j + 1, z)) / (2 * step[1]);
      const lit = Math.max(0, (LIGHT[2] - east * LIGHT[0] - north * LIGHT[1]) / Math.hypot(east, north, 1));
      const colour = tint((z - least) / Math.max(most - least, 1e-6));
      rgba.set([...colour.map((value) => value * (0.25 + lit)), 255], 4 * k);
    }
  }
  return { rgba, least, most, holes: 1 - known / heights.length };
}

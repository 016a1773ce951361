/** Writes a GeoTIFF whose directory stands first, so that a file cut short still says what it should hold. */
import { writeFile } from 'node:fs/promises';
import { deflateSync } from 'node:zlib';

const header = 8;
const short = 3, long = 4, double = 12;
const widths = { [short]: 2, [long]: 4, [double]: 8 };

/**
 * `side` x `side` pixels of `spacing` metres in a UTM zone, float32 in square tiles, deflated or plain; `height(i, j)` [m] from the
 * north-west. `tile` is their side [pixels], a multiple of 16.
 */
export async function writeDem(file, side, spacing, height, { deflated = false, tile = 256 } = {}) {
  const across = Math.ceil(side / tile), tiles = across * across;
  const blocks = Array.from({ length: tiles }, () => Buffer.alloc(4 * tile * tile));
  for (let j = 0; j < side; ++j) {
    for (let i = 0; i < side; ++i) {
      const block = blocks[Math.floor(j / tile) * across + Math.floor(i / tile)];
      block.writeFloatLE(height(i, j), 4 * ((j % tile) * tile + (i % tile)));
    }
  }
  const stored = deflated ? blocks.map((block) => deflateSync(block, { level: 9 })) : blocks;
  const tags = [
    [256, short, [side]], [257, short, [side]], [258, short, [32]], [259, short, [deflated ? 8 : 1]], [262, short, [1]],
    [277, short, [1]], [322, short, [tile]], [323, short, [tile]],
    [324, long, Array(tiles).fill(0)], [325, long, stored.map((block) => block.length)], [339, short, [3]],
    [33550, double, [spacing, spacing, 0]], [33922, double, [0, 0, 0, 500000, 5000000, 0]],
    [34735, short, [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632]],
  ];
  // What is longer than four bytes stands behind the directory.
  let end = header + 2 + 12 * tags.length + 4;
  const places = tags.map(([, type, values]) => {
    const size = widths[type] * values.length, at = end;
    if (size > 4) end += size + (size % 2);
    return at;
  });
  const offsets = tags.find(([tag]) => tag === 324)[2];
  for (const [k, block] of stored.entries()) {
    offsets[k] = end;
    end += block.length;
  }
  const out = Buffer.alloc(end);
  const put = { [short]: 'writeUInt16LE', [long]: 'writeUInt32LE', [double]: 'writeDoubleLE' };
  out.write('II*\0', 'latin1');
  out.writeUInt32LE(header, 4);
  out.writeUInt16LE(tags.length, header);
  tags.forEach(([tag, type, values], k) => {
    const entry = header + 2 + 12 * k, long_ = widths[type] * values.length > 4;
    out.writeUInt16LE(tag, entry);
    out.writeUInt16LE(type, entry + 2);
    out.writeUInt32LE(values.length, entry + 4);
    if (long_) out.writeUInt32LE(places[k], entry + 8);
    values.forEach((value, i) => out[put[type]](value, (long_ ? places[k] : entry + 8) + i * widths[type]));
  });
  for (const [k, block] of stored.entries()) block.copy(out, offsets[k]);
  await writeFile(file, out);
}

// bake.json beside a tileset: what the bake knows of each tile. It is one document, or JSON Lines where there are many
// tiles: a header, then a line per tile.

// The name of a tile's file is the digest of its content.
export const digestOf = (uri) => /([0-9a-f]{64})\.glb$/.exec(uri ?? '')?.[1] ?? null;

async function readText(response, take) {
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    take(value);
  }
}

// Calls `take(tile)` for each finished tile and gives the header. Lines are read as they come; of a document there is
// only one.
async function readBake(response, take) {
  let text = '', header = null, document = false;
  const takeLine = (line) => {
    if (header) take(JSON.parse(line));
    else header = JSON.parse(line);
  };
  await readText(response, (part) => {
    text += part;
    if (!header && !document && text.includes('\n')) document = !/^\{.*\}\n/.test(text);
    if (document) return;
    const lines = text.split('\n');
    text = lines.pop();
    lines.filter(Boolean).forEach(takeLine);
  });
  if (!text.trim()) return header;
  const { tiles, ...rest } = JSON.parse(text);
  tiles.forEach(take);
  return rest;
}

export class Manifest {
  constructor(tileset) {
    this.url = new URL('bake.json', tileset);
    this.bake = null; // a promise of what was read last
  }

  // What stands there now: {header, tiles: Map by key, contents: Map from digests of contents to tiles}, or null
  // where there is no bake.json.
  read() {
    this.bake = this.#load();
    return this.bake;
  }
  // What was read last, or else what stands there now.
  get known() {
    return this.bake ?? this.read();
  }
  async #load() {
    const response = await fetch(this.url, { cache: 'no-cache' });
    if (!response.ok) return null;
    const tiles = new Map(), contents = new Map();
    const header = await readBake(response, (tile) => {
      const digests = tile.contents?.map(({ content }) => content) ?? (tile.content ? [tile.content] : []);
      if (digests.length === 0) return; // missing, or without a surface
      const { neighbours, ...kept } = { ...tile, digests };
      tiles.set(tile.key, kept);
      for (const digest of digests) contents.set(digest, kept);
    });
    return { header, tiles, contents };
  }

  // The header and the tile whose file has the digest, or null; asks again where a running bake may have added it.
  async find(digest) {
    const old = this.bake !== null;
    let bake = await this.known;
    if (old && bake && !bake.contents.has(digest)) bake = await this.read();
    const tile = bake?.contents.get(digest);
    return tile ? { header: bake.header, tile } : null;
  }
}

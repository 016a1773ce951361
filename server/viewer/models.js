// The models of tiles that are loaded, by the digests of their contents. A tileset that is read once more, as it is at each
// change of a running bake, takes them over: what is there is neither fetched nor parsed again.
import { Group, Mesh } from 'three';

import { wire } from './colours.js';
import { digestOf } from './manifest.js';

// Null where the name of a file says nothing of its content.
function keyOf({ content, contents }) {
  const digests = (contents ?? [content]).map((each) => digestOf(each?.uri));
  return digests.every(Boolean) ? digests.join() : null;
}

// Another node for the same geometry.
function twin(node) {
  const copy = node.isMesh ? new Mesh(node.geometry, node.material) : new Group();
  Object.assign(copy, { name: node.name, frustumCulled: node.frustumCulled, userData: { ...node.userData } });
  copy.position.copy(node.position);
  copy.quaternion.copy(node.quaternion);
  copy.scale.copy(node.scale);
  for (const child of node.children) if (child.material !== wire) copy.add(twin(child));
  return copy;
}

// Leaves what others show out of what is disposed of with a tile.
function release({ engineData }) {
  engineData.scene.traverse(({ userData }) => {
    delete userData.structuralMetadata;
    delete userData.meshFeatures;
  });
  Object.assign(engineData, { materials: [], geometry: [], textures: [] });
}

export class Models {
  constructor() {
    this.bytes = 0; // fetched
    this.tiles = new Map(); // that show a model, as a Set, by its key
  }

  // A tile with the model, or null.
  of(key) {
    const [tile] = this.tiles.get(key) ?? [];
    return tile ?? null;
  }
  add(tile) {
    const key = keyOf(tile);
    if (!key) return;
    if (!this.tiles.has(key)) this.tiles.set(key, new Set());
    this.tiles.get(key).add(tile);
  }
  remove(tile) {
    const key = keyOf(tile), others = this.tiles.get(key);
    if (!others?.delete(tile)) return;
    if (others.size > 0) release(tile);
    else this.tiles.delete(key);
  }
  // Counts what comes.
  async fetch(url, options) {
    const response = await fetch(url, options);
    this.bytes += Number(response.headers.get('content-length')) || 0;
    return response;
  }
}

// Stands for the bytes of a tile whose model is there.
class Kept {}

// Lets the tiles of a renderer use `models`.
export class Sharing {
  constructor(models) {
    this.name = 'SHARING';
    this.models = models;
    this.keys = new Map(); // of tiles, by the addresses of their first contents
    this.loaded = new Set();
  }
  init(tiles) {
    tiles.addEventListener('load-model', ({ tile }) => {
      this.loaded.add(tile);
      this.models.add(tile);
    });
  }
  // Before the tiles of the renderer are disposed of, of which it is not told one by one.
  dispose() {
    for (const tile of this.loaded) this.disposeTile(tile);
  }

  preprocessURL(url, tile) {
    if (tile) this.keys.set(url, keyOf(tile));
    return url;
  }
  fetchData(url, options) {
    const key = this.keys.get(url);
    return key && this.models.of(key) ? Promise.resolve(new Kept()) : this.models.fetch(url, options);
  }
  // Nothing where the renderer is to parse bytes.
  parseTile(content, tile, extension, url, signal) {
    return content instanceof Kept ? this.#take(tile, url, signal) : null;
  }
  async #take(tile, url, signal) {
    const from = this.models.of(keyOf(tile))?.engineData;
    if (!from) throw new Error(`${url}: its model has gone`); // and is fetched when it is asked for again
    if (signal.aborted) return;
    const { materials, geometry, textures, metadata } = from;
    const scene = twin(from.scene);
    // The frame of the tile may be another one in this tileset.
    scene.matrix.compose(scene.position, scene.quaternion, scene.scale)
      .premultiply(from.transform.clone().invert()).premultiply(tile.engineData.transform)
      .decompose(scene.position, scene.quaternion, scene.scale);
    scene.traverse((node) => { node.userData.tile = tile; });
    Object.assign(tile.engineData, { scene, materials, geometry, textures, metadata });
  }
  disposeTile(tile) {
    this.loaded.delete(tile);
    this.models.remove(tile);
  }
}

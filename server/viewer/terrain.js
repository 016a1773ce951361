// The tileset: streaming, how its tiles look, and what is on screen.
import { Box3, EventDispatcher, Group, Matrix4, Mesh } from 'three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { TilesRenderer } from '3d-tiles-renderer/three';
import { GLTFExtensionsPlugin } from '3d-tiles-renderer/three/plugins';

import { Bounds } from './bounds.js';
import { colourMesh, wire } from './colours.js';
import { Contents } from './contents.js';
import { digestOf } from './manifest.js';
import { Models, Sharing } from './models.js';
import { Patience } from './patience.js';

const FRAMES_OF_REST = 10;

const isSkirt = (mesh) => mesh.geometry.userData.hoodoo?.role === 'skirt';
const triangleCount = (mesh) => (mesh.geometry.index ?? mesh.geometry.attributes.position).count / 3;

// Fires 'open' when a tileset is asked for, 'change' when the picture changes, 'ready' at the first tile,
// 'error' with a message, 'recovered' when all has come after one.
export class Terrain extends EventDispatcher {
  constructor(stage) {
    super();
    this.stage = stage;
    this.root = new Group(); // all that belongs to it
    this.group = new Group(); // its tiles
    this.bounds = new Bounds();
    this.root.add(this.group, this.bounds);
    stage.scene.add(this.root);
    this.draco = new DRACOLoader().setDecoderPath('vendor/three/examples/jsm/libs/draco/gltf/');
    this.look = { colours: 'natural', wireframe: false, skirts: true, underground: false, cut: false, changes: null };
    this.errorTarget = 8;
    this.models = new Models();
    this.patience = new Patience();
    this.calm = null; // frames in which nothing was missing after an error, or null without one
    this.current = null; // on screen
    this.next = null; // loading, to take its place
    this.rested = 0; // frames that `next` has asked for nothing
  }

  // Shows a tileset, or the same once more when it has changed. What is on screen stays there until
  // the new one is complete; one change more in that time is taken up afterwards.
  open(url) {
    this.url = url;
    this.dispatchEvent({ type: 'open' });
    this.stale = this.next !== null;
    if (!this.stale) this.next = this.#load();
  }

  #load() {
    const tiles = new TilesRenderer(this.url);
    tiles.registerPlugin(new Sharing(this.models));
    tiles.registerPlugin(new GLTFExtensionsPlugin({
      dracoLoader: this.draco, meshoptDecoder: MeshoptDecoder, metadata: true,
    }));
    tiles.registerPlugin(new Contents((url, options) => this.models.fetch(url, options)));
    tiles.errorTarget = this.errorTarget;
    tiles.setCamera(this.stage.camera);
    tiles.addEventListener('load-model', ({ scene, tile }) => this.#dress(scene, tile));
    tiles.addEventListener('tile-visibility-change', () => this.#changed());
    tiles.addEventListener('load-error', ({ error, tile }) => {
      if (tile) this.#missTile(tiles, tile);
      else if (tiles === this.next) this.#missTileset(error);
    });
    tiles.addEventListener('load-root-tileset', () => this.#stand(tiles));
    tiles.group.visible = false;
    this.group.add(tiles.group);
    return tiles;
  }

  // A tileset on the Earth is shown in the frame that its root stands in: z is up there.
  #stand(tiles) {
    const { transform } = tiles.root;
    if (!transform) return;
    new Matrix4().fromArray(transform).invert().decompose(tiles.group.position, tiles.group.quaternion, tiles.group.scale);
    tiles.group.updateMatrixWorld(true);
  }

  #missTile(tiles, tile) {
    this.#fail('A tile could not be loaded; trying again.', () => {
      if (tiles !== this.current && tiles !== this.next) return;
      // Not resetFailedTiles(), which stumbles over tiles that were never looked at, and leaves the tile in the cache,
      // which takes none twice.
      if (tiles.lruCache.remove(tile)) --tiles.stats.failed;
    });
  }
  // A server that is away may come back; one that answers will say the same.
  #missTileset(error) {
    const { url } = this;
    const away = error instanceof TypeError && new URL(url).origin === location.origin;
    if (away) this.#fail('The tileset could not be loaded; trying again.', () => { if (this.url === url) this.open(url); });
    else this.dispatchEvent({ type: 'error', message: `The tileset could not be loaded: ${error.message}` });
    this.#giveUp();
  }
  #fail(message, retry) {
    this.calm = 0;
    this.patience.later(retry);
    this.dispatchEvent({ type: 'error', message });
  }
  #recover() {
    if (this.calm === null) return;
    this.calm = this.patience.waits || this.busy ? 0 : this.calm + 1;
    if (this.calm <= FRAMES_OF_REST) return;
    this.calm = null;
    this.patience.rest();
    this.dispatchEvent({ type: 'recovered' });
  }

  #changed() {
    this.changed = true;
    this.stage.shadowsChanged();
  }

  #dress(scene, tile) {
    scene.traverse((object) => {
      if (!object.isMesh) return;
      object.userData.level = tile.internal.depthFromRenderedParent - 1;
      object.userData.tile = tile;
      object.userData.uri ??= tile.content.uri;
    });
    scene.traverse((object) => {
      if (object.isMesh && object.material !== wire) this.#dressMesh(object);
    });
  }
  #dressMesh(mesh) {
    mesh.castShadow = mesh.receiveShadow = true;
    const { colours, skirts, underground, cut, changes } = this.look;
    colourMesh(mesh, colours, mesh.userData.level, changes?.get(digestOf(mesh.userData.uri)));
    mesh.visible = !isSkirt(mesh) || (skirts && !underground && !cut);
    let lines = mesh.children.find((child) => child.material === wire);
    if (this.look.wireframe && !lines) {
      lines = new Mesh(mesh.geometry, wire);
      lines.raycast = () => {};
      mesh.add(lines);
      mesh.updateMatrixWorld(true); // the group of tiles leaves those of its members alone
    }
    if (lines) lines.visible = this.look.wireframe;
  }

  // `look` may hold colours, wireframe, skirts, underground and cut (no skirts, whatever else is said), changes (a Map from
  // digests of contents to one of CHANGES).
  setLook(look) {
    Object.assign(this.look, look);
    for (const tiles of [this.current, this.next]) {
      tiles?.forEachLoadedModel((scene, tile) => this.#dress(scene, tile));
    }
    this.#changed();
  }
  set showBounds(on) {
    this.bounds.visible = on;
    this.#changed();
  }
  setErrorTarget(pixels) {
    this.errorTarget = pixels;
    for (const tiles of [this.current, this.next]) if (tiles) tiles.errorTarget = pixels;
    this.stage.needsRender = true;
  }

  // The box of the world in metres, or null before the tileset is there.
  get box() {
    const box = new Box3(), place = new Matrix4();
    const tiles = this.current ?? this.next;
    if (!tiles?.getOrientedBoundingBox(box, place) || box.isEmpty()) return null;
    return box.applyMatrix4(place.premultiply(tiles.group.matrix));
  }
  get busy() {
    return this.next !== null || this.#isLoading(this.current);
  }
  #isLoading(tiles) {
    if (!tiles?.root) return true;
    const { queued, downloading, parsing } = tiles.stats;
    return (queued ?? 0) + downloading + parsing > 0;
  }

  // Asks for what the camera needs now.
  update() {
    const { camera } = this.stage;
    const { width, height } = this.stage.pane(0);
    for (const tiles of [this.current, this.next]) {
      if (!tiles) continue;
      tiles.setResolution(camera, width, height);
      tiles.update();
    }
    this.#settle();
    this.#recover();
    if (!this.changed) return;
    this.changed = false;
    this.bounds.show(this.visibleTiles.map(({ tile, level }) => ({ box: tile.boundingVolume.box, level })));
    this.stage.needsRender = true;
    this.dispatchEvent({ type: 'change' });
  }

  // Takes what is loaded on screen. A tileset of which nothing is to be seen, after a few frames in
  // which it could have asked for more, holds up no newer one: a bake just begun has no tiles yet.
  #settle() {
    if (!this.next || this.#isLoading(this.next)) {
      this.rested = 0;
    } else if (this.next.visibleTiles.size > 0) {
      this.#swap();
    } else if (++this.rested > FRAMES_OF_REST && this.stale) {
      this.#giveUp();
    }
  }

  #giveUp() {
    this.next.dispose();
    this.next.group.removeFromParent();
    this.next = null;
    if (this.stale) this.open(this.url);
  }

  #swap() {
    const first = this.current === null;
    this.current?.dispose();
    this.current?.group.removeFromParent();
    this.current = this.next;
    this.next = null;
    this.current.group.visible = true;
    this.#changed();
    if (first) this.dispatchEvent({ type: 'ready' });
    if (this.stale) this.open(this.url);
  }

  get visibleTiles() {
    const visible = [...(this.current?.visibleTiles ?? [])].filter((tile) => tile.engineData.scene);
    return visible.map((tile) => ({ tile, level: tile.internal.depthFromRenderedParent - 1 }));
  }

  // The meshes of surfaces on screen, skirts left out.
  get surfaces() {
    const found = [];
    for (const { tile } of this.visibleTiles) {
      tile.engineData.scene.traverse((mesh) => {
        if (mesh.isMesh && mesh.material !== wire && !isSkirt(mesh)) found.push(mesh);
      });
    }
    return found;
  }

  // Tiles and triangles on screen, those of skirts among them, tiles per level, and the materials.
  statistics() {
    const result = { tiles: 0, triangles: 0, skirtTriangles: 0, levels: [], materials: new Map(), bytes: this.models.bytes };
    for (const { tile, level } of this.visibleTiles) {
      ++result.tiles;
      result.levels[level] = (result.levels[level] ?? 0) + 1;
      tile.engineData.scene.traverse((mesh) => {
        if (!mesh.isMesh || mesh.material === wire || !mesh.visible) return;
        result.triangles += triangleCount(mesh);
        if (isSkirt(mesh)) result.skirtTriangles += triangleCount(mesh);
        for (const { name, colour } of mesh.userData.materialTable ?? []) {
          result.materials.set(name, `#${colour.getHexString()}`);
        }
      });
    }
    result.levels = Array.from(result.levels, (count) => count ?? 0);
    return result;
  }
}

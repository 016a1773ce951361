// The tileset: streaming, how its tiles look, and what is on screen.
import { Box3, EventDispatcher, Group, Matrix4, Mesh } from 'three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { TilesRenderer } from '3d-tiles-renderer/three';
import { GLTFExtensionsPlugin } from '3d-tiles-renderer/three/plugins';

import { Bounds } from './bounds.js';
import { colourMesh, wire } from './colours.js';
import { Contents } from './contents.js';

const FRAMES_OF_REST = 10;

const isSkirt = (mesh) => mesh.geometry.userData.hoodoo?.role === 'skirt';
const triangleCount = (mesh) => (mesh.geometry.index ?? mesh.geometry.attributes.position).count / 3;

// Counts the bytes of tiles that come in.
class Meter {
  constructor(add) {
    this.name = 'METER';
    this.add = add;
  }
  async fetchData(url, options) {
    const response = await fetch(url, options);
    this.add(Number(response.headers.get('content-length')) || 0);
    return response;
  }
}

// Fires 'change' when the picture changes, 'ready' at the first tile, 'error' with a message.
export class Terrain extends EventDispatcher {
  constructor(stage) {
    super();
    this.stage = stage;
    this.group = new Group();
    this.bounds = new Bounds();
    stage.scene.add(this.group, this.bounds);
    this.draco = new DRACOLoader().setDecoderPath('vendor/three/examples/jsm/libs/draco/gltf/');
    this.look = { colours: 'natural', wireframe: false, skirts: true };
    this.errorTarget = 8;
    this.bytes = 0;
    this.current = null; // on screen
    this.next = null; // loading, to take its place
    this.rested = 0; // frames that `next` has asked for nothing
  }

  // Shows a tileset, or the same once more when it has changed. What is on screen stays there until
  // the new one is complete; one change more in that time is taken up afterwards.
  open(url) {
    this.url = url;
    this.stale = this.next !== null;
    if (!this.stale) this.next = this.#load();
  }

  #load() {
    const tiles = new TilesRenderer(this.url);
    tiles.registerPlugin(new Meter((bytes) => { this.bytes += bytes; }));
    tiles.registerPlugin(new GLTFExtensionsPlugin({
      dracoLoader: this.draco, meshoptDecoder: MeshoptDecoder, metadata: true,
    }));
    tiles.registerPlugin(new Contents());
    tiles.errorTarget = this.errorTarget;
    tiles.setCamera(this.stage.camera);
    tiles.addEventListener('load-model', ({ scene, tile }) => this.#dress(scene, tile));
    tiles.addEventListener('tile-visibility-change', () => this.#changed());
    tiles.addEventListener('load-error', ({ error, tile, url }) => {
      this.dispatchEvent({ type: 'error', message: `${url}: ${error.message}` });
      if (!tile && tiles === this.next) this.#giveUp();
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

  #changed() {
    this.changed = true;
    this.stage.shadowsChanged();
  }

  #dress(scene, tile) {
    scene.traverse((object) => {
      if (object.isMesh) object.userData.level = tile.internal.depthFromRenderedParent - 1;
    });
    scene.traverse((object) => {
      if (object.isMesh && object.material !== wire) this.#dressMesh(object);
    });
  }
  #dressMesh(mesh) {
    mesh.castShadow = mesh.receiveShadow = true;
    colourMesh(mesh, this.look.colours, mesh.userData.level);
    mesh.visible = this.look.skirts || !isSkirt(mesh);
    let lines = mesh.children.find((child) => child.material === wire);
    if (this.look.wireframe && !lines) {
      lines = new Mesh(mesh.geometry, wire);
      lines.raycast = () => {};
      mesh.add(lines);
      mesh.updateMatrixWorld(true); // the group of tiles leaves those of its members alone
    }
    if (lines) lines.visible = this.look.wireframe;
  }

  // `look` may hold colours, wireframe, skirts.
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
    const { camera, renderer } = this.stage;
    for (const tiles of [this.current, this.next]) {
      if (!tiles) continue;
      tiles.setResolutionFromRenderer(camera, renderer);
      tiles.update();
    }
    this.#settle();
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

  // Tiles and triangles on screen, tiles per level, and the materials among them.
  statistics() {
    const result = { tiles: 0, triangles: 0, levels: [], materials: new Map(), bytes: this.bytes };
    for (const { tile, level } of this.visibleTiles) {
      ++result.tiles;
      result.levels[level] = (result.levels[level] ?? 0) + 1;
      tile.engineData.scene.traverse((mesh) => {
        if (!mesh.isMesh || mesh.material === wire || !mesh.visible) return;
        result.triangles += triangleCount(mesh);
        for (const { name, colour } of mesh.userData.materialTable ?? []) {
          result.materials.set(name, `#${colour.getHexString()}`);
        }
      });
    }
    result.levels = Array.from(result.levels, (count) => count ?? 0);
    return result;
  }
}

/** Drawings of a tileset as masks: each level's whole surface by itself, and tiles of several levels in two viewers. */
import { openPage, readMask, settle, shrink } from '../e2e/browser.mjs';

export const error = 6;    // pixels on screen that the viewers may be off
const size = [480, 270];   // of a picture
const stillFrames = 4;     // after which CesiumJS is taken to be done

/** The unsplit mesh of each level (/export/LEVEL.glb), loaded when it is first asked for. */
export class Unsplit {
  #numbers = new Map();   // by level
  async open(browser, server) {
    this.page = await openPage(browser, server.url, size);
    await this.page.goto(`${server.url}/pages/unsplit.html`);
    await this.page.waitForFunction(() => globalThis.loadMesh);
  }
  /** Masks of the leaves, then of the other levels among `levels`. */
  async draw(camera, levels) {
    const masks = [];
    for (const level of new Set([0, ...[...levels].sort()])) {
      if (!this.#numbers.has(level)) {
        const { number } = await this.page.evaluate((url) => globalThis.loadMesh([url]), `/export/${level}.glb`);
        this.#numbers.set(level, number);
      }
      await this.page.evaluate(([number, view]) => globalThis.drawMesh(number, view), [this.#numbers.get(level), camera]);
      masks.push(await readMask(this.page));
    }
    return masks;
  }
}

/** Our viewer. */
export class Three {
  async open(browser, server) {
    this.page = await openPage(browser, server.url, size);
    await this.page.goto(`${server.url}/viewer/?tileset=/tileset/tileset.json&noui&bg=magenta&err=${error}`);
    await settle(this.page);
  }
  async draw(camera) {
    await this.page.evaluate(({ position, target }) => {
      const { navigation, stage } = globalThis.hoodoo, vector = (p) => stage.camera.position.clone().set(...p);
      navigation.lookFrom(vector(position), vector(target));
    }, camera);
    await settle(this.page);
    const { shown, errors } = await this.page.evaluate(() => ({
      shown: globalThis.hoodoo.terrain.visibleTiles.map(({ tile }) => tile.content.uri), errors: globalThis.hoodoo.errors,
    }));
    return { mask: await readMask(this.page), shown, problems: [...this.page.problems, ...errors] };
  }

  /** The same view without the skirts of the tile `uri`, or of all. */
  async drawWithoutSkirts(uri) {
    await this.page.evaluate((one) => {
      const { terrain, stage } = globalThis.hoodoo;
      terrain.current.forEachLoadedModel((scene, tile) => {
        if (one !== undefined && tile.content.uri !== one) return;
        scene.traverse((mesh) => { if (mesh.geometry?.userData.hoodoo?.role === 'skirt') mesh.visible = false; });
      });
      stage.needsRender = true;
    }, uri);
    await settle(this.page);
    const mask = await readMask(this.page);
    await this.page.evaluate(() => globalThis.hoodoo.terrain.setLook({ skirts: true }));
    return mask;
  }

  /** The same view with skirts painted like the background. */
  async drawWithoutSkirtsColour() {
    await this.page.evaluate(async () => {
      const { MeshBasicMaterial } = await import('three');
      const paint = new MeshBasicMaterial({ color: 'magenta', toneMapped: false, fog: false });
      globalThis.painted = [];
      globalThis.hoodoo.terrain.group.traverse((mesh) => {
        if (mesh.geometry?.userData.hoodoo?.role !== 'skirt') return;
        globalThis.painted.push([mesh, mesh.material]);
        mesh.material = paint;
      });
      globalThis.hoodoo.stage.needsRender = true;
    });
    await settle(this.page);
    const mask = await readMask(this.page);
    await this.page.evaluate(() => {
      for (const [mesh, material] of globalThis.painted) mesh.material = material;
      globalThis.hoodoo.stage.needsRender = true;
    });
    return mask;
  }
}

export class Cesium {
  async open(browser, server) {
    this.page = await openPage(browser, server.url, size);
    await this.page.goto(`${server.url}/pages/cesium.html`);
    await this.page.waitForFunction(() => globalThis.drawTileset);
    await this.page.evaluate(([url, pixels]) => globalThis.loadTileset(url, pixels), [`${server.url}/tileset/tileset.json`, error]);
  }
  async draw(camera) {
    const { shown, errors } = await this.page.evaluate(([view, frames]) => globalThis.drawTileset(view, frames), [camera, stillFrames]);
    return { mask: await readMask(this.page), shown, problems: [...this.page.problems, ...errors] };
  }
}

/** Pixels of skirts in `mask`, and whether a patch of them is wider than a crack between levels can be. */
export function skirtsIn(mask, painted) {
  const bits = mask.bits.map((bit, i) => (bit && !painted.bits[i] ? 1 : 0));
  const sum = (all) => all.reduce((total, bit) => total + bit, 0);
  return { pixels: sum(bits), wide: sum(shrink({ ...mask, bits }, error).bits) };
}

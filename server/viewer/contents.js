// Tiles of several contents (3D Tiles 1.1, "contents"), which 3d-tiles-renderer leaves out: all of a
// tile's are loaded before any is shown.
export class Contents {
  // `fetch(url, options)` gives responses.
  constructor(fetch) {
    this.name = 'CONTENTS';
    this.fetch = fetch;
  }
  init(tiles) {
    this.tiles = tiles;
  }

  // The first takes the place of the one content that the renderer knows.
  preprocessNode(tile) {
    if (!tile.contents) return;
    tile.content = { uri: tile.contents[0].uri };
    tile.internal.hasContent = tile.internal.hasRenderableContent = true;
    ++tile.internal.depthFromRenderedParent;
  }
  // The others join it, in its own frame.
  async processTileModel(scene, tile) {
    const models = await Promise.all((tile.contents ?? []).slice(1).map(({ uri }) => this.#load(uri, tile)));
    models.forEach((model, i) => {
      const { uri } = tile.contents[i + 1];
      model.traverse((object) => { object.userData.uri = uri; });
      scene.add(...model.children);
    });
  }
  async #load(uri, tile) {
    const url = new URL(uri, `${tile.internal.basePath}/`).toString();
    const response = await this.fetch(url, this.tiles.fetchOptions);
    if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
    const loader = this.tiles.manager.getHandler('slab.glb');
    return (await loader.parseAsync(await response.arrayBuffer(), '')).scene;
  }
}

// The inspector: what rock a point is of, which tile shows it, and what bake.json says of that tile.
import { Vector3 } from 'three';
import { WGS84_ELLIPSOID } from '3d-tiles-renderer/three';

import { fillRows, make, metres } from './card.js';
import { materialOfFeature } from './colours.js';
import { digestOf } from './manifest.js';
import { Markers } from './marker.js';

const degrees = (radians, [positive, negative]) => {
  const value = (radians * 180) / Math.PI;
  return `${Math.abs(value).toFixed(7)}\u00b0 ${value < 0 ? negative : positive}`;
};

// Longitude, latitude and height where the tiles stand on the Earth, or null.
function onEarth(point, terrain) {
  const { transform } = terrain.current.root;
  if (!transform) return null;
  const geocentric = point.clone().applyMatrix4(terrain.current.group.matrixWorld.clone().invert());
  const { lat, lon, height } = WGS84_ELLIPSOID.getPositionToCartographic(geocentric, {});
  return { text: `${degrees(lon, 'EW')}, ${degrees(lat, 'NS')}`, height };
}

export class Inspector {
  // `manifests`: a Map from terrains to what bake.json says of them.
  constructor(stage, terrains, manifests, card) {
    Object.assign(this, { stage, terrains, manifests, card });
    this.markers = new Markers('#ffd166');
    stage.scene.add(this.markers);
    this.found = null; // what is shown, for tests too
  }

  // Shows what is known at once, and the rest when bake.json is read.
  async show(place) {
    this.markers.show([place.point]);
    this.stage.needsRender = true;
    this.found = this.#look(place);
    const mine = this.found;
    this.#fill(mine);
    if (!mine.digest) return;
    const record = await this.manifests.get(place.terrain)?.find(mine.digest);
    if (this.found !== mine) return;
    mine.record = record ?? null;
    mine.complete = true;
    this.#fill(mine);
  }
  // Says what there is to do.
  wait() {
    this.#empty('Click a point.');
    this.card.hidden = false;
  }
  miss() {
    this.#empty('Nothing there.');
    this.card.hidden = false;
  }
  clear() {
    this.#empty('');
    this.card.hidden = true;
  }
  #empty(text) {
    this.found = null;
    this.card.querySelector('p').textContent = text;
    fillRows(this.card.querySelector('dl'), []);
    this.markers.show([]);
    this.stage.needsRender = true;
  }

  #look({ point, terrain, mesh, face }) {
    const side = this.terrains.length > 1 ? 'AB'[this.terrains.indexOf(terrain)] : null;
    const found = { point, side, earth: onEarth(point, terrain), cut: !mesh };
    if (!mesh) return found;
    const ids = mesh.geometry.getAttribute('_feature_id_0');
    const { tile, uri } = mesh.userData;
    return Object.assign(found, {
      material: ids ? materialOfFeature(mesh, ids.getX(face.a)) : null,
      uri, digest: digestOf(uri), geometricError: tile.geometricError,
      file: new URL(uri, `${tile.internal.basePath}/`).href,
    });
  }

  #fill({ point, side, earth, cut, material, digest, file, geometricError, record, complete }) {
    const waiting = digest && !complete ? '\u2026' : 'not in bake.json';
    const [level] = record?.tile.key.split('/') ?? [];
    fillRows(this.card.querySelector('dl'), [
      ['Bake', side],
      ['Material', cut ? 'rock, cut open' : swatch(material)],
      ['Position', point.toArray().map((value) => value.toFixed(2)).join(', ')],
      ['Map', earth ? null : onMap(point, record?.header.frame)],
      ['Longitude, latitude', earth?.text],
      ['Above the ellipsoid', earth && metres(earth.height)],
      ['Tile', cut ? null : record?.tile.key ?? waiting],
      ['Level', cut || !record ? null : `${level} (finest 0, coarsest ${record.header.levels - 1})`],
      ['Geometric error', cut ? null : metres(geometricError)],
      ['Slice', record && make('code', { title: 'Digest of all that the tile was made from' }, record.tile.slice)],
      ['File', file && make('a', { href: file, download: '' }, make('code', {}, digest ?? file))],
    ]);
    this.card.hidden = false;
  }
}

function swatch(material) {
  if (!material) return '\u2014';
  const box = make('span', { className: 'swatch' });
  const { x, y, z } = material.color ?? new Vector3(1, 1, 1);
  box.style.background = `rgb(${[x, y, z].map((value) => Math.round(255 * value))})`;
  return make('span', {}, box, material.name ?? '');
}

// Projected coordinates in the units of the map; those of the frame are metres.
function onMap({ x, y }, frame) {
  if (!frame?.crs) return null;
  const [east, north] = [frame.origin[0] + x, frame.origin[1] + y].map((value) => (value / frame.unit).toFixed(2));
  return `${frame.crs}: ${east}, ${north}`;
}

// What lies under a point of the page: the surface, or the rock where it is cut open.
import { EventDispatcher, Raycaster, Vector3 } from 'three';

import { withBothSides } from './colours.js';

const MOST_PIXELS = 6; // a click may move by this

// Fires 'pick' with {place} at a click that is no drag, 'miss' where there is nothing. `section` may be null.
export class Picker extends EventDispatcher {
  constructor(stage, terrains, section) {
    super();
    Object.assign(this, { stage, terrains, section });
    this.ray = new Raycaster();
    this.pointers = new Map();
    const element = stage.renderer.domElement;
    element.addEventListener('pointerdown', (event) => this.#down(event));
    element.addEventListener('pointerup', (event) => this.#up(event));
    element.addEventListener('pointercancel', (event) => this.pointers.delete(event.pointerId));
  }

  #down(event) {
    const { clientX: x, clientY: y, pointerId } = event;
    this.pointers.set(pointerId, { x, y, alone: this.pointers.size === 0 && event.button === 0 });
    if (this.pointers.size > 1) for (const pointer of this.pointers.values()) pointer.alone = false;
  }
  #up(event) {
    const from = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (!from?.alone) return;
    if (Math.hypot(event.clientX - from.x, event.clientY - from.y) <= MOST_PIXELS) this.pick(event.clientX, event.clientY);
  }

  pick(clientX, clientY) {
    const place = this.at(clientX, clientY);
    this.dispatchEvent(place ? { type: 'pick', place } : { type: 'miss' });
  }
  pickCentre() {
    const { left, top, width, height } = this.stage.pane(0);
    this.pick(left + width / 2, top + height / 2);
  }

  // {point, terrain, mesh, face}; `mesh` is null on the face of a cut. Null where there is nothing.
  at(clientX, clientY) {
    const { index, at } = this.stage.locate(clientX, clientY);
    const terrain = this.terrains[index];
    this.ray.setFromCamera(at, this.stage.camera);
    const plane = this.section?.plane ?? null;
    const shown = ({ object, point }) => object.visible && (!plane || plane.distanceToPoint(point) >= 0);
    const hit = this.ray.intersectObject(terrain.group, true).find(shown);
    const cut = plane && this.#onCut(plane, terrain);
    if (cut && (!hit || cut.distanceTo(this.ray.ray.origin) < hit.distance)) return { point: cut, terrain, mesh: null };
    return hit ? { point: hit.point, terrain, mesh: hit.object, face: hit.face } : null;
  }

  // Where the ray enters rock through the plane, or null.
  #onCut(plane, terrain) {
    const point = this.ray.ray.intersectPlane(plane, new Vector3());
    return point && isRock(point, terrain) ? point : null;
  }
}

// A point is in rock when the last surface above it is entered from above: all surfaces above it taken together
// lead once more in than out.
function isRock(point, terrain) {
  const up = new Raycaster(point, new Vector3(0, 0, 1));
  const meshes = terrain.surfaces;
  const hits = withBothSides(() => up.intersectObjects(meshes, false));
  const normal = new Vector3();
  const sum = hits.reduce((total, { face, object }) => {
    normal.copy(face.normal).transformDirection(object.matrixWorld);
    return total + Math.sign(normal.z);
  }, 0);
  return sum > 0;
}

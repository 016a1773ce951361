// The camera's two ways to move: around a point, or free.
import { Raycaster, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

import { FlyControls } from './fly.js';
import { isShortcut, isTaken } from './keys.js';

const TURN = Math.PI / 60; // by an arrow key
const CLOSER = 1.1; // by + and -
const ARROWS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const ZOOMS = { '+': 1 / CLOSER, '=': 1 / CLOSER, '-': CLOSER, _: CLOSER };
const STEEPEST = Math.PI / 2 - 0.01;
const THREE_QUARTER = new Vector3(-0.55, -0.75, 0.52).normalize();

export class Navigation {
  constructor(stage, terrains) {
    this.stage = stage;
    this.camera = stage.camera;
    this.terrains = terrains;
    const element = stage.renderer.domElement;
    this.orbit = new OrbitControls(this.camera, element);
    this.orbit.enableDamping = true;
    this.orbit.dampingFactor = 0.12;
    this.orbit.zoomToCursor = terrains.length === 1; // it knows of one pane only
    this.orbit.screenSpacePanning = false;
    this.orbit.minDistance = 0.5;
    this.orbit.addEventListener('change', () => { this.moved = true; });
    this.touched = false; // by the user, who then is not led elsewhere
    this.orbit.addEventListener('start', () => { this.touched = true; });
    this.fly = new FlyControls(this.camera, element);
    element.addEventListener('dblclick', (event) => this.#turnAbout(event));
    addEventListener('keydown', (event) => this.#key(event));
  }

  get mode() {
    return this.fly.enabled ? 'fly' : 'orbit';
  }
  set mode(mode) {
    const flies = mode === 'fly';
    if (flies === this.fly.enabled) return;
    this.touched = true;
    if (flies) this.fly.speed = Math.max(2, this.scale / 4);
    else this.orbit.target.copy(this.camera.position).addScaledVector(this.fly.forward, this.scale);
    this.fly.enabled = flies;
    this.orbit.enabled = !flies;
    this.moved = true;
  }

  // What the camera looks at, and how far away that is in metres.
  get target() {
    if (this.mode === 'orbit') return this.orbit.target;
    return this.camera.position.clone().addScaledVector(this.fly.forward, this.scale);
  }
  get scale() {
    if (this.mode === 'orbit') return this.camera.position.distanceTo(this.orbit.target);
    return this.fly.speed * 4;
  }

  lookFrom(position, target) {
    this.camera.position.copy(position);
    this.orbit.target.copy(target);
    this.camera.lookAt(target);
    this.orbit.update();
    if (this.fly.enabled) this.fly.speed = position.distanceTo(target) / 4;
    this.moved = true;
  }

  // All of a box, from the south-west and above.
  lookAtWhole(box, aspect) {
    const size = box.getSize(new Vector3());
    const centre = box.getCenter(new Vector3());
    const halfAngle = (this.camera.fov * Math.PI) / 360;
    const fit = Math.tan(halfAngle) * Math.min(1, aspect);
    const distance = (0.46 * Math.hypot(size.x, size.y)) / fit + 0.3 * size.z;
    this.lookFrom(centre.clone().addScaledVector(THREE_QUARTER, distance), centre);
  }

  #key(event) {
    if (!isShortcut(event) || isTaken(event)) return;
    if (event.key in ZOOMS) this.#approach(ZOOMS[event.key]);
    else if (event.key in ARROWS) this.#turn(...ARROWS[event.key].map((part) => part * TURN));
    else return;
    event.preventDefault();
    this.touched = this.moved = true;
  }
  // Looks to the left and up, from where it is when it flies, else by going about the target.
  #turn(left, up) {
    const { forward } = this.fly;
    const { target } = this.orbit;
    const distance = this.camera.position.distanceTo(target);
    const yaw = Math.atan2(forward.y, forward.x) + left;
    const tilt = Math.asin(Math.max(-1, Math.min(1, forward.z))) + up;
    const pitch = Math.max(-STEEPEST, Math.min(STEEPEST, tilt));
    this.fly.lookAlong(yaw, pitch);
    if (this.mode === 'fly') return;
    this.camera.position.copy(target).addScaledVector(this.fly.forward, -distance);
  }
  #approach(factor) {
    if (this.mode === 'fly') {
      this.fly.speed /= factor;
      return;
    }
    const { target, minDistance } = this.orbit;
    const away = this.camera.position.clone().sub(target);
    away.setLength(Math.max(minDistance, away.length() * factor));
    this.camera.position.copy(target).add(away);
  }

  #turnAbout(event) {
    const { index, at } = this.stage.locate(event.clientX, event.clientY);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.camera);
    const [hit] = ray.intersectObject(this.terrains[index].group, true);
    if (!hit || this.mode === 'fly') return;
    this.touched = true;
    this.orbit.target.copy(hit.point);
    this.orbit.update();
    this.moved = true;
  }

  // True when the camera moved. There must be a view: from where the camera stands at first OrbitControls would go on for ever.
  update(seconds) {
    if (this.fly.enabled) this.moved = this.fly.update(seconds) || this.moved;
    else this.orbit.update(seconds);
    const moved = this.moved;
    this.moved = false;
    return moved;
  }
}

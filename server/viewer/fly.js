// Flying: drag to look, keys to move, the wheel to set the speed. z is up.
import { Vector3 } from 'three';

import { isShortcut } from './keys.js';

const MOVES = {
  KeyW: [0, 1, 0], KeyS: [0, -1, 0], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyQ: [0, 0, -1],
  KeyE: [0, 0, 1],
};
const FASTER = 5;
const RADIANS_PER_PIXEL = 0.004;

export class FlyControls {
  constructor(camera, element) {
    this.camera = camera;
    this.speed = 20; // metres per second
    this.enabled = false;
    this.moved = false;
    this.keys = new Set();
    element.addEventListener('pointerdown', (event) => this.#grab(event, element));
    element.addEventListener('pointermove', (event) => this.#look(event));
    element.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    addEventListener('keydown', (event) => this.#key(event));
    addEventListener('keyup', (event) => this.keys.delete(event.code));
    addEventListener('blur', () => this.keys.clear());
  }

  get forward() {
    return this.camera.getWorldDirection(new Vector3());
  }

  #grab(event, element) {
    if (this.enabled) element.setPointerCapture(event.pointerId);
  }
  #look(event) {
    if (!this.enabled || event.buttons === 0) return;
    const forward = this.forward;
    const yaw = Math.atan2(forward.y, forward.x) - event.movementX * RADIANS_PER_PIXEL;
    const limit = Math.PI / 2 - 0.01;
    const pitch = Math.asin(Math.max(-1, Math.min(1, forward.z))) - event.movementY * RADIANS_PER_PIXEL;
    this.lookAlong(yaw, Math.max(-limit, Math.min(limit, pitch)));
  }
  #wheel(event) {
    if (!this.enabled) return;
    event.preventDefault();
    this.speed *= Math.exp(-event.deltaY * 0.001);
  }
  #key(event) {
    if (!isShortcut(event)) return;
    if (event.code in MOVES || event.code.startsWith('Shift')) this.keys.add(event.code);
  }

  lookAlong(yaw, pitch) {
    const across = Math.cos(pitch);
    const ahead = new Vector3(Math.cos(yaw) * across, Math.sin(yaw) * across, Math.sin(pitch));
    this.camera.lookAt(ahead.add(this.camera.position));
    this.moved = true;
  }

  // True when the camera moved since the last call. `seconds` have passed since then.
  update(seconds) {
    const step = new Vector3();
    for (const key of this.keys) {
      if (key in MOVES) step.add(new Vector3(...MOVES[key]));
    }
    if (this.enabled && step.lengthSq() > 0) {
      const forward = this.forward;
      const right = new Vector3().crossVectors(forward, this.camera.up).normalize();
      const fast = this.keys.has('ShiftLeft') || this.keys.has('ShiftRight') ? FASTER : 1;
      const length = this.speed * fast * Math.min(seconds, 0.1);
      this.camera.position
        .addScaledVector(right, step.x * length)
        .addScaledVector(forward, step.y * length)
        .addScaledVector(this.camera.up, step.z * length);
      this.moved = true;
    }
    const moved = this.moved;
    this.moved = false;
    return moved;
  }
}

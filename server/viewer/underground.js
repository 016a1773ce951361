// Underground: no skirts, inner sides drawn, a lamp at the camera in place of most of the day.
import { Color, DirectionalLight } from 'three';

const DARK = new Color('#171a1e');

export class Underground {
  constructor(stage, terrains) {
    Object.assign(this, { stage, terrains });
    this.on = false;
    this.lamp = new DirectionalLight('#fff1dc', 2.2); // without a position of its own: it shines from the camera
    this.lamp.visible = false;
    stage.scene.add(this.lamp, this.lamp.target);
    this.day = { sun: stage.sun.intensity, sky: stage.daylight.intensity, background: stage.scene.background };
  }

  set(on) {
    this.on = on;
    const { stage, day } = this;
    this.lamp.visible = on;
    stage.sun.visible = !on;
    stage.daylight.intensity = on ? 0.7 * day.sky : day.sky;
    if (stage.sky) {
      stage.sky.visible = !on;
      stage.scene.background = on ? DARK : day.background;
    }
    for (const terrain of this.terrains) terrain.setLook({ underground: on });
    this.follow();
  }

  // Keeps the lamp at the camera, a little above it, so that slopes differ in shade.
  follow() {
    if (!this.on) return;
    const { camera } = this.stage;
    camera.getWorldDirection(this.lamp.target.position).add(camera.position);
    this.lamp.position.copy(camera.position);
    this.lamp.position.z += 0.25;
    this.lamp.target.updateMatrixWorld();
  }
}

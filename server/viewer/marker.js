// Dots in the picture that no rock hides, and a line through them.
import { BufferGeometry, Group, Line, LineBasicMaterial, Points, PointsMaterial, CanvasTexture } from 'three';

const DOT_PIXELS = 13;

function makeDot() {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 32;
  const context = canvas.getContext('2d');
  const circle = (radius, colour) => {
    context.fillStyle = colour;
    context.beginPath();
    context.arc(16, 16, radius, 0, 2 * Math.PI);
    context.fill();
  };
  circle(16, '#10161c');
  circle(12, '#ffffff');
  return new CanvasTexture(canvas);
}

export class Markers extends Group {
  constructor(colour) {
    super();
    const over = { color: colour, depthTest: false, transparent: true, toneMapped: false, fog: false };
    this.points = new Points(new BufferGeometry(), new PointsMaterial({
      ...over, map: makeDot(), size: DOT_PIXELS, sizeAttenuation: false, alphaTest: 0.1,
    }));
    this.line = new Line(this.points.geometry, new LineBasicMaterial(over));
    for (const object of [this.line, this.points]) {
      object.frustumCulled = false;
      object.renderOrder = 20;
      this.add(object);
    }
    this.show([]);
  }

  show(places) {
    this.visible = places.length > 0;
    this.points.geometry.dispose();
    this.points.geometry = this.line.geometry = new BufferGeometry().setFromPoints(places);
    this.line.visible = places.length > 1;
  }
}

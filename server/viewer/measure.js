// Measuring: two points, and how far they lie apart.
import { fillRows, metres } from './card.js';
import { Markers } from './marker.js';

export function measure(from, to) {
  const across = Math.hypot(to.x - from.x, to.y - from.y), up = to.z - from.z;
  return { distance: from.distanceTo(to), horizontal: across, vertical: up, slope: Math.atan2(up, across) };
}

function slopeText({ slope, horizontal, vertical }) {
  const angle = `${((slope * 180) / Math.PI).toFixed(1)}\u00b0`;
  return horizontal > 0.005 ? `${angle} (${((100 * vertical) / horizontal).toFixed(1)} %)` : angle;
}

export class Measure {
  constructor(stage, card) {
    Object.assign(this, { stage, card });
    this.markers = new Markers('#7fd4ff');
    stage.scene.add(this.markers);
    this.points = [];
  }

  // A third point begins anew.
  add(point) {
    this.set(this.points.length >= 2 ? [point] : [...this.points, point]);
  }
  set(points) {
    this.points = points;
    this.markers.show(points);
    this.card.hidden = points.length === 0;
    this.#fill();
    this.stage.needsRender = true;
  }

  get result() {
    return this.points.length === 2 ? measure(...this.points) : null;
  }
  #fill() {
    const { result } = this;
    this.card.querySelector('p').hidden = result !== null;
    fillRows(this.card.querySelector('dl'), result ? [
      ['Distance', metres(result.distance)], ['Horizontal', metres(result.horizontal)],
      ['Vertical', metres(result.vertical)], ['Slope', slopeText(result)],
    ] : []);
  }
}

// The boxes of the tiles on screen.
import { BufferGeometry, Color, Float32BufferAttribute, LineBasicMaterial, LineSegments } from 'three';

import { levelColour } from './colours.js';

// Pairs of corners, by bit: x, y, z.
const EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

// `box` is centre and three half axes, as in 3D Tiles.
function corner(box, bits) {
  const at = box.slice(0, 3);
  for (let axis = 0; axis < 3; ++axis) {
    const sign = (bits >> axis) & 1 ? 1 : -1;
    for (let k = 0; k < 3; ++k) at[k] += sign * box[3 + 3 * axis + k];
  }
  return at;
}

export class Bounds extends LineSegments {
  constructor() {
    super(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true }));
    this.visible = false;
    this.frustumCulled = false;
  }

  // `tiles` are [{box, level}].
  show(tiles) {
    const positions = [];
    const colours = [];
    for (const { box, level } of tiles) {
      const colour = new Color(levelColour(level)).toArray();
      for (const edge of EDGES) {
        for (const end of edge) {
          positions.push(...corner(box, end));
          colours.push(...colour);
        }
      }
    }
    this.geometry.dispose();
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute('position', new Float32BufferAttribute(positions, 3));
    this.geometry.setAttribute('color', new Float32BufferAttribute(colours, 3));
  }
}

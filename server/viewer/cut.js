// The face of a cut through the ground: where a plane along two axes lies in rock.
//
// Rock is what an odd number of surfaces lies above, which holds for open ground as for a closed body. Counting is
// left to one bit of the stencil: each part of the surface inverts it below itself in the plane. For upright planes
// that are strips from the contour down to the lowest point, for a level plane the surfaces above it, seen in plan.
import {
  AlwaysStencilFunc, BufferGeometry, Color, DoubleSide, Float32BufferAttribute, Group, InvertStencilOp, LineBasicMaterial,
  LineSegments, Mesh, MeshBasicMaterial, NotEqualStencilFunc, ShaderMaterial, Vector3, ZeroStencilOp,
} from 'three';

const INVERT = {
  colorWrite: false, depthWrite: false, depthTest: false, side: DoubleSide, stencilWrite: true, stencilWriteMask: 1,
  stencilFunc: AlwaysStencilFunc, stencilZPass: InvertStencilOp, stencilZFail: InvertStencilOp,
};
const STRIPES = 90; // across the world

const strips = new MeshBasicMaterial(INVERT);
const line = new LineBasicMaterial({ color: '#ffe2b8', toneMapped: false });

// What lies above a level plane, pressed onto it.
const pressed = new ShaderMaterial({
  ...INVERT,
  uniforms: { level: { value: 0 } },
  vertexShader: `
    uniform float level;
    varying float height;
    void main() {
      vec4 world = modelMatrix * vec4(position, 1.0);
      height = world.z;
      gl_Position = projectionMatrix * viewMatrix * vec4(world.xy, level, 1.0);
    }`,
  fragmentShader: `
    uniform float level;
    varying float height;
    void main() {
      if (height < level) discard;
      gl_FragColor = vec4(1.0);
    }`,
});

// Rock, hatched as in drawings; it leaves the stencil as it was.
const face = new ShaderMaterial({
  side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  stencilWrite: true, stencilFuncMask: 1, stencilWriteMask: 1, stencilFunc: NotEqualStencilFunc, stencilRef: 0,
  stencilFail: ZeroStencilOp, stencilZFail: ZeroStencilOp, stencilZPass: ZeroStencilOp,
  uniforms: { rock: { value: new Color('#7d6650') }, hatch: { value: new Color('#6a5543') }, pitch: { value: 1 } },
  vertexShader: `
    varying vec3 place;
    void main() {
      place = position;
      gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
    }`,
  fragmentShader: `
    uniform vec3 rock, hatch;
    uniform float pitch;
    varying vec3 place;
    void main() {
      float along = dot(place, vec3(1.0)) / pitch;
      float soft = min(0.5, 1.5 * fwidth(along));
      float stripe = smoothstep(0.5 - soft, 0.5 + soft, abs(fract(along) * 2.0 - 1.0));
      gl_FragColor = vec4(mix(rock, hatch, stripe), 1.0);
      #include <colorspace_fragment>
    }`,
});

// Pairs of points where the triangles of `mesh` cross the plane at `level` on `axis`.
function contourOf(mesh, axis, level, ends) {
  const { index, attributes: { position } } = mesh.geometry;
  const points = Array.from({ length: position.count }, (_, i) => (
    new Vector3().fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld)));
  const above = points.map((point) => point.getComponent(axis) >= level);
  const crossing = (i, j) => {
    const [a, b] = above[i] ? [points[j], points[i]] : [points[i], points[j]]; // the same from both triangles of an edge
    const from = a.getComponent(axis);
    const point = a.clone().lerp(b, (level - from) / (b.getComponent(axis) - from));
    return point.setComponent(axis, level);
  };
  for (let i = 0; i < (index ?? position).count; i += 3) {
    const corners = [i, i + 1, i + 2].map((at) => (index ? index.getX(at) : at));
    for (let k = 0; k < 3; ++k) {
      const from = corners[k], to = corners[(k + 1) % 3];
      if (above[from] !== above[to]) ends.push(crossing(from, to));
    }
  }
}

function crosses(mesh, axis, level) {
  const { geometry } = mesh;
  if (!geometry.boundingBox) geometry.computeBoundingBox();
  const box = geometry.boundingBox.clone().applyMatrix4(mesh.matrixWorld);
  return box.min.getComponent(axis) <= level && box.max.getComponent(axis) >= level;
}

const triangles = (positions, corners = null) => new BufferGeometry()
  .setAttribute('position', new Float32BufferAttribute(positions.flatMap((point) => point.toArray()), 3))
  .setIndex(corners);

// A strip from each pair of points down to `floor`.
function stripsBelow(ends, floor) {
  const positions = [], corners = [];
  for (let i = 0; i < ends.length; i += 2) {
    const [a, b] = [ends[i], ends[i + 1]], at = positions.length;
    positions.push(a, b, b.clone().setZ(floor), a.clone().setZ(floor));
    corners.push(at, at + 1, at + 2, at, at + 2, at + 3);
  }
  return triangles(positions, corners);
}

// The rectangle that the plane cuts out of a box.
function rectangle(axis, level, { min, max }) {
  const [u, v] = [0, 1, 2].filter((other) => other !== axis);
  const corner = (a, b) => new Vector3().setComponent(axis, level)
    .setComponent(u, a.getComponent(u)).setComponent(v, b.getComponent(v));
  return triangles([corner(min, min), corner(max, min), corner(max, max), corner(min, max)], [0, 1, 2, 0, 2, 3]);
}

export class Cut extends Group {
  constructor(terrain) {
    super();
    this.terrain = terrain;
    this.visible = false;
  }

  // Made anew for the surfaces on screen. `box` is the world's.
  show(axis, level, box) {
    this.clear();
    this.visible = true;
    const meshes = this.terrain.surfaces;
    const ends = [];
    for (const mesh of meshes) if (crosses(mesh, axis, level)) contourOf(mesh, axis, level, ends);
    const around = box.clone();
    around.min.z -= 0.06 * (box.max.z - box.min.z); // a little rock below the lowest place
    if (axis === 2) this.#press(meshes, level);
    else this.#put(new Mesh(stripsBelow(ends, around.min.z), strips), 8);
    face.uniforms.pitch.value = box.min.distanceTo(box.max) / STRIPES;
    this.#put(new Mesh(rectangle(axis, level, around), face), 9);
    this.#put(new LineSegments(triangles(ends), line), 10);
  }
  hide() {
    this.clear();
    this.visible = false;
  }

  #press(meshes, level) {
    pressed.uniforms.level.value = level;
    for (const mesh of meshes) {
      const flat = new Mesh(mesh.geometry, pressed);
      flat.matrixAutoUpdate = false;
      flat.matrix.copy(mesh.matrixWorld);
      flat.userData.shared = true;
      this.#put(flat, 8);
    }
  }
  #put(object, order) {
    object.renderOrder = order;
    object.frustumCulled = false;
    object.raycast = () => {};
    this.add(object);
  }
  clear() {
    for (const { geometry, userData } of this.children) if (!userData.shared) geometry.dispose();
    return super.clear();
  }
}

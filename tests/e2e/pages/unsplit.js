/** Draws the surfaces of tiles as one mesh, welded where their vertices agree to the bit. */
import * as THREE from 'three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const draco = new DRACOLoader().setDecoderPath('/node_modules/three/examples/jsm/libs/draco/gltf/');
const loader = new GLTFLoader().setDRACOLoader(draco).setMeshoptDecoder(MeshoptDecoder);
const atOnce = 8;

/** Surfaces without skirts, positions as doubles in the frame of the tileset: z up. */
async function load(url) {
  const { scene } = await loader.loadAsync(url);
  scene.updateMatrixWorld(true);
  const parts = [];
  scene.traverse((mesh) => {
    if (!mesh.isMesh || mesh.geometry.userData.hoodoo?.role === 'skirt') return;
    const { index, attributes: { position } } = mesh.geometry;
    const points = new Float64Array(position.count * 3);
    const p = new THREE.Vector3();
    for (let i = 0; i < position.count; ++i) {
      p.fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld);
      points.set([p.x, -p.z, p.y], 3 * i);
    }
    parts.push({ points, index: index.array });
    mesh.geometry.dispose();
  });
  return parts;
}

/** One vertex per position. A table of the bits of float32 coordinates, open addressing. */
class Weld {
  constructor(most) {
    this.mask = 2 ** Math.ceil(Math.log2(2 * most + 1)) - 1;
    this.slots = new Int32Array(this.mask + 1).fill(-1);
    this.positions = new Float32Array(3 * most);
    this.bits = new Int32Array(this.positions.buffer);
    this.count = 0;
  }
  vertex(x, y, z) {
    const at = 3 * this.count;
    this.positions[at] = x;
    this.positions[at + 1] = y;
    this.positions[at + 2] = z;
    const { bits } = this;
    let slot = (Math.imul(bits[at], 73856093) ^ Math.imul(bits[at + 1], 19349663) ^ Math.imul(bits[at + 2], 83492791)) & this.mask;
    for (; this.slots[slot] >= 0; slot = (slot + 1) & this.mask) {
      const other = 3 * this.slots[slot];
      if (bits[other] === bits[at] && bits[other + 1] === bits[at + 1] && bits[other + 2] === bits[at + 2]) return other / 3;
    }
    this.slots[slot] = this.count;
    return this.count++;
  }
}

function weld(parts, origin) {
  const table = new Weld(parts.reduce((sum, { points }) => sum + points.length / 3, 0));
  const index = new Uint32Array(parts.reduce((sum, part) => sum + part.index.length, 0));
  let next = 0;
  for (const { points, index: corners } of parts) {
    const vertices = new Uint32Array(points.length / 3);
    for (let i = 0; i < vertices.length; ++i) {
      vertices[i] = table.vertex(points[3 * i] - origin.x, points[3 * i + 1] - origin.y, points[3 * i + 2] - origin.z);
    }
    for (const corner of corners) index[next++] = vertices[corner];
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(table.positions.slice(0, 3 * table.count), 3));
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  return geometry;
}

const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color('magenta');
const origin = new THREE.Vector3();

const meshes = [];

/** Loads the tiles as one more mesh: {number, vertices, welded, triangles}. */
globalThis.loadMesh = async (urls) => {
  const parts = [];
  for (let i = 0; i < urls.length; i += atOnce) {
    parts.push(...(await Promise.all(urls.slice(i, i + atOnce).map(load))).flat());
  }
  const geometry = weld(parts, origin);
  const mesh = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color: 'white' }));
  mesh.frustumCulled = false;
  scene.add(mesh);
  return {
    number: meshes.push(mesh) - 1, vertices: parts.reduce((sum, { points }) => sum + points.length / 3, 0),
    welded: geometry.attributes.position.count, triangles: geometry.index.count / 3,
  };
};

/** Draws that mesh alone as the camera sees it. */
globalThis.drawMesh = (number, { position, target, fov, near, far }) => {
  meshes.forEach((mesh, i) => { mesh.visible = i === number; });
  const camera = new THREE.PerspectiveCamera(fov, innerWidth / innerHeight, near, far);
  camera.up.set(0, 0, 1);
  camera.position.set(...position).sub(origin);
  camera.lookAt(new THREE.Vector3(...target).sub(origin));
  renderer.render(scene, camera);
};

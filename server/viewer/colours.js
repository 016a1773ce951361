// What a tile's surface is coloured by.
import { BackSide, BufferAttribute, Color, DoubleSide, FrontSide, MeshBasicMaterial, MeshStandardMaterial } from 'three';

export const MODES = ['natural', 'materials', 'clay', 'levels'];

const LEVELS = ['#d1495b', '#edae49', '#66a182', '#2e7ea6', '#8d6bb8', '#c97fa8', '#7fb7be', '#a9b665'];
export const levelColour = (level) => LEVELS[level % LEVELS.length];

// Tiles that differ from those they are compared to.
export const CHANGES = { changed: '#2f8bff', added: '#35b26a', gone: '#d8455a' };

// The inner side of the ground, seen from below or where it is cut open: darker rock.
const BACKS = `
  if (!gl_FrontFacing) diffuseColor.rgb = mix(diffuseColor.rgb, vec3(0.27, 0.21, 0.16), 0.75);`;

const made = new Map(); // by what it shows
const shared = { side: FrontSide, shadowSide: BackSide, clippingPlanes: null };

function surface(name, options) {
  if (!made.has(name)) {
    const material = new MeshStandardMaterial({ roughness: 1, metalness: 0, clipShadows: true, ...shared, ...options });
    material.onBeforeCompile = (shader) => {
      shader.fragmentShader = shader.fragmentShader.replace('#include <color_fragment>', `#include <color_fragment>${BACKS}`);
    };
    made.set(name, material);
  }
  return made.get(name);
}

export const wire = new MeshBasicMaterial({
  color: '#101820', wireframe: true, transparent: true, opacity: 0.28, depthWrite: false,
  polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1,
});

// How all surfaces are drawn: `plane` cuts off what lies behind it (or null), `bothSides` draws inner sides.
export function setSurfaces({ plane, bothSides }) {
  shared.clippingPlanes = wire.clippingPlanes = plane ? [plane] : null;
  shared.side = bothSides ? DoubleSide : FrontSide;
  shared.shadowSide = plane ? DoubleSide : BackSide; // where inner sides are cut off, the outer ones keep hollows dark
  for (const material of made.values()) {
    Object.assign(material, shared);
    material.needsUpdate = true;
  }
}

// Calls `use` while rays hit both sides of surfaces.
export function withBothSides(use) {
  for (const material of made.values()) material.side = DoubleSide;
  try {
    return use();
  } finally {
    for (const material of made.values()) material.side = shared.side;
  }
}

const OPTIONS = {
  coloured: () => ({ vertexColors: true }),
  clay: () => ({ color: '#c9c2b8' }),
  levels: (level) => ({ color: levelColour(level) }),
};

function materialOf(kind, level, change) {
  const tint = change && { emissive: CHANGES[change], emissiveIntensity: 0.24 };
  const name = `${kind} ${kind === 'levels' ? level : ''} ${change ?? ''}`;
  return surface(name, { ...OPTIONS[kind](level), ...tint });
}

// What the tile says of the material with a feature id: name, color (sRGB, 0 to 1), resistance, friction.
export function materialOfFeature(mesh, id) {
  return mesh.userData.structuralMetadata?.getPropertyTableData([0], [id])[0] ?? null;
}

// Name and colour of every material of a mesh, by feature id.
function materialTable(mesh, ids) {
  const { structuralMetadata } = mesh.userData;
  if (!structuralMetadata) return [];
  let last = 0;
  for (let i = 0; i < ids.count; ++i) last = Math.max(last, ids.getX(i));
  const all = [...Array(last + 1).keys()];
  return structuralMetadata.getPropertyTableData(all.map(() => 0), all).map(({ name, color }) => ({
    name: name ?? '', colour: new Color().setRGB(color?.x ?? 1, color?.y ?? 1, color?.z ?? 1, 'srgb'),
  }));
}

// One colour per material in place of the baked blend, linear as COLOR_0 is.
function materialColours(mesh) {
  const ids = mesh.geometry.getAttribute('_feature_id_0');
  if (!ids) return null;
  const table = materialTable(mesh, ids);
  if (table.length === 0) return null;
  const colours = new Uint8Array(ids.count * 3);
  for (let i = 0; i < ids.count; ++i) {
    const { colour } = table[ids.getX(i)];
    colours.set([colour.r * 255, colour.g * 255, colour.b * 255].map(Math.round), i * 3);
  }
  mesh.userData.materialTable = table;
  return new BufferAttribute(colours, 3, true);
}

// Colours `mesh` of a tile at `level`; what it needs beyond the file is made once. `change`: one of CHANGES or none.
export function colourMesh(mesh, mode, level, change) {
  const { geometry, userData } = mesh;
  if (userData.natural === undefined) userData.natural = geometry.getAttribute('color') ?? null;
  if (mode === 'materials' && userData.byMaterial === undefined) {
    userData.byMaterial = materialColours(mesh);
  }
  const colours = mode === 'materials' ? userData.byMaterial ?? userData.natural : userData.natural;
  if (colours) geometry.setAttribute('color', colours);
  const plain = mode === 'clay' || !colours ? 'clay' : 'coloured';
  mesh.material = materialOf(mode === 'levels' ? 'levels' : plain, level, change);
}

// What a tile's surface is coloured by.
import { BufferAttribute, Color, MeshBasicMaterial, MeshStandardMaterial } from 'three';

export const MODES = ['natural', 'materials', 'clay', 'levels'];

const LEVELS = ['#d1495b', '#edae49', '#66a182', '#2e7ea6', '#8d6bb8', '#c97fa8', '#7fb7be', '#a9b665'];
export const levelColour = (level) => LEVELS[level % LEVELS.length];

const surface = (options) => new MeshStandardMaterial({ roughness: 1, metalness: 0, ...options });
const coloured = surface({ vertexColors: true });
const clay = surface({ color: '#c9c2b8' });
const byLevel = new Map();
export const wire = new MeshBasicMaterial({
  color: '#101820', wireframe: true, transparent: true, opacity: 0.28, depthWrite: false,
  polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1,
});

function levelMaterial(level) {
  if (!byLevel.has(level)) byLevel.set(level, surface({ color: levelColour(level) }));
  return byLevel.get(level);
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

// Colours `mesh` of a tile at `level`; what it needs beyond the file is made once.
export function colourMesh(mesh, mode, level) {
  const { geometry, userData } = mesh;
  if (userData.natural === undefined) userData.natural = geometry.getAttribute('color') ?? null;
  if (mode === 'materials' && userData.byMaterial === undefined) {
    userData.byMaterial = materialColours(mesh);
  }
  const colours = mode === 'materials' ? userData.byMaterial ?? userData.natural : userData.natural;
  if (colours) geometry.setAttribute('color', colours);
  if (mode === 'levels') mesh.material = levelMaterial(level);
  else mesh.material = mode === 'clay' || !colours ? clay : coloured;
}

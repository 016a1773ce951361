/** One .glb as others read it: gltf-validator, gltf-transform and draco3d. */
import { readFile } from 'node:fs/promises';
import { createHash } from 'node:crypto';
import { NodeIO, Logger, Verbosity } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import draco3d from 'draco3d';
import draco3dgltf from 'draco3dgltf';
import validator from 'gltf-validator';

const draco = await draco3d.createDecoderModule({});
const io = new NodeIO()
  .setLogger(new Logger(Verbosity.ERROR))
  .registerExtensions(ALL_EXTENSIONS)
  .registerDependencies({ 'draco3d.decoder': await draco3dgltf.createDecoderModule() });

/** Reads a file and everything that the tools make of it. */
export async function readContent(file) {
  const bytes = new Uint8Array(await readFile(file));
  const digest = createHash('sha256').update(bytes).digest('hex');
  const issues = await validate(bytes, '');
  const { json, binary } = splitGlb(bytes);
  const document = await io.readBinary(bytes);
  for (const extension of document.getRoot().listExtensionsUsed()) {
    if (extension.extensionName === 'KHR_draco_mesh_compression') extension.dispose();
  }
  issues.push(...await validate(await io.writeBinary(document), ', decoded'));

  const parts = [];
  for (const [n, node] of (json.nodes ?? []).entries()) {
    if (node.mesh === undefined) continue;
    const primitives = document.getRoot().listNodes()[n].getMesh().listPrimitives();
    for (const [i, primitive] of json.meshes[node.mesh].primitives.entries()) {
      parts.push(readPrimitive(json, binary, primitive, primitives[i], node, issues));
    }
  }
  return { bytes: bytes.length, digest, materials: materialNames(json, binary), parts, issues };
}

/** The names in the property table of materials (EXT_structural_metadata). */
function materialNames(json, binary) {
  const table = json.extensions?.EXT_structural_metadata?.propertyTables?.[0];
  const column = table?.properties?.name;
  if (!column) return [];
  const view = (index) => {
    const { byteOffset = 0, byteLength } = json.bufferViews[index];
    return binary.slice(byteOffset, byteOffset + byteLength);
  };
  const Offsets = { UINT8: Uint8Array, UINT16: Uint16Array, UINT32: Uint32Array }[column.stringOffsetType ?? 'UINT32'];
  const text = view(column.values), ends = new Offsets(view(column.stringOffsets).buffer);
  return Array.from({ length: table.count }, (_, i) => new TextDecoder().decode(text.subarray(ends[i], ends[i + 1])));
}

/** Errors and warnings of gltf-validator, in words. */
async function validate(bytes, which) {
  const report = await validator.validateBytes(bytes, { maxIssues: 100, writeTimestamp: false });
  return report.issues.messages
    .filter((m) => m.severity <= 1)
    .map((m) => `gltf-validator${which}: ${m.code} ${m.message} ${m.pointer ?? ''}`);
}

function splitGlb(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const length = view.getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
  return { json, binary: bytes.subarray(20 + length + 8) };
}

/** One primitive's arrays, by draco3d where it is compressed, held against gltf-transform's. */
function readPrimitive(json, binary, primitive, other, node, issues) {
  const names = ['POSITION', 'NORMAL', '_FEATURE_ID_0'];
  const fromOther = { indices: new Uint32Array(other.getIndices().getArray()) };
  for (const name of names) fromOther[name] = other.getAttribute(name)?.getArray();
  const compressed = primitive.extensions?.KHR_draco_mesh_compression;
  const arrays = compressed ? decode(json, binary, compressed) : fromOther;
  for (const name of [...names, 'indices']) {
    if (!arrays[name] || !fromOther[name]) issues.push(`a primitive has no ${name}`);
    else if (!sameBits(arrays[name], fromOther[name])) {
      issues.push(`draco3d and gltf-transform decode ${name} differently`);
    }
  }
  if (arrays.POSITION) checkAccessors(json, primitive, arrays, issues);
  if (node.rotation || node.scale || node.matrix) issues.push('a node is not a translation alone');
  return {
    skirt: primitive.extras?.hoodoo?.role === 'skirt',
    translation: node.translation ?? [0, 0, 0],
    positions: arrays.POSITION ?? new Float32Array(), normals: arrays.NORMAL ?? new Float32Array(),
    ids: arrays._FEATURE_ID_0 ?? [], triangles: arrays.indices,
    features: primitive.extensions?.EXT_mesh_features?.featureIds?.[0],
  };
}

const bitsOf = (array) =>
  array instanceof Float32Array ? new Uint32Array(array.buffer, array.byteOffset, array.length) : array;
function sameBits(a, b) {
  const p = bitsOf(a), q = bitsOf(b);
  if (p.length !== q.length) return false;
  for (let i = 0; i < p.length; ++i) if (p[i] !== q[i]) return false;
  return true;
}

/** The uncompressed accessors' counts and bounds are what decoding gives. */
function checkAccessors(json, primitive, arrays, issues) {
  const position = json.accessors[primitive.attributes.POSITION];
  if (position.count * 3 !== arrays.POSITION.length) issues.push('POSITION has another count than decoded');
  if (json.accessors[primitive.indices].count !== arrays.indices.length) {
    issues.push('the indices have another count than decoded');
  }
  for (let a = 0; a < 3; ++a) {
    let low = Infinity, high = -Infinity;
    for (let i = a; i < arrays.POSITION.length; i += 3) {
      low = Math.min(low, arrays.POSITION[i]);
      high = Math.max(high, arrays.POSITION[i]);
    }
    if (position.min?.[a] !== low || position.max?.[a] !== high) {
      issues.push(`POSITION states other bounds than decoded on axis ${a}: ` +
                  `[${position.min?.[a]}, ${position.max?.[a]}] for [${low}, ${high}]`);
    }
  }
}

function decode(json, binary, compressed) {
  const view = json.bufferViews[compressed.bufferView];
  const bytes = binary.subarray(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength);
  const decoder = new draco.Decoder(), mesh = new draco.Mesh();
  try {
    const status = decoder.DecodeArrayToMesh(new Int8Array(bytes), bytes.length, mesh);
    if (!status.ok()) throw new Error(`draco3d: ${status.error_msg()}`);
    const heap = (Type, length, fill) => {
      const pointer = draco._malloc(length * Type.BYTES_PER_ELEMENT);
      fill(length * Type.BYTES_PER_ELEMENT, pointer);
      const values = new Type(draco.HEAPU8.buffer, pointer, length).slice();
      draco._free(pointer);
      return values;
    };
    const arrays = {
      indices: heap(Uint32Array, 3 * mesh.num_faces(),
                    (size, to) => decoder.GetTrianglesUInt32Array(mesh, size, to)),
    };
    const types = { [draco.DT_FLOAT32]: Float32Array, [draco.DT_UINT8]: Uint8Array, [draco.DT_UINT16]: Uint16Array };
    for (const [name, id] of Object.entries(compressed.attributes)) {
      const attribute = decoder.GetAttributeByUniqueId(mesh, id), type = attribute.data_type();
      arrays[name] = heap(types[type], mesh.num_points() * attribute.num_components(),
                          (size, to) => decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, type, size, to));
    }
    return arrays;
  } finally {
    draco.destroy(mesh);
    draco.destroy(decoder);
  }
}

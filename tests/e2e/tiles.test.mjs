/** The checker itself: silent about a sound tileset, and it names each planted fault. */
import assert from 'node:assert/strict';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { check } from './tiles.mjs';
import { makeTileset } from './tiles/made.mjs';

async function checked(spoil) {
  const folder = await mkdtemp(join(tmpdir(), 'hoodoo-tiles-'));
  try {
    await makeTileset(folder, spoil);
    return await check(folder, { workers: 1 });
  } finally {
    await rm(folder, { recursive: true });
  }
}

test('A sound tileset has no problem', async () => {
  const found = await checked();
  assert.deepEqual(found.problems, []);
  assert.equal(found.tiles, 5);
  assert.equal(found.triangles, 5 * 512);
  assert.equal(found.skirtTriangles, 5 * 32);
  assert.deepEqual(found.euler, { 0: 1, 1: 1 });
  assert.deepEqual(found.rims, { 0: 1, 1: 1 });
  assert.equal(found.borderVertices, 2 * 4 * 17);
  assert.equal(found.openInside, 0);
  assert.deepEqual(found.materials, { rock: 5 * 512 });
});

const inTile = (wanted, change) => ({ tile: (key, content) => key === wanted && change(content) });
const middle = 8 * 17 + 8, eastern = 8 * 17 + 16;   // vertices inside the tile and on its eastern border

const planted = {
  'a border vertex one step off': [inTile('0/0/0', ({ surface }) => { surface.points[eastern][2] += 1 / 256; }),
                                   /lattice columns between two tiles with an open edge on both sides/],
  'a border normal turned': [inTile('0/0/0', ({ surface }) => { surface.normals[eastern] = [0, 0, 1]; }),
                             /2 border vertices whose partner has another normal/],
  'a vertex between two steps': [inTile('0/0/0', ({ surface }) => { surface.points[middle][2] += 1 / 1024; }),
                                 /no multiple of the step/],
  'a missing triangle': [inTile('0/0/0', ({ surface }) => { surface.triangles.splice(200, 1); }),
                         /open edges that lie in no plane|open edge on both sides/],
  'a triangle twice': [inTile('0/0/0', ({ surface }) => { surface.triangles.push(surface.triangles[200]); }),
                       /triangles that repeat another/],
  'a triangle turned over': [inTile('0/0/0', ({ surface }) => { surface.triangles[200].reverse(); }),
                             /turned against each other/],
  'a triangle without area': [inTile('0/0/0', ({ surface }) => { surface.points[middle] = surface.points[middle + 1]; }),
                              /triangles without area/],
  'a triangle of two materials': [inTile('0/0/0', ({ surface }) => { surface.ids[middle] = 0; }),
                                  /more than one material/],
  'a material that is not listed': [inTile('0/0/0', ({ surface }) => { surface.ids.fill(7); }), /no table lists/],
  'a skirt off its plane': [inTile('0/0/0', ({ skirt }) => { skirt.points[3][0] += 1; }), /leave the tile's border planes/],
  'a skirt facing in': [inTile('0/0/0', ({ skirt }) => { skirt.triangles.forEach((t) => t.reverse()); }),
                        /do not face out/],
  'a surface beyond its tile': [inTile('0/1/1', ({ surface }) => { surface.points[eastern][0] += 1; }),
                                /outside the tile's area/],
  'two surfaces touching in a point': [inTile('0/0/0', ({ surface }) => {
    const n = surface.points.push([8, 8, 20], [9, 8, 20], [8, 9, 20]);
    surface.normals.push([0, 0, 1], [0, 0, 1], [0, 0, 1]);
    surface.ids.push(1, 1, 1);
    const [a, b, c] = [n - 3, n - 2, n - 1];
    surface.triangles.push([middle, b, a], [middle, c, b], [middle, a, c], [a, b, c]);
  }), /the surface touches itself/],
  'a box too small': [{ tree: ({ root }) => { root.children[2].boundingVolume.box[11] /= 2; } }, /leaves its tile's box/],
  "a child beyond its parent's box": [{ tree: ({ root }) => { root.boundingVolume.box[3] /= 2; } },
                                      /leaves the box of the tile 1 above/],
  'an error that does not fall': [{ tree: ({ root }) => { root.geometricError = 0; } }, /has the geometricError 0, its parent 0/],
  'a leaf with an error': [{ tree: ({ root }) => { root.children[0].geometricError = 1; } }, /is a leaf with/],
  'a tile left out of the index': [{ tree: ({ root }) => { root.children.pop(); } }, /is in no tileset/],
  'a count that is wrong in bake.json': [{ bake: ({ tiles }) => { ++tiles[2].triangles; } }, /has 512 triangles, bake.json says 513/],
  "an open edge that is not the world's": [{ bake: ({ tiles }) => { --tiles[1].world_edges; } },
                                            /128 open edges, 127 of them the world's/],
  'a file that is not there': [{ tree: ({ root }) => { root.children[0].content.uri = `tiles/${'0'.repeat(64)}.glb`; } },
                               /bake.json does not know it/],
};
for (const [what, [spoil, message]] of Object.entries(planted)) {
  test(`The checker finds ${what}`, async () => {
    const found = await checked(spoil);
    assert.ok(found.problemCount > 0);
    assert.match(found.problems.join('\n'), message);
  });
}

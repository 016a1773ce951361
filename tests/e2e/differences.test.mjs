/** What the viewer lists of two bakes beside each other. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { differences } from '../../server/viewer/compare.js';

test('A comparison tells added, gone and changed tiles, level by level, and needs one lattice', () => {
  const bake = (tiles, spacing = 1) => ({
    header: { lattice: { spacing }, frame: {} },
    tiles: new Map(Object.entries(tiles).map(([key, digests]) => [key, { key, digests }])),
  });
  const old = bake({ '0/0/0': ['a'], '0/10/0': ['b'], '0/2/0': ['c', 'd'], '1/0/0': ['e'] });
  const found = differences(old, bake({ '0/0/0': ['a'], '0/2/0': ['c', 'x'], '0/3/1': ['f'], '1/0/0': ['g'] }));
  assert.deepEqual(found.map(({ key, change }) => [key, change]),
                   [['0/2/0', 'changed'], ['0/3/1', 'added'], ['0/10/0', 'gone'], ['1/0/0', 'changed']]);
  assert.deepEqual(differences(old, old), []);
  assert.equal(differences(old, bake({}, 2)), null);
});

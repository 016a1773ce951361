/** Scenes made wrong from good ones: the same for the same seed. */

const huge = [1e308, -1e308, 5e-324, 2 ** 53, -(2 ** 63), 1e21, 0, -0, -1, 0.5];
const odd = ['NaN', 'Infinity', '-inf', '', ' ', '\0', '\u202e', 'x'.repeat(10_000), '../../etc/passwd', '/etc/passwd', 'file:///etc/passwd', '..\\..\\x', '%2e%2e/%2e%2e/etc/passwd',
             'http://127.0.0.1:1/', '/vsicurl/http://127.0.0.1:1/a.tif', '/dev/zero', '/proc/self/environ', 'sha256-0', '.', 'dem.tif\0.png', '$(id)', '<script>', '__proto__', '#/define/a'];

/** Every place in a document: [parent, key]. */
function places(value, found = []) {
  if (value === null || typeof value !== 'object') return found;
  for (const key of Object.keys(value)) {
    found.push([value, key]);
    places(value[key], found);
  }
  return found;
}

const nest = (depth) => {
  let value = 1;
  for (let i = 0; i < depth; ++i) value = i % 2 ? [value] : { child: value };
  return value;
};

/** What may be done to the value at one place. */
const ways = {
  another_type: (parent, key, pick) => {
    const other = [null, true, 7, 'text', [], {}, [[]], { type: 'sphere' }].filter((value) => typeof value !== typeof parent[key]);
    parent[key] = pick(other);
  },
  a_huge_number: (parent, key, pick) => { parent[key] = pick(huge); },
  an_odd_text: (parent, key, pick) => { parent[key] = pick(odd); },
  depth: (parent, key, pick) => { parent[key] = nest(pick([5, 40, 100, 1000])); },
  missing: (parent, key) => {
    if (Array.isArray(parent)) parent.splice(Number(key), 1);
    else delete parent[key];
  },
  another_name: (parent, key, pick) => {
    const value = parent[key];
    if (Array.isArray(parent)) { parent.push(value, value); return; }
    delete parent[key];
    parent[pick([`${key}x`, '', 'a/b~c', '\u0000', ...odd])] = value;
  },
  a_reference: (parent, key, pick) => { parent[key] = pick([{ use: 'nothing' }, { use: key }, { href: 'http://127.0.0.1:1/' }, { $ref: '#' }, { type: 'nothing' }, { use: '../../etc/passwd' }]); },
  many: (parent, key) => { parent[key] = Array.from({ length: 2000 }, () => parent[key]); },
  itself: (parent, key) => { parent[key] = structuredClone(parent); },
};

/** `scene` with one to four things done to it; `random` gives numbers in [0, 1). {scene, how} */
export function mutate(scene, random) {
  const pick = (all) => all[Math.floor(random() * all.length)];
  const made = structuredClone(scene), how = [];
  for (let left = 1 + Math.floor(random() * 4); left > 0; --left) {
    const all = places(made);
    if (all.length === 0) break;
    const [parent, key] = pick(all), way = pick(Object.keys(ways));
    ways[way](parent, key, pick);
    how.push(`${way} ${key.slice(0, 40)}`);
  }
  return { scene: made, how: how.join(', ') };
}

// The example scenes that come with the viewer, with their elevations.
const folder = new URL('examples/', import.meta.url);

async function get(path) {
  const response = await fetch(new URL(path, folder), { cache: 'no-cache' });
  if (!response.ok) throw new Error(`examples/${path}: ${response.status} ${response.statusText}`);
  return response;
}

// [{name, title, dem}], by title.
export async function listExamples() {
  const all = await (await get('index.json')).json();
  return all.sort((a, b) => a.title.localeCompare(b.title, 'en'));
}

// The text of an example's scene, and its elevations as a file, or null where they do not come with it.
export async function openExample({ name, dem }) {
  const text = await (await get(`${name}/scene.json`)).text();
  if (!dem) return { text, file: null };
  const blob = await (await get(`${name}/dem.tif`)).blob();
  return { text, file: new File([blob], `${name}.tif`) };
}

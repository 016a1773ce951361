// Reads an elevation model beside the page: first its picture, then its digest, which may take long.
import { sha256 } from './client.js';
import { readRelief, shade } from './hillshade.js';

async function picture(file) {
  try {
    const relief = await readRelief(file);
    const { rgba, least, most, holes } = shade(relief);
    const { width, height, size, spacing, part } = relief;
    postMessage({ type: 'picture', rgba, width, height, size, spacing, part, least, most, holes }, [rgba.buffer]);
  } catch (error) {
    postMessage({ type: 'no picture', message: String(error.message ?? error) });
  }
}

addEventListener('message', async ({ data: file }) => {
  try {
    await picture(file);
    const digest = await sha256(file, { onProgress: (done, total) => postMessage({ type: 'read', done, total }) });
    postMessage({ type: 'digest', digest });
  } catch (error) {
    postMessage({ type: 'error', message: `The file cannot be read: ${error.message}` });
  }
});

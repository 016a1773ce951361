// The drop zone of elevation models: shows one, sends it where the service does not have it, and tells its name.
import { assetName } from './client.js';
import { explain, service, withKey } from './session.js';

const element = (id) => document.getElementById(id);
const number = new Intl.NumberFormat('en', { maximumFractionDigits: 1 });
const whole = new Intl.NumberFormat('en', { maximumFractionDigits: 0 });
const bytes = new Intl.NumberFormat('en', { notation: 'compact', maximumFractionDigits: 1, style: 'unit', unit: 'byte', unitDisplay: 'narrow' });
const KINDS = ['49492a00', '4d4d002a', '49492b00', '4d4d002b'];  // TIFF and BigTIFF

async function isTiff(file) {
  const start = new Uint8Array(await file.slice(0, 4).arrayBuffer());
  return KINDS.includes([...start].map((byte) => byte.toString(16).padStart(2, '0')).join(''));
}

// Where the browser allows no storage, an upload does not outlive the page.
function storage() {
  try {
    return localStorage;
  } catch {
    return undefined;
  }
}

export class DropZone {
  // `onReady(name, file)` is called with sha256-HEX as soon as the service has a file.
  constructor(onReady) {
    this.onReady = onReady;
    this.stopped = new AbortController();
    this.said = '';
    const zone = element('drop');
    element('file').addEventListener('change', ({ target }) => {
      if (target.files[0]) this.take(target.files[0]);
      target.value = '';
    });
    for (const name of ['dragenter', 'dragover']) {
      zone.addEventListener(name, (event) => { event.preventDefault(); zone.classList.add('over'); });
    }
    zone.addEventListener('dragleave', (event) => { if (!zone.contains(event.relatedTarget)) zone.classList.remove('over'); });
    // A file that misses the zone would be opened in place of the page.
    addEventListener('dragover', (event) => event.preventDefault());
    addEventListener('drop', (event) => {
      event.preventDefault();
      zone.classList.remove('over');
      const { files } = event.dataTransfer;
      if (files.length > 0 && zone.contains(event.target)) this.take(files[0], files.length > 1);
    });
    element('upload-stop').addEventListener('click', () => this.stopped.abort());
  }

  // Asks for a file where the scene comes without one.
  ask() {
    this.#say('Its elevations do not come with it: drop any GeoTIFF here.');
  }
  // Says more, in place of what was said so before.
  add(text) {
    element('upload-message').textContent = `${this.said} ${text}`.trim();
  }

  // Shows and sends a file, one of `many`; gives its name, or null where that failed or was given up.
  async take(file, many = false) {
    this.stopped.abort();
    const stopped = this.stopped = new AbortController();
    element('preview').hidden = true;
    this.#say(`${file.name}, ${bytes.format(file.size)}`, '');
    try {
      if (!await isTiff(file)) throw new Error(`${file.name} is no TIFF file.`);
      this.#progress(0, 1);
      const digest = await this.#read(file, stopped.signal);
      await withKey(() => service.upload(file, {
        sha256: digest, signal: stopped.signal, storage: storage(),
        onProgress: (sent, total) => { this.#progress(sent, total); this.#say(`Sending ${file.name}: ${bytes.format(sent)} of ${bytes.format(total)}.`); },
        onRetry: (error) => this.#say(`${explain(error)} Trying again.`),
      }));
      this.#say(`${file.name} is on the server.${many ? ' Only the first file was taken.' : ''}`, 'good');
      this.onReady(assetName(digest), file);
      return assetName(digest);
    } catch (error) {
      if (this.stopped !== stopped) return null;  // another file has come
      this.#say(stopped.signal.aborted ? 'Stopped; the same file goes on from where it was.' : explain(error), 'bad');
      return null;
    } finally {
      if (this.stopped === stopped) element('upload').hidden = true;
    }
  }

  #say(text, kind = '') {
    this.said = text;
    element('upload-message').textContent = text;
    element('upload-message').dataset.kind = kind;
  }
  #progress(done, total) {
    element('upload').hidden = false;
    element('upload-progress').value = done / Math.max(total, 1);
  }

  // Its digest; shows its picture on the way. Errors: of the file, the signal's reason.
  #read(file, signal) {
    const worker = new Worker(new URL('dem_worker.js', import.meta.url), { type: 'module' });
    return new Promise((resolve, reject) => {
      signal.addEventListener('abort', () => reject(signal.reason), { once: true });
      worker.addEventListener('error', () => reject(new Error('The file cannot be read here.')));
      worker.addEventListener('message', ({ data }) => {
        if (data.type === 'picture') this.#show(data);
        else if (data.type === 'no picture') this.#describe('This file may be damaged: it cannot be shown.', null, data.message);
        else if (data.type === 'read') {
          this.#progress(data.done, data.total);
          this.#say(`Reading ${file.name}.`);
        } else if (data.type === 'digest') resolve(data.digest);
        else reject(new Error(data.message));
      });
      worker.postMessage(file);
    }).finally(() => worker.terminate());
  }

  #show({ rgba, width, height, size, spacing, part, least, most, holes }) {
    const steps = [...new Set((spacing ?? []).map((step) => number.format(step)))].join(' × ');
    const place = steps ? `, ${steps} m apart` : ', no place stated';
    const range = Number.isFinite(least) ? `${whole.format(least)} to ${whole.format(most)} m` : 'no elevations';
    const gaps = holes > 0 ? `, ${number.format(100 * holes)} % without data` : '';
    const what = `${whole.format(size[0])} × ${whole.format(size[1])} samples${place}; ${range}${gaps}.`;
    this.#describe(part ? `${what} The picture shows its middle.` : what, { rgba, width, height });
  }
  // `why`, for who looks closer.
  #describe(text, picture, why = '') {
    const canvas = element('hillshade');
    canvas.hidden = !picture;
    if (picture) {
      Object.assign(canvas, { width: picture.width, height: picture.height });
      canvas.getContext('2d').putImageData(new ImageData(picture.rgba, picture.width, picture.height), 0, 0);
    }
    Object.assign(element('preview-text'), { textContent: text, title: why });
    element('preview-text').dataset.kind = picture ? '' : 'bad';
    element('preview').hidden = false;
  }
}

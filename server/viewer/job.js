// A job of this server, as it goes on.
import { EventDispatcher } from 'three';

const PERIOD_MS = 1000;

async function answer(path, options) {
  const response = await fetch(path, { cache: 'no-cache', ...options });
  return response.ok ? response : null;
}

export async function listJobs() {
  const response = await answer('/jobs?limit=100');
  return response ? (await response.json()).jobs : [];
}

// Fires 'status' with what the server says, 'tileset' when it has changed, 'missing'.
export class Job extends EventDispatcher {
  constructor(id) {
    super();
    this.path = `/jobs/${encodeURIComponent(id)}`;
    this.tileset = `${this.path}/tiles/tileset.json`;
  }

  async follow() {
    for (;;) {
      const info = await this.#poll();
      if (info && info.status !== 'accepted' && info.status !== 'running') return;
      await new Promise((done) => setTimeout(done, PERIOD_MS));
    }
  }

  // The status is asked first, so that the last look at the tileset comes after the end.
  async #poll() {
    try {
      const response = await answer(this.path);
      if (!response) {
        this.dispatchEvent({ type: 'missing' });
        return { status: 'missing' };
      }
      const info = await response.json();
      this.dispatchEvent({ type: 'status', info });
      if (info.links.some(({ rel }) => rel === 'preview')) await this.#look();
      return info;
    } catch {
      return null; // the server is away; it may come back
    }
  }
  async #look() {
    const tag = (await answer(this.tileset, { method: 'HEAD' }))?.headers.get('etag');
    if (!tag || tag === this.tag) return;
    this.tag = tag;
    this.dispatchEvent({ type: 'tileset' });
  }
}

// A job of this server, as it goes on.
import { EventDispatcher } from 'three';

import { Hoodoo, Problem } from './client.js';
import { service } from './session.js';

const PERIOD_MS = 1000;

export async function listJobs() {
  try {
    return (await service.jobs({ limit: 100 })).jobs;
  } catch (error) {
    if (error instanceof Problem) return [];
    throw error;
  }
}

// Fires 'status' with what the server says, 'tileset' when it has changed, 'missing'.
export class Job extends EventDispatcher {
  constructor(id) {
    super();
    this.id = id;
    this.tileset = `${service.base}/jobs/${encodeURIComponent(id)}/tiles/tileset.json`;
  }

  async follow() {
    while (!await this.#poll()) await new Promise((done) => setTimeout(done, PERIOD_MS));
  }

  // True at the end. The status is asked first, so that the last look at the tileset comes after it.
  async #poll() {
    try {
      const info = await service.job(this.id);
      this.dispatchEvent({ type: 'status', info });
      if (info.links.some(({ rel }) => rel === 'preview')) await this.#look();
      return Hoodoo.hasEnded(info);
    } catch (error) {
      const away = !(error instanceof Problem) || error.status >= 500; // it may come back
      if (away) return false;
      this.dispatchEvent({ type: 'missing' });
      return true;
    }
  }
  async #look() {
    const response = await fetch(this.tileset, { method: 'HEAD', cache: 'no-cache' });
    const tag = response.ok && response.headers.get('etag');
    if (!tag || tag === this.tag) return;
    this.tag = tag;
    this.dispatchEvent({ type: 'tileset' });
  }
}

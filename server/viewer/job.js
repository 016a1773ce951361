// A job of this server, as it goes on.
import { EventDispatcher } from 'three';

import { Hoodoo } from './client.js';
import { BAKE, isMissing, service, withKey } from './session.js';

const LOOK_MS = 1000; // between two looks at a tileset
const MOST_LISTED = 100;

// Of bakes, newest first: {jobs, before}; a key is asked for where one is needed.
export function listJobs() {
  return withKey(() => service.jobs({ processID: [BAKE], limit: MOST_LISTED }));
}

// Fires 'status' with what the server says, 'tileset' when it has changed, 'away' while the server does not answer and
// 'back' when it does, 'missing' where there is no such job, 'error' with another error, which ends it.
export class Job extends EventDispatcher {
  constructor(id) {
    super();
    this.id = id;
    this.tileset = `${service.base}/jobs/${encodeURIComponent(id)}/tiles/tileset.json`;
    this.looking = 0; // the timer of the next look
    this.looked = false;
  }

  async follow() {
    const onRetry = () => this.dispatchEvent({ type: 'away' });
    const onConnect = () => this.dispatchEvent({ type: 'back' });
    try {
      for await (const info of service.follow(this.id, { onRetry, onConnect })) {
        this.dispatchEvent({ type: 'status', info });
        if (!info.links.some(({ rel }) => rel === 'preview')) continue;
        this.#lookSoon(!this.looked || Hoodoo.hasEnded(info) ? 0 : LOOK_MS);
      }
    } catch (error) {
      this.dispatchEvent(isMissing(error) ? { type: 'missing' } : { type: 'error', error });
    }
  }

  // A bake tells of each tile; its tileset is not read as often. The last look comes after the end.
  #lookSoon(wait) {
    if (wait === 0) clearTimeout(this.looking);
    else if (this.looking !== 0) return;
    this.looking = setTimeout(() => this.#look(), wait);
  }
  async #look() {
    this.looking = 0;
    this.looked = true;
    try {
      const response = await fetch(this.tileset, { method: 'HEAD', cache: 'no-cache' });
      const tag = response.ok && response.headers.get('etag');
      if (!tag || tag === this.tag) return;
      this.tag = tag;
      this.dispatchEvent({ type: 'tileset' });
    } catch {
      this.#lookSoon(LOOK_MS); // the server is away
    }
  }
}

import { Worker } from 'node:worker_threads';
import { availableParallelism } from 'node:os';

/** Runs jobs of examine.mjs in worker threads. */
export class Pool {
  constructor(size = availableParallelism()) {
    this.waiting = [];
    this.running = new Map();
    this.tickets = 0;
    this.workers = Array.from({ length: size }, () => this.#start());
    this.idle = [...this.workers];
  }

  run(job) {
    return new Promise((resolve, reject) => {
      this.waiting.push({ job, resolve, reject });
      this.#next();
    });
  }

  close() {
    return Promise.all(this.workers.map((worker) => worker.terminate()));
  }

  #start() {
    const worker = new Worker(new URL('./examine.mjs', import.meta.url));
    worker.on('message', ({ ticket, result }) => {
      const { resolve } = this.running.get(ticket);
      this.running.delete(ticket);
      this.idle.push(worker);
      resolve(result);
      this.#next();
    });
    worker.on('error', (error) => {
      for (const { reject } of [...this.running.values(), ...this.waiting]) reject(error);
    });
    return worker;
  }

  #next() {
    while (this.idle.length > 0 && this.waiting.length > 0) {
      const { job, ...settle } = this.waiting.shift();
      const ticket = this.tickets++;
      this.running.set(ticket, settle);
      this.idle.pop().postMessage({ ticket, job });
    }
  }
}

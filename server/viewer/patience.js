// What could not be loaded, to be asked for again after a while, which grows as long as something fails.
const FIRST_MS = 1000, LONGEST_MS = 15_000;

export class Patience {
  constructor() {
    this.waiting = new Set(); // functions that ask again
    this.failures = 0;
    this.timer = 0;
  }

  get waits() {
    return this.waiting.size > 0;
  }
  // Calls `retry` after the while.
  later(retry) {
    this.waiting.add(retry);
    if (this.timer !== 0) return;
    this.timer = setTimeout(() => this.#retry(), Math.min(LONGEST_MS, FIRST_MS * 2 ** this.failures));
    ++this.failures;
  }
  // All has come.
  rest() {
    this.failures = 0;
  }

  #retry() {
    const all = [...this.waiting];
    this.waiting.clear();
    this.timer = 0;
    for (const retry of all) retry();
  }
}

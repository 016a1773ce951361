import { Problem } from './problem.js';

/** Whether an error may go away by itself: the service was not reached, is starting, or has too much to do. */
export function untilReached(error: unknown): boolean {
  if (error instanceof Problem) return error.status >= 500 && error.status !== 507 || error.status === 408 || error.status === 429;
  return error instanceof TypeError || (error instanceof DOMException && error.name === 'NetworkError');
}

/** Waits 0.5 s, then twice as long each time, 15 s at most. Errors: the signal's reason. */
export function pause(failures: number, signal?: AbortSignal): Promise<void> {
  const seconds = Math.min(15, 0.5 * 2 ** failures);
  return new Promise((resolve, reject) => {
    signal?.throwIfAborted();
    const timer = setTimeout(end, 1000 * seconds);
    function end() {
      signal?.removeEventListener('abort', stop);
      resolve();
    }
    function stop() {
      clearTimeout(timer);
      reject(signal?.reason);
    }
    signal?.addEventListener('abort', stop, { once: true });
  });
}

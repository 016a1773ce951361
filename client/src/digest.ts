import { sha256 as hash } from '@noble/hashes/sha2.js';
import { bytesToHex } from '@noble/hashes/utils.js';

const PIECE = 4 * 2 ** 20;

/**
 * SHA-256 of a file as 64 hexadecimal digits, piece by piece, so that it need not fit in memory. Takes the time of a thread:
 * in a page, call it from a worker. Errors: the signal's reason.
 */
export async function sha256(file: Blob, { onProgress, signal }: {
  onProgress?: (done: number, total: number) => void; signal?: AbortSignal;
} = {}): Promise<string> {
  const state = hash.create();
  for (let at = 0; at < file.size; at += PIECE) {
    signal?.throwIfAborted();
    const piece = file.slice(at, Math.min(at + PIECE, file.size));
    state.update(new Uint8Array(await piece.arrayBuffer()));
    onProgress?.(at + piece.size, file.size);
  }
  return bytesToHex(state.digest());
}

/** By which scenes name an asset, and the service keeps it. */
export function assetName(digest: string): string {
  if (!/^[0-9a-f]{64}$/.test(digest)) throw new RangeError(`a SHA-256 has 64 hexadecimal digits in lower case, not ${digest}`);
  return `sha256-${digest}`;
}

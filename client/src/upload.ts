import type { Client } from 'openapi-fetch';

import type { paths } from './api.js';
import { assetName, sha256 } from './digest.js';
import { pause, untilReached } from './patience.js';
import { Problem } from './problem.js';

export interface UploadOptions {
  /** The SHA-256 of the file as 64 hexadecimal digits, where it is known. */
  sha256?: string;
  onProgress?: (sent: number, total: number) => void;
  /** Told when it broke and is about to be tried again. */
  onRetry?: (error: unknown) => void;
  signal?: AbortSignal;
  /** Remembers uploads that have begun, so that they go on after a page was closed; localStorage is one. */
  storage?: Pick<Storage, 'getItem' | 'setItem' | 'removeItem'>;
  /** Files up to so many bytes are sent as one request. */
  wholeBelow?: number;
  /** How often in a row it may fail before it is given up. */
  tries?: number;
}

const MIB = 2 ** 20;
const LEAST_PART = MIB / 4, MOST_PART = 32 * MIB, PART_MS = 1000;
const VERSION = '1.0.0';
type Api = Client<paths>;

function raw(body: Blob): { body: string; bodySerializer: () => Blob } {
  return { body: '', bodySerializer: () => body };
}
function check({ response, error }: { response: Response; error?: unknown }): Response {
  if (!response.ok) throw Problem.of(response, error);
  return response;
}

/** Asked for as a list: browsers write of every 404 in their console. */
export async function hasAsset(api: Api, asset: string, signal?: AbortSignal): Promise<boolean> {
  const { data, error, response } = await api.GET('/assets', { params: { query: { id: [asset] } }, signal, cache: 'no-store' });
  check({ response, error });
  return data?.assets.some(({ id }) => id === asset) ?? false;
}

export async function upload(api: Api, file: Blob, options: UploadOptions): Promise<string> {
  const { signal, onProgress, storage, wholeBelow = MIB, tries = 8 } = options;
  const digest = options.sha256 ?? await sha256(file, { signal });
  const asset = assetName(digest);
  const transfer = new Transfer(api, file, digest, options);
  for (let failures = 0; ; ++failures) {
    const before = transfer.offset;
    try {
      // A small file is sent as soon as it is asked for.
      if (file.size <= wholeBelow) await transfer.whole();
      else if (!await hasAsset(api, asset, signal)) await transfer.inParts();
      storage?.removeItem(asset);
      onProgress?.(file.size, file.size);
      return asset;
    } catch (error) {
      signal?.throwIfAborted();
      if (transfer.offset > before) failures = 0;
      if (failures + 1 >= tries || !(untilReached(error) || transfer.mayGoOn(error))) throw error;
      options.onRetry?.(error);
    }
    await pause(failures, signal);
  }
}

/** One file on its way, by tus 1.0. */
class Transfer {
  offset = 0;
  #id = '';
  #part = LEAST_PART;
  readonly #asset: string;

  constructor(readonly api: Api, readonly file: Blob, readonly digest: string, readonly options: UploadOptions) {
    this.#asset = assetName(digest);
    this.#id = options.storage?.getItem(this.#asset) ?? '';
  }

  /** Another request still holds the upload, it goes on from elsewhere, or it is not there any more. */
  mayGoOn(error: unknown): boolean {
    if (!(error instanceof Problem)) return false;
    if (error.status === 404 || error.status === 410) this.#forget();
    return [404, 409, 410, 423, 460].includes(error.status);
  }

  async whole(): Promise<void> {
    const { signal } = this.options;
    check(await this.api.PUT('/assets/{asset}', {
      params: { path: { asset: this.#asset } }, ...raw(this.file), headers: { 'Content-Type': 'application/octet-stream' }, signal,
    }));
  }

  async inParts(): Promise<void> {
    if (this.#id) await this.#ask();
    else await this.#create();
    while (this.offset < this.file.size) {
      this.options.onProgress?.(this.offset, this.file.size);
      await this.#send();
    }
    this.#forget();
  }

  #forget(): void {
    this.#id = '';
    this.options.storage?.removeItem(this.#asset);
  }

  async #create(): Promise<void> {
    const header = {
      'Tus-Resumable': VERSION, 'Upload-Length': this.file.size, 'Upload-Metadata': `sha256 ${btoa(this.digest)}`,
    } as const;
    const response = check(await this.api.POST('/uploads', { params: { header }, signal: this.options.signal }));
    this.#id = response.headers.get('location')?.split('/').pop() ?? '';
    this.offset = 0;
    this.options.storage?.setItem(this.#asset, this.#id);
  }

  async #ask(): Promise<void> {
    const response = check(await this.api.HEAD('/uploads/{uploadID}', {
      params: { path: { uploadID: this.#id }, header: { 'Tus-Resumable': VERSION } }, signal: this.options.signal,
    }));
    this.offset = Number(response.headers.get('upload-offset'));
  }

  /** Parts grow until each takes about a second, so that progress can be told and little is sent again. */
  async #send(): Promise<void> {
    const { offset, file, options: { signal } } = this;
    const from = performance.now();
    const response = check(await this.api.PATCH('/uploads/{uploadID}', {
      params: { path: { uploadID: this.#id }, header: { 'Tus-Resumable': VERSION, 'Upload-Offset': offset } },
      ...raw(file.slice(offset, offset + this.#part)), headers: { 'Content-Type': 'application/offset+octet-stream' }, signal,
    }));
    this.offset = Number(response.headers.get('upload-offset'));
    const took = performance.now() - from;
    if (took < PART_MS / 2) this.#part = Math.min(2 * this.#part, MOST_PART);
    else if (took > 2 * PART_MS) this.#part = Math.max(this.#part / 2, LEAST_PART);
  }
}

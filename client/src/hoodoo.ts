import createClient from 'openapi-fetch';
import type { Client } from 'openapi-fetch';

import type { components, paths } from './api.js';
import { readEvents } from './events.js';
import { pause, untilReached } from './patience.js';
import { Problem } from './problem.js';
import { hasAsset, upload } from './upload.js';
import type { UploadOptions } from './upload.js';

export type Job = components['schemas']['statusInfo'];
export type Finding = components['schemas']['error'];
export type Results = Record<string, { href: string; type?: string }>;
export type JobQuery = NonNullable<paths['/jobs']['get']['parameters']['query']>;
/** `before` asks for the next page, where there is one. */
export interface JobPage { jobs: Job[]; before: number | undefined }
export interface Execution { priority?: number; idempotencyKey?: string; signal?: AbortSignal }
export interface FollowOptions {
  signal?: AbortSignal;
  /** Called when the service was not reached and is asked once more, with what was thrown. */
  onRetry?: (error: unknown) => void;
  /** Called when the service answers again after that, before the next change. */
  onConnect?: () => void;
}
export interface ClientOptions {
  /** The bearer key, or what gives it at each request. */
  key?: string | (() => string | null | undefined);
  fetch?: (request: Request) => Promise<Response>;
}

const ENDED: readonly string[] = ['successful', 'failed', 'dismissed'];

type Answer<T> = { data?: T; error?: unknown; response: Response };
/** What was asked for. Errors: Problem. */
function need<T>({ data, error, response }: Answer<T>): T {
  if (!response.ok) throw Problem.of(response, error);
  return data as T;
}

/**
 * A service of `hoodoo serve`. Where it answers with a problem, calls throw a Problem; where it is not reached, what fetch
 * throws.
 */
export class Hoodoo {
  /** The address of the service, without a slash at its end. */
  readonly base: string;
  /** Typed calls of every operation of the service, by openapi-fetch. */
  readonly api: Client<paths>;

  constructor(base: string | URL, { key, fetch }: ClientOptions = {}) {
    this.base = String(base).replace(/\/+$/, '');
    this.api = createClient<paths>({
      baseUrl: this.base, fetch, querySerializer: { array: { style: 'form', explode: false } },
    });
    this.api.use({
      onRequest({ request }) {
        const text = typeof key === 'function' ? key() : key;
        if (text) request.headers.set('Authorization', `Bearer ${text}`);
        return request;
      },
    });
  }

  /** What is wrong with a scene: nothing, where it can be baked. */
  async validate(scene: unknown, { signal }: { signal?: AbortSignal } = {}): Promise<Finding[]> {
    const made = await this.#execute('validate-scene', { scene }, { signal });
    return (made as { problems: Finding[] }).problems;
  }

  /** Begins to bake a scene. Errors: Problem 422 with what is wrong with it. */
  submit(scene: unknown, execution: Execution = {}): Promise<Job> {
    return this.execute('bake-terrain', { scene }, execution);
  }

  /** Begins any process that makes a job. */
  async execute(process: string, inputs: Record<string, unknown>, execution: Execution = {}): Promise<Job> {
    return await this.#execute(process, inputs, execution, 'respond-async') as Job;
  }

  async #execute(processID: string, inputs: Record<string, unknown>, execution: Execution, prefer?: string) {
    const { priority = 0, idempotencyKey, signal } = execution;
    const header = {
      ...prefer && { Prefer: prefer }, ...idempotencyKey && { 'Idempotency-Key': idempotencyKey },
    };
    return need<unknown>(await this.api.POST('/processes/{processID}/execution', {
      params: { path: { processID }, header },
      body: { inputs: inputs as Record<string, never>, response: 'document', priority }, signal,
    }));
  }

  /** Jobs, newest first. */
  async jobs(query: JobQuery = {}, { signal }: { signal?: AbortSignal } = {}): Promise<JobPage> {
    const { jobs, links } = need(await this.api.GET('/jobs', { params: { query }, signal, cache: 'no-cache' }));
    const next = links.find(({ rel }) => rel === 'next');
    const before = next && new URL(next.href).searchParams.get('before');
    return { jobs, before: before ? Number(before) : undefined };
  }

  async job(jobID: string, { signal }: { signal?: AbortSignal } = {}): Promise<Job> {
    return need(await this.api.GET('/jobs/{jobID}', { params: { path: { jobID } }, signal, cache: 'no-cache' }));
  }

  /**
   * A job whenever it changes, until it has ended. Goes on after the connection broke or the service started again, for as
   * long as it takes unless `signal` ends it. Errors: Problem, where there is no such job; the signal's reason.
   */
  async* follow(jobID: string, { signal, onRetry, onConnect }: FollowOptions = {}): AsyncGenerator<Job> {
    let away = false;
    for (let known = '', failures = 0; ; ++failures) {
      try {
        const stream = await this.#events(jobID, known, signal);
        if (away) onConnect?.();
        away = false;
        for await (const { id, event, data } of readEvents(stream)) {
          failures = 0;
          known = id;
          yield JSON.parse(data) as Job;
          if (event === 'end') return;
        }
      } catch (error) {
        signal?.throwIfAborted();
        if (!untilReached(error)) throw error;
        away = true;
        onRetry?.(error);
      }
      await pause(failures, signal);
    }
  }

  async #events(jobID: string, known: string, signal?: AbortSignal): Promise<ReadableStream<Uint8Array>> {
    const stream = need(await this.api.GET('/jobs/{jobID}/events', {
      params: { path: { jobID }, header: known ? { 'Last-Event-ID': known } : {} }, parseAs: 'stream', signal,
    }));
    return stream as ReadableStream<Uint8Array>;
  }

  /** The job as it has ended, well or not. */
  async wait(jobID: string, { signal, onChange }: {
    signal?: AbortSignal; onChange?: (job: Job) => void;
  } = {}): Promise<Job> {
    for await (const job of this.follow(jobID, { signal })) {
      onChange?.(job);
      if (Hoodoo.hasEnded(job)) return job;
    }
    return this.job(jobID, { signal });
  }

  static hasEnded({ status }: Pick<Job, 'status'>): boolean {
    return ENDED.includes(status);
  }

  /** Cancels a job, or removes one that has ended. */
  async dismiss(jobID: string): Promise<Job> {
    return need(await this.api.DELETE('/jobs/{jobID}', { params: { path: { jobID } } }));
  }

  /** Where what a job has made can be fetched. Errors: Problem 404 before it has ended, of another kind where it failed. */
  async results(jobID: string): Promise<Results> {
    return need(await this.api.GET('/jobs/{jobID}/results', { params: { path: { jobID } } })) as Results;
  }

  /** Whether the asset of a name, sha256-HEX, is there. */
  hasAsset(name: string): Promise<boolean> {
    return hasAsset(this.api, name);
  }

  /**
   * Sends an elevation model where it is not there yet, and gives the name by which scenes know it, sha256-HEX. What breaks
   * on the way goes on from where it was.
   */
  upload(file: Blob, options: UploadOptions = {}): Promise<string> {
    return upload(this.api, file, options);
  }
}

import type { components } from './api.js';

type Body = components['schemas']['problem'];

/** What the service answered in place of what was asked for, by RFC 9457. */
export class Problem extends Error {
  readonly status: number;
  readonly title: string;
  readonly detail: string;
  /** What is wrong with what was sent, each with the JSON Pointer of its place. */
  readonly errors: components['schemas']['error'][];
  /** Seconds after which it may be tried again, where the service says so. */
  readonly retryAfter: number | undefined;

  constructor(body: Body, retryAfter?: number) {
    const [first] = body.errors ?? [];
    super(first ? `${body.detail} ${first.pointer}: ${first.detail}` : body.detail);
    this.name = 'Problem';
    this.status = body.status;
    this.title = body.title;
    this.detail = body.detail;
    this.errors = body.errors ?? [];
    this.retryAfter = retryAfter;
  }

  /** Of an answer; a proxy before the service may give one that is no problem by the standard. */
  static of(response: Response, body: unknown): Problem {
    const header = Number(response.headers.get('retry-after') ?? NaN);
    const retryAfter = Number.isFinite(header) ? header : undefined;
    const { status, statusText } = response;
    if (typeof body === 'object' && body !== null && 'detail' in body) return new Problem(body as Body, retryAfter);
    const detail = `The service answered ${status} ${statusText}.`.replace(' .', '.');
    return new Problem({ type: 'about:blank', title: statusText, status, detail }, retryAfter);
  }
}

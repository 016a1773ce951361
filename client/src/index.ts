export type { components, operations, paths } from './api.js';
export { Hoodoo } from './hoodoo.js';
export type { ClientOptions, Execution, Finding, FollowOptions, Job, JobPage, JobQuery, Results } from './hoodoo.js';
export { assetName, sha256 } from './digest.js';
export { Problem } from './problem.js';
export { readEvents } from './events.js';
export type { ServerEvent } from './events.js';
export type { UploadOptions } from './upload.js';

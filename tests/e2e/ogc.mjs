/**
 * What OGC API - Processes 1.0 (OGC 18-062r2) says of its documents, as JSON Schemas: required members, types, values and relations of
 * links. More than one member may be there: the standard lets a service add its own.
 */
import assert from 'node:assert/strict';
import { Ajv } from 'ajv';

export const relations = 'http://www.opengis.net/def/rel/ogc/1.0/';
export const exceptions = 'http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/';

const text = { type: 'string' };
const texts = { type: 'array', items: text };
const time = { type: 'string', format: 'date-time' };
const ref = (name) => ({ $ref: `#/$defs/${name}` });
const object = (required, properties) => ({ type: 'object', required, properties });
/** An array in which there is a link of each relation. */
const linksWith = (...all) => ({ allOf: [ref('links'), ...all.map((rel) => ({ contains: object(['rel'], { rel: { const: rel } }) }))] });

const description = { title: text, description: text, keywords: texts, metadata: { type: 'array' } };
const binding = { type: 'object', properties: { type: { enum: ['array', 'boolean', 'integer', 'number', 'object', 'string'] } } };

const $defs = {
  link: object(['href'], { href: { type: 'string', format: 'uri' }, rel: text, type: text, hreflang: text, title: text }),
  links: { type: 'array', items: ref('link') },
  landingPage: object(['links'], {
    title: text, description: text,
    links: linksWith('self', 'service-desc', `${relations}conformance`, `${relations}processes`),
  }),
  confClasses: object(['conformsTo'], {
    conformsTo: { type: 'array', items: { type: 'string', format: 'uri' }, uniqueItems: true,
                  contains: { const: 'http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/core' } },
  }),
  processSummary: object(['id', 'version'], {
    id: text, version: text, ...description, links: ref('links'),
    jobControlOptions: { type: 'array', uniqueItems: true, items: { enum: ['sync-execute', 'async-execute', 'dismiss'] } },
    outputTransmission: { type: 'array', uniqueItems: true, items: { enum: ['value', 'reference'] } },
  }),
  processList: object(['processes', 'links'], { processes: { type: 'array', items: ref('processSummary') }, links: linksWith('self') }),
  input: object(['schema'], {
    ...description, schema: binding,
    minOccurs: { type: 'integer' }, maxOccurs: { anyOf: [{ type: 'integer' }, { const: 'unbounded' }] },
  }),
  output: object(['schema'], { ...description, schema: binding }),
  process: { allOf: [ref('processSummary'), object(['inputs', 'outputs', 'jobControlOptions', 'links'], {
    inputs: { type: 'object', additionalProperties: ref('input') },
    outputs: { type: 'object', minProperties: 1, additionalProperties: ref('output') },
    links: linksWith(`${relations}execute`),
  })] },
  statusInfo: {
    // Of the draft of 2.0: id, processingEntityType.
    ...object(['jobID', 'type', 'status', 'id', 'processingEntityType'], {
      id: text, processingEntityType: { const: 'ogc-api-processes' }, secondsLeft: { type: 'integer', minimum: 0 },
      finishedTiles: { type: 'array', maxItems: 256, items: object(['tile', 'box'], { tile: text, box: { type: 'array', minItems: 6, maxItems: 6, items: { type: 'number' } } }) },
      processID: text, type: { const: 'process' }, jobID: text, status: { enum: ['accepted', 'running', 'successful', 'failed', 'dismissed'] },
      message: text, created: time, started: time, finished: time, updated: time,
      progress: { type: 'integer', minimum: 0, maximum: 100 }, links: linksWith('self'),
    }),
    allOf: [
      { if: object(['status'], { status: { const: 'successful' } }), then: object(['links', 'finished'], { links: linksWith(`${relations}results`), progress: { const: 100 } }) },
      { if: object(['status'], { status: { enum: ['running', 'successful'] } }), then: { required: ['started'] } },
      { if: object(['status'], { status: { enum: ['accepted', 'running'] } }), then: { not: { required: ['finished'] } } },
    ],
  },
  jobList: object(['jobs', 'links'], { jobs: { type: 'array', items: ref('statusInfo') }, links: linksWith('self') }),
  // A value by itself, or qualified, or a link to it.
  results: { type: 'object', minProperties: 1, additionalProperties: {
    if: { type: 'object', required: ['href'] }, then: ref('link'),
  } },
  exception: object(['type'], { type: { type: 'string', minLength: 1 }, title: text, status: { type: 'integer', minimum: 400, maximum: 599 }, detail: text, instance: text }),
};

const formats = {
  uri: (value) => { try { return /^[a-z][a-z0-9+.-]*:/i.test(value) && Boolean(new URL(value)); } catch { return false; } },
  'date-time': (value) => /^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)$/.test(value) && !Number.isNaN(Date.parse(value)),
};
const ajv = new Ajv({ strict: false, allErrors: true, formats });
const validators = Object.fromEntries(Object.keys($defs).map((name) => [name, ajv.compile({ $defs, $ref: `#/$defs/${name}` })]));

/** What is wrong with a document, "" when nothing is. */
export function wrongWith(name, document) {
  return validators[name](document) ? '' : ajv.errorsText(validators[name].errors);
}

/** The resources of the standard: what a GET answers there. */
const resources = [[/^\/$/, 'landingPage'], [/^\/conformance$/, 'confClasses'], [/^\/processes$/, 'processList'], [/^\/processes\/[^/]+$/, 'process'],
                   [/^\/jobs$/, 'jobList'], [/^\/jobs\/[^/]+$/, 'statusInfo'], [/^\/jobs\/[^/]+\/results$/, 'results']];

/** Holds an answer to what the standard says of its resource; gives the name of that, if it says anything. */
export async function checkAnswer(method, path, response) {
  const { status } = response;
  if (status < 200 || [204, 303, 304, 308].includes(status) || method === 'HEAD') return undefined;
  const execution = /^\/processes\/[^/]+\/execution$/.test(path);
  const known = resources.find(([pattern]) => pattern.test(path))?.[1];
  if (!known && !execution) return undefined;
  let name = known;
  if (status >= 400) name = 'exception';
  else if (execution) name = status === 201 ? 'statusInfo' : undefined;
  if (!name) return undefined;
  const document = await response.clone().json();
  const wrong = wrongWith(name, document);
  assert.equal(wrong, '', `${method} ${path} answers ${status}, which is no ${name}: ${JSON.stringify(document).slice(0, 500)}`);
  if (status === 201) {
    const location = response.headers.get('location');
    assert.ok(location && formats.uri(location) && location.endsWith(`/jobs/${document.jobID}`), `201 has the location ${location}`);
  }
  return name;
}

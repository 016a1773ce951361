/** Holds every answer of a server to its own OpenAPI document. */
import assert from 'node:assert/strict';
import { Ajv } from 'ajv';

export class Contract {
  constructor(document) {
    this.document = document;
    this.ajv = new Ajv({ strict: false, validateFormats: false, allErrors: true });
    this.ajv.addSchema({ $id: 'api', components: document.components });
    this.seen = new Set();
    // "/jobs/{jobID}/tiles/{name}": the last parameter of a file's path may hold slashes.
    this.paths = Object.keys(document.paths).map((path) => ({
      path,
      pattern: new RegExp(`^${path.replace('{name}', '(.+)').replace(/\{\w+\}/g, '([^/]+)')}$`),
    }));
  }

  /** The fetch of a server, checked. */
  of(server) {
    return async (path, options = {}) => {
      const response = await server.fetch(path, options);
      await this.check(options.method ?? 'GET', path.split('?')[0], response.clone());
      return response;
    };
  }

  async check(method, path, response) {
    const name = this.paths.find(({ pattern }) => pattern.test(path))?.path;
    assert.ok(name, `${path} is not in the document`);
    const operation = this.document.paths[name][method.toLowerCase()];
    assert.ok(operation, `${method} ${name} is not in the document`);
    const { status } = response;
    const described = operation.responses[status] ?? (status >= 400 ? operation.responses.default : undefined);
    assert.ok(described, `${method} ${name} answers ${status}, which is not in the document`);
    this.seen.add(`${method} ${name} ${operation.responses[status] ? status : 'problem'}`);
    for (const [header, { required }] of Object.entries(described.headers ?? {})) {
      assert.ok(!required || response.headers.has(header), `${method} ${name} answers ${status} without ${header}`);
    }
    if (status >= 300 && status < 400 && status !== 304) {
      assert.ok(described.headers?.Location?.required, `${method} ${name} answers ${status}, whose Location is not in the document`);
    }
    if (!described.content) return assert.equal(await response.text(), '', `${method} ${name} answers ${status} with content`);
    const type = response.headers.get('content-type').replaceAll('; ', ';');
    const file = described.content['application/octet-stream'];
    if (file) return;
    assert.ok(type in described.content, `${method} ${name} answers ${type}`);
    if (!type.includes('json')) return;
    const reference = JSON.parse(JSON.stringify(described.content[type].schema)
      .replaceAll('"#/components', '"api#/components'));
    const body = await response.json();
    assert.ok(this.ajv.validate(reference, body),
              `${method} ${name} ${status}: ${this.ajv.errorsText()} in ${JSON.stringify(body).slice(0, 500)}`);
    if (status >= 400) assert.equal(body.status, status, 'a problem tells its own status');
  }
}

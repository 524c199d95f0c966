// The OpenAPI document against the daemon: node contract.mjs URL ADMIN-TOKEN SOURCE
// Makes every call that it lists, and asks for refusals; each response must be one that it promises: status, media type, header
// fields, body. Also: the document is valid OpenAPI 3.1, and lists what server/calls/table.c does and nothing else.
// Prints what is wrong and the calls that were made; exit status 1 when anything is.
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import Ajv from 'ajv/dist/2020.js';
import { Validator } from '@seriousme/openapi-schema-validator';

const [url, admin, source] = process.argv.slice(2);
const base = 'http://quietgear.example/';
const wrong = [];
const claim = (true_, words) => true_ || wrong.push(words);

const openapi = await (await fetch(`${url}/openapi.json`)).json();

// --- the document itself ---

// The validator does not follow references out of the document; those are held against the schemas below.
const inside = JSON.parse(JSON.stringify(openapi).replaceAll(/"\$ref":"v1\/[^"]*"/g, '"type":"object"'));
const verdict = await new Validator().validate(inside);
claim(verdict.valid, `not valid OpenAPI 3.1: ${JSON.stringify(verdict.errors)}`);

const listed = Object.entries(openapi.paths).flatMap(([path, item]) => Object.keys(item).filter((key) => key !== 'parameters')
  .map((method) => `${method.toUpperCase()} ${path.replace(/\{\w+\}/g, '{}')}`)).sort();
const routes = [...readFileSync(join(source, 'server/calls/table.c'), 'utf8').matchAll(/^ {4}\{"([^"]*)",\s*QG_(GET|POST|DELETE),/gm)]
  .map((match) => `${match[2]} /${match[1]}`).sort();
for (const route of routes) claim(listed.includes(route), `${route} is not in the document`);
for (const call of listed) claim(routes.includes(call), `${call} is in the document, but not in server/calls/table.c`);

// --- schemas, at the addresses that the references mean ---

const ajv = new Ajv.default({ allErrors: true, strict: false });
for (const file of readdirSync(join(source, 'schema')).filter((name) => name.endsWith('.schema.json'))) {
  const schema = JSON.parse(readFileSync(join(source, 'schema', file), 'utf8'));
  ajv.addSchema({ ...schema, $id: `${base}v1/schemas/${file}` });
}
ajv.addSchema({ ...openapi, $id: `${base}openapi.json` });

const resolve = (node) => {
  let pointer = '';
  while (node?.$ref) {
    pointer = node.$ref;
    node = pointer.slice(2).split('/').reduce((at, key) => at[key.replaceAll('~1', '/')], openapi);
  }
  return { node, pointer };
};
const validators = new Map();
const validatorAt = (pointer) => {
  if (!validators.has(pointer)) validators.set(pointer, ajv.compile({ $ref: `${base}openapi.json${pointer}` }));
  return validators.get(pointer);
};
const escaped = (key) => key.replaceAll('~', '~0').replaceAll('/', '~1');

// --- calls ---

const made = new Map();

// Makes a call and holds the response against the document. Returns it with its body.
async function call(method, path, { parameters = {}, headers = {}, body, status, query = '' } = {}) {
  const operation = openapi.paths[path][method.toLowerCase()];
  const address = path.replace(/\{(\w+)\}/g, (_, name) => parameters[name]) + query;
  const response = await fetch(url + address, { method, headers, body, redirect: 'manual' });
  const text = await response.text();
  const name = `${method} ${path} ${response.status}`;
  const say = (words) => claim(false, `${name}: ${words}`);
  made.set(name, (made.get(name) ?? 0) + 1);
  if (status !== undefined && response.status !== status) say(`expected was ${status}: ${text.slice(0, 200)}`);
  const promised = operation.responses[response.status];
  if (!promised) { say('this status is not promised'); return { response, text }; }
  const { node, pointer } = resolve(promised);
  const at = pointer || `#/paths/${escaped(path)}/${method.toLowerCase()}/responses/${response.status}`;
  for (const [field, header] of Object.entries(node.headers ?? {})) {
    const value = response.headers.get(field);
    const optional = ['Link', 'Idempotency-Replayed', 'Preference-Applied'].includes(field);
    if (value === null) { if (!optional) say(`${field} is missing`); continue; }
    const where = resolve(header).pointer;
    if (!validatorAt(`${where}/schema`)(value)) say(`${field}: ${value}`);
  }
  const type = response.headers.get('content-type');
  if (!node.content) { if (text) say(`a body is not promised: ${text.slice(0, 100)}`); return { response, text }; }
  const media = node.content[type];
  if (!media) { say(`the media type ${type} is not promised`); return { response, text }; }
  const json = /[/+]json$/.test(type) ? JSON.parse(text) : undefined;
  if (json !== undefined && media.schema) {
    const validate = validatorAt(`${at}/content/${escaped(type)}/schema`);
    if (!validate(json)) say(ajv.errorsText(validate.errors));
    if (type === 'application/problem+json' && json.status !== response.status) say('the body states another status');
  }
  return { response, text, json };
}

const example = JSON.parse(readFileSync(join(source, 'schema/examples/case_S_optimize.json'), 'utf8'));
example.optimizer = { ...example.optimizer, random_samples: 8, simplex_iterations: 3 };
example.analysis = { ...example.analysis, speeds: { ...example.analysis?.speeds, count: 20 } };
delete example.reliability;
const type = { 'Content-Type': 'application/json' };
const authorized = { Authorization: `Bearer ${admin}` };
const document = JSON.stringify(example);
const long = JSON.stringify({ ...example, optimizer: { ...example.optimizer, random_samples: 1000000 } });

async function finished(id) {
  for (;;) {
    const { json } = await call('GET', '/v1/jobs/{id}', { parameters: { id }, headers: { Prefer: 'wait=5' }, status: 200 });
    if (json.finished_at) return json;
  }
}

// What every operation answers to what it does not like.
async function refusals() {
  for (const [path, item] of Object.entries(openapi.paths))
    for (const method of Object.keys(item).filter((key) => key !== 'parameters').map((key) => key.toUpperCase())) {
      const parameters = { id: 'nobody', file: 'none.css', name: 'nothing', token: 'nobody', webhook: 'nobody' };
      const operation = item[method.toLowerCase()];
      const promised = operation.responses;
      const headers = { ...authorized, ...(operation.requestBody ? type : {}) };
      const body = operation.requestBody ? '{}' : undefined;
      if (promised[406]) await call(method, path, { parameters, headers: { ...headers, Accept: 'image/png' }, body, status: 406 });
      if (promised[404] && path.includes('{')) await call(method, path, { parameters, headers, body, status: 404 });
      if (method !== 'GET') await call(method, path, { parameters, headers: { ...headers, Origin: 'http://evil.example' }, body, status: 403 });
      if (promised[401]) await call(method, path, { parameters, headers: { ...headers, Authorization: 'Bearer wrong' }, body, status: 401 });
      if (operation.requestBody) {
        await call(method, path, { headers, body, status: 422 });
        await call(method, path, { headers, body: '{', status: 400 });
        await call(method, path, { headers: { ...headers, 'Content-Type': 'text/plain' }, body, status: 415 });
        await call(method, path, { headers: { ...headers, 'Content-Encoding': 'gzip' }, body, status: 415 });
        await call(method, path, { headers, body: ' '.repeat((1 << 20) + 1), status: 413 });
      }
    }
  for (const query of ['?color=red', '?limit=0', '?state=asleep', '?cursor=x', '?limit=1&limit=2'])
    await call('GET', '/v1/jobs', { query, status: 400 });
}

async function everything() {
  const { text: page } = await call('GET', '/', { status: 200 });
  for (const [, file] of page.matchAll(/\/assets\/([\w.-]+)/g)) await call('GET', '/assets/{file}', { parameters: { file }, status: 200 });
  for (const path of ['/healthz', '/readyz', '/openapi.json', '/v1/examples', '/v1/jobs']) await call('GET', path, { status: 200 });
  await call('GET', '/metrics', { status: 200 });
  await call('GET', '/v1/schemas/{file}', { parameters: { file: 'job.schema.json' }, status: 200 });
  const { json: examples } = await call('GET', '/v1/examples', {});
  for (const { name } of examples.examples) {
    const { text } = await call('GET', '/v1/examples/{name}', { parameters: { name }, status: 200 });
    await call('POST', '/v1/check', { headers: type, body: text, status: 200 });
  }
  for (const accept of ['application/json', 'image/vnd.dxf'])
    await call('POST', '/v1/profile', { headers: { ...type, Accept: accept }, body: document, status: 200 });

  const { json: job } = await call('POST', '/v1/jobs', { headers: { ...type, 'Idempotency-Key': 'contract' }, body: document, status: 201 });
  await call('POST', '/v1/jobs', { headers: { ...type, 'Idempotency-Key': 'contract' }, body: document, status: 201 });
  await call('POST', '/v1/jobs', { headers: { ...type, 'Idempotency-Key': 'contract' }, body: long, status: 422 });
  const parameters = { id: job.id };
  await finished(job.id);
  await call('GET', '/v1/jobs', { query: '?state=succeeded&limit=1', status: 200 });
  for (const [tail, accepts] of Object.entries({ document: ['*/*'], result: ['*/*'], evaluations: ['application/x-ndjson', 'text/csv'],
    'frequency-response': ['application/json', 'text/csv'], profile: ['application/json', 'image/vnd.dxf'] }))
    for (const accept of accepts) {
      const path = `/v1/jobs/{id}/${tail}`;
      const { response } = await call('GET', path, { parameters, headers: { Accept: accept }, status: 200 });
      const etag = response.headers.get('etag');
      if (etag) await call('GET', path, { parameters, headers: { Accept: accept, 'If-None-Match': etag }, status: 304 });
    }
  for (let status = 202; status === 202;) // the first who asks has it computed
    ({ response: { status } } = await call('GET', '/v1/jobs/{id}/field', { parameters }));
  const { text: events } = await call('GET', '/v1/jobs/{id}/events', { parameters, status: 200 });
  const last = events.match(/^id: \d+/gm).at(-1).slice(4);
  await call('GET', '/v1/jobs/{id}/events', { parameters, headers: { 'Last-Event-ID': last }, status: 204 });
  const lines = (await call('GET', '/v1/jobs/{id}/evaluations', { parameters })).text.trim().split('\n');
  const evaluation = ajv.getSchema(`${base}v1/schemas/evaluation.schema.json`);
  for (const line of lines) claim(evaluation(JSON.parse(line)), `an evaluation: ${ajv.errorsText(evaluation.errors)}`);

  const { json: busy } = await call('POST', '/v1/jobs', { headers: type, body: long, status: 201 });
  const { json: queued } = await call('POST', '/v1/jobs', { headers: type, body: document, status: 201 });
  await call('GET', '/v1/jobs/{id}/result', { parameters: { id: queued.id }, status: 409 });
  for (;;) { // until it runs
    const { json } = await call('GET', '/v1/jobs/{id}', { parameters: { id: busy.id }, status: 200 });
    if (json.state === 'running') break;
  }
  await call('DELETE', '/v1/jobs/{id}', { parameters: { id: busy.id }, status: 409 });
  await call('POST', '/v1/jobs/{id}/cancel', { parameters: { id: queued.id }, status: 200 });
  await call('POST', '/v1/jobs/{id}/cancel', { parameters: { id: busy.id }, status: 202 });
  await finished(busy.id);
  await call('POST', '/v1/jobs/{id}/cancel', { parameters, status: 409 });
  await call('DELETE', '/v1/jobs/{id}', { parameters, status: 204 });

  const wish = JSON.stringify({ name: 'contract', scopes: ['read'] });
  const { json: token } = await call('POST', '/v1/tokens', { headers: { ...type, ...authorized }, body: wish, status: 201 });
  await call('GET', '/v1/tokens', { headers: authorized, status: 200 });
  await call('DELETE', '/v1/tokens/{token}', { parameters: { token: token.id }, headers: authorized, status: 204 });
  const hook = JSON.stringify({ url: 'http://127.0.0.1:9/hooks', events: ['job.queued', 'job.cancelled'] });
  const { json: webhook } = await call('POST', '/v1/webhooks', { headers: { ...type, ...authorized }, body: hook, status: 201 });
  await call('GET', '/v1/webhooks', { headers: authorized, status: 200 });
  const { json: told } = await call('POST', '/v1/jobs', { headers: type, body: document, status: 201 });
  await call('POST', '/v1/jobs/{id}/cancel', { parameters: { id: told.id } });
  for (const [method, tail, status] of [['GET', '', 200], ['GET', '/deliveries', 200], ['DELETE', '', 204]])
    await call(method, `/v1/webhooks/{webhook}${tail}`, { parameters: { webhook: webhook.id }, headers: authorized, status });
  await call('GET', '/v1/backup', { headers: authorized, status: 200 });
  await call('GET', '/v1/tokens', { headers: { Authorization: 'Bearer wrong' }, status: 401 });
  const { json: { entries } } = await call('GET', '/v1/audit', { query: '?limit=500', headers: authorized, status: 200 });
  for (const action of ['daemon.start', 'database.backup', 'access.refuse', 'webhook.delete', 'job.cancel'])
    claim(entries.some((entry) => entry.action === action), `the audit log has no ${action}`);
  await call('GET', '/v1/audit', { query: '?action=job&actor=nobody&subject=x&address=::1&since=2020-01-01T00:00:00Z&until=2120-01-01T00:00:00Z', headers: authorized, status: 200 });
  for (const query of ['?action=fly', '?since=yesterday', '?until=', `?actor=${'x'.repeat(300)}`, '?who=me'])
    await call('GET', '/v1/audit', { query, headers: authorized, status: 400 });
}

// An event stream does not end: its first event is enough.
async function follow() {
  const { json: busy } = await call('POST', '/v1/jobs', { headers: type, body: long, status: 201 });
  const abort = new AbortController();
  const response = await fetch(`${url}/v1/events`, { headers: { 'Last-Event-ID': '0' }, signal: abort.signal });
  made.set(`GET /v1/events ${response.status}`, 1);
  claim(response.headers.get('content-type') === 'text/event-stream', 'GET /v1/events: the media type is another');
  let text = '';
  for await (const chunk of response.body) {
    text += Buffer.from(chunk).toString();
    if (/event: job\ndata: .*\n\n/.test(text)) break;
  }
  abort.abort();
  const validate = validatorAt('#/components/schemas/Job');
  for (const [, data] of text.matchAll(/event: job\ndata: (.*)\n\n/g))
    claim(validate(JSON.parse(data)), `an event: ${ajv.errorsText(validate.errors)}`);
  await call('POST', '/v1/jobs/{id}/cancel', { parameters: { id: busy.id } });
  await finished(busy.id);
}

await everything();
await refusals();
await follow();
for (const [path, item] of Object.entries(openapi.paths))
  for (const method of Object.keys(item).filter((key) => key !== 'parameters').map((key) => key.toUpperCase()))
    claim([...made.keys()].some((name) => name.startsWith(`${method} ${path} 2`)), `${method} ${path} was never answered well`);
for (const words of wrong) console.log(words);
console.log(`${[...made.values()].reduce((a, b) => a + b)} calls of ${made.size} kinds, ${wrong.length} wrong`);
process.exit(wrong.length ? 1 : 0);

// Documents mutated from the examples get the same verdict from the daemon (POST /v1/check) and from job.schema.json:
//   node agreement.mjs URL SOURCE
// Every member of every example is left out, and replaced by values of other types and magnitudes; every object gets a member
// too many. A document that the daemon takes and the schema does not is always wrong. One that the schema takes and the daemon
// does not is right when each of the daemon's faults is listed in differences.tsv, with why a schema cannot say it.
// Prints the disagreements; exit status 1 when there is one, or a line of differences.tsv that nothing needed.
import { readFileSync, readdirSync } from 'node:fs';
import http from 'node:http';
import { join } from 'node:path';
import Ajv from 'ajv/dist/2020.js';

const [url, source] = process.argv.slice(2);
const schema = JSON.parse(readFileSync(join(source, 'schema/job.schema.json'), 'utf8'));
const validate = new Ajv.default({ allErrors: false, strict: false }).compile(schema);
const differences = readFileSync(join(source, 'tests/service/differences.tsv'), 'utf8').split('\n')
  .filter((line) => line && !line.startsWith('#'))
  .map((line) => { const [pointer, detail, why] = line.split('\t'); return { pointer: new RegExp(`^${pointer}$`), detail: new RegExp(detail), why, line, used: 0 }; });

const agent = new http.Agent({ keepAlive: true, maxSockets: 4 });
function check(body) {
  return new Promise((done, failed) => {
    const request = http.request(`${url}/v1/check`, { agent, method: 'POST', headers: { 'Content-Type': 'application/json', 'Content-Length': Buffer.byteLength(body) } }, (response) => {
      const chunks = [];
      response.on('data', (chunk) => chunks.push(chunk));
      response.on('end', () => done({ status: response.statusCode, body: JSON.parse(Buffer.concat(chunks).toString()) }));
    });
    request.on('error', failed);
    request.end(body);
  });
}

const VALUES = [null, true, 'x', '', [], {}, -1, 0, 1, 3, 0.5, 1e9, 1e-9, 1e300];

// All places of a document: [parent's path, key].
function* places(node, path = []) {
  if (node === null || typeof node !== 'object') return;
  for (const key of Object.keys(node)) {
    yield [path, Array.isArray(node) ? Number(key) : key];
    yield* places(node[key], [...path, key]);
  }
}
function* objects(node, path = []) {
  if (node === null || typeof node !== 'object') return;
  if (!Array.isArray(node)) yield path;
  for (const key of Object.keys(node)) yield* objects(node[key], [...path, key]);
}
const at = (document, path) => path.reduce((node, key) => node[key], document);

function* mutations(document) {
  yield ['as it is', document];
  for (const [path, key] of places(document)) {
    const place = '/' + [...path, key].join('/');
    const without = structuredClone(document);
    if (Array.isArray(at(without, path))) at(without, path).splice(key, 1); else delete at(without, path)[key];
    yield [`${place} left out`, without];
    for (const value of VALUES) {
      const changed = structuredClone(document);
      at(changed, path)[key] = value;
      yield [`${place} = ${JSON.stringify(value)}`, changed];
    }
  }
  for (const path of objects(document)) {
    const more = structuredClone(document);
    at(more, path).extra = 1;
    yield [`/${path.join('/')} with one more`, more];
  }
  for (const kind of ['evaluate', 'optimize', 'reliability', 'map', 'macro']) yield [`kind ${kind}`, { ...document, kind }];
}

let tried = 0, refused = 0, excused = 0;
const wrong = [];
const seen = new Set();
const queue = [];
for (const file of readdirSync(join(source, 'schema/examples')))
  for (const [what, document] of mutations(JSON.parse(readFileSync(join(source, 'schema/examples', file), 'utf8')))) {
    const body = JSON.stringify(document);
    if (seen.has(body)) continue;
    seen.add(body);
    queue.push([`${file}: ${what}`, document, body]);
  }

async function work() {
  for (let next; (next = queue.pop());) {
    const [what, document, body] = next;
    const valid = validate(document);
    const answer = await check(body);
    tried++;
    if (answer.status !== 200) refused++;
    if ((answer.status === 200) === valid) continue;
    if (![200, 422].includes(answer.status)) { wrong.push(`${what}: status ${answer.status}`); continue; }
    if (answer.status === 200) {
      wrong.push(`${what}: taken, against ${validate.errors[0].instancePath} ${validate.errors[0].message}`);
      continue;
    }
    const strange = answer.body.errors.filter(({ pointer, detail }) => {
      const known = differences.find((line) => line.pointer.test(pointer) && line.detail.test(detail));
      if (known) known.used++;
      return !known;
    });
    if (strange.length) wrong.push(`${what}: refused, valid for the schema: ${strange[0].pointer}: ${strange[0].detail}`);
    else excused++;
  }
}
await Promise.all([work(), work(), work(), work()]);
for (const line of differences) if (!line.used) wrong.push(`differences.tsv: nothing needed: ${line.line}`);
const shown = process.env.ALL ? wrong : wrong.slice(0, 40);
for (const words of shown) console.log(words);
console.log(`${tried} documents, ${refused} refused, ${excused} of these by what a schema cannot say; ${wrong.length} disagreements`);
process.exit(wrong.length ? 1 : 0);

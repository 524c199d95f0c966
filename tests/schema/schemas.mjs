// Holds documents against the JSON Schemas: node schemas.mjs NAME valid|invalid FILE...
// NAME is that of a schema ("job"). Prints every document that is not as expected; exit status 1 if there was one.
import { readFileSync, readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import Ajv from 'ajv/dist/2020.js';

const directory = join(dirname(fileURLToPath(import.meta.url)), '..', '..', 'schema');
const ajv = new Ajv.default({ allErrors: true, strict: true, strictRequired: false, allowUnionTypes: true });
const suffix = '.schema.json';
for (const file of readdirSync(directory))
  if (file.endsWith(suffix)) ajv.addSchema(JSON.parse(readFileSync(join(directory, file), 'utf8')));

const [name, expected, ...files] = process.argv.slice(2);
const validate = ajv.getSchema(name + suffix);
if (!validate || !['valid', 'invalid'].includes(expected) || files.length === 0) {
  console.error('usage: node schemas.mjs SCHEMA valid|invalid FILE...');
  process.exit(2);
}
let wrong = 0;
for (const file of files) {
  const valid = validate(JSON.parse(readFileSync(file, 'utf8')));
  if (valid === (expected === 'valid')) continue;
  wrong++;
  console.log(`${file} is ${valid ? 'valid' : 'invalid: ' + ajv.errorsText(validate.errors)}`);
}
console.log(`${files.length - wrong} of ${files.length} are ${expected}`);
process.exit(wrong ? 1 : 0);

// Reads two scrapes of /metrics as Prometheus would, and a little stricter: node metrics.mjs BEFORE AFTER
// Each family has its HELP and TYPE before its samples, once, and in one piece; names, labels and values are well-formed; no
// sample comes twice; counters are called _total and do not fall from one scrape to the next; histograms are cumulative, end in
// +Inf, and have that as their count. Prints what is wrong; exit status 1 when anything is.
import { readFileSync } from 'node:fs';

const wrong = [];
const label = /([a-zA-Z_][a-zA-Z0-9_]*)="((?:[^"\\\n]|\\["\\n])*)"/;
const sample = new RegExp(`^([a-zA-Z_:][a-zA-Z0-9_:]*)(?:\\{((?:${label.source},?)*)\\})? (-?\\d[\\d.]*(?:e[-+]?\\d+)?|[+-]Inf|NaN)$`, 'i');
const types = ['counter', 'gauge', 'histogram', 'summary', 'untyped'];
const number = (text) => (text === '+Inf' ? Infinity : text === '-Inf' ? -Infinity : Number(text));

// The family that a sample's name belongs to.
const family_of = (name, families) => {
  const stem = name.replace(/_(bucket|sum|count)$/, '');
  return families.get(name) ?? (families.get(stem)?.type === 'histogram' ? families.get(stem) : undefined);
};

function read(file) {
  const families = new Map(), samples = new Map();
  let current, help;
  const text = readFileSync(file, 'utf8');
  const say = (line, words) => wrong.push(`${file}: ${words}: ${line}`);
  if (!text.endsWith('\n')) say('', 'the last line has no end');
  for (const line of text.split('\n').slice(0, -1)) {
    const comment = line.match(/^# (HELP|TYPE) ([a-zA-Z_:][a-zA-Z0-9_:]*) (.+)$/);
    if (comment?.[1] === 'HELP') {
      if (families.has(comment[2])) say(line, 'a family begins twice');
      help = comment[2];
    } else if (comment) {
      if (help !== comment[2]) say(line, 'a TYPE that does not follow its HELP');
      if (!types.includes(comment[3])) say(line, 'no such type');
      current = { name: comment[2], type: comment[3] };
      families.set(current.name, current);
    } else {
      const match = line.match(sample);
      if (!match) { say(line, 'no sample'); continue; }
      const family = family_of(match[1], families);
      if (!family || family !== current) say(line, 'a sample outside of its family');
      const labels = [...(match[2] ?? '').matchAll(new RegExp(label, 'g'))].map(([, name, value]) => [name, value]);
      if (new Set(labels.map(([name]) => name)).size !== labels.length) say(line, 'a label comes twice');
      const key = `${match[1]}{${labels.map(([name, value]) => `${name}="${value}"`).sort()}}`;
      if (samples.has(key)) say(line, 'a sample comes twice');
      samples.set(key, { name: match[1], labels, value: number(match.at(-1)), family: family ?? {} });
    }
  }
  for (const { name, type } of families.values()) {
    if ((type === 'counter') !== name.endsWith('_total')) say(name, 'counters, and nothing else, are called _total');
    if (![...samples.values()].some((s) => s.family.name === name)) say(name, 'a family without samples');
  }
  return { families, samples, file };
}

function check_histograms({ samples, file }) {
  const series = new Map();
  for (const { name, labels, value, family } of samples.values()) {
    if (family.type !== 'histogram') continue;
    const key = `${family.name} ${labels.filter(([label]) => label !== 'le')}`;
    if (!series.has(key)) series.set(key, { buckets: [] });
    if (name.endsWith('_bucket')) series.get(key).buckets.push([number(labels.find(([label]) => label === 'le')?.[1]), value]);
    else series.get(key)[name.endsWith('_sum') ? 'sum' : 'count'] = value;
  }
  for (const [key, { buckets, sum, count }] of series) {
    const rising = buckets.every(([bound, value], i) => i === 0 || (bound > buckets[i - 1][0] && value >= buckets[i - 1][1]));
    if (!rising) wrong.push(`${file}: ${key}: the buckets do not rise`);
    if (buckets.at(-1)?.[0] !== Infinity || buckets.at(-1)[1] !== count) wrong.push(`${file}: ${key}: +Inf and the count differ`);
    if (!(sum >= 0) || (count === 0 && sum !== 0)) wrong.push(`${file}: ${key}: the sum is ${sum}`);
  }
}

const [before, after] = process.argv.slice(2).map(read);
for (const scrape of [before, after]) check_histograms(scrape);
for (const [key, { value, family }] of before.samples) {
  const next = after.samples.get(key);
  if (!next && family.type !== 'gauge') wrong.push(`${key} is gone`);
  if (next && family.type !== 'gauge' && next.value < value) wrong.push(`${key} fell from ${value} to ${next.value}`);
}
for (const words of wrong) console.log(words);
const count = (type) => [...after.families.values()].filter((family) => family.type === type).length;
console.log(`${after.samples.size} samples of ${count('gauge')} gauges, ${count('counter')} counters and ${count('histogram')} histograms, ${wrong.length} wrong`);
process.exit(wrong.length ? 1 : 0);

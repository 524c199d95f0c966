// What a stranger may send: raw bytes over sockets, and what must come back.
//   node hostility.mjs URL [--connections N]
// Prints a Markdown table of what was tried and what came back; exit status 1 when something else than allowed did, or when
// the daemon did not answer an honest request in between. --connections: how many are held open at once (300).
import net from 'node:net';

const url = new URL(process.argv[2]);
const at = process.argv.indexOf('--connections');
const CONNECTIONS = at > 0 ? Number(process.argv[at + 1]) : 300;
const PATIENCE_MS = 120000; // against hanging; the daemon gives a request 20 s to begin and 20 s to end
const own = `Host: ${url.host}\r\n`;
const json = 'Content-Type: application/json\r\n';
const get = (target, extra = '') => `GET ${target} HTTP/1.1\r\n${own}${extra}\r\n`;
const honest = get('/healthz');

const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

function connect() {
  return new Promise((done, failed) => {
    const socket = net.connect({ host: url.hostname, port: Number(url.port), allowHalfOpen: true }, () => done(socket));
    socket.once('error', failed);
  });
}

const statusesOf = (text) => [...text.matchAll(/(?:^|\n|\})HTTP\/1\.[01] (\d{3})/g)].map((m) => Number(m[1]));

// Sends pieces, `pause` ms apart, and collects what comes back until the daemon closes, or the patience is at its end. A connection
// that need not be closed is given up when one of the allowed answers has come (anything, if none is given) and was not followed
// by more within `quiet` ms.
async function talk(pieces, { pause = 0, quiet = 700, patience = PATIENCE_MS, allowed, closes = false } = {}) {
  const socket = await connect();
  const chunks = [];
  let closed = false;
  let last = Date.now();
  socket.on('data', (data) => { chunks.push(data); last = Date.now(); });
  socket.on('end', () => { closed = true; });
  socket.on('close', () => { closed = true; });
  socket.on('error', () => { closed = true; });
  const start = Date.now();
  for (const piece of pieces) {
    if (closed || Date.now() - start > patience) break;
    if (!socket.write(typeof piece === 'string' ? Buffer.from(piece, 'latin1') : piece) && !closed)
      await Promise.race([new Promise((done) => socket.once('drain', done)), sleep(5000)]);
    if (pause) await sleep(pause);
  }
  const said = () => Buffer.concat(chunks).toString('latin1');
  const isAnswered = () => !closes && chunks.length && Date.now() - last > quiet && (!allowed || allowed.includes(statusesOf(said()).join(' ')));
  while (!closed && Date.now() - start < patience && !isAnswered()) await sleep(20);
  socket.destroy();
  const text = said();
  return { statuses: statusesOf(text), closed, text, ms: Date.now() - start };
}

const isProblem = (text) => /\r\nContent-Type: application\/problem\+json\r\n/i.test(text);

// Each case: name, the pieces that are sent, the statuses that are allowed to come back as an answer (joined by a blank when
// several requests are answered), whether the connection has to be closed after it.
const cases = [];
const add = (name, pieces, allowed, more = {}) => cases.push({ name, pieces: [pieces].flat(), allowed: [allowed].flat(), ...more });
const post = (fields, body) => `POST /v1/jobs HTTP/1.1\r\n${own}${json}${fields}\r\n${body}`;

add('an honest request', honest, '200');
add('smuggling: Content-Length and chunked', post('Content-Length: 4\r\nTransfer-Encoding: chunked\r\n', `0\r\n\r\n${honest}`), '400', { closes: true });
add('smuggling: Transfer-Encoding before Content-Length', post('Transfer-Encoding: chunked\r\nContent-Length: 4\r\n', `0\r\n\r\n${honest}`), '400', { closes: true });
add('smuggling: two Content-Lengths', post('Content-Length: 0\r\nContent-Length: 44\r\n', honest), '400', { closes: true });
add('smuggling: Content-Length with a list', post('Content-Length: 0, 44\r\n', honest), ['400', '400 400'], { closes: true });
add('smuggling: Content-Length with a sign', post('Content-Length: +4\r\n', 'abcd'), ['400', '400 400'], { closes: true });
add('smuggling: Content-Length in hexadecimal', post('Content-Length: 0x4\r\n', 'abcd'), ['400', '400 400'], { closes: true });
add('smuggling: negative Content-Length', post('Content-Length: -4\r\n', honest), ['400', '400 400'], { closes: true });
add('smuggling: Content-Length beyond 64 bits', post('Content-Length: 99999999999999999999999\r\n', 'abcd'), ['400', '413', '413 413'], { closes: true });
add('smuggling: blank before the colon', post('Content-Length: 4\r\nTransfer-Encoding : chunked\r\n', `0\r\n\r\n${honest}`), '400', { closes: true });
add('smuggling: tab in Transfer-Encoding', post('Transfer-Encoding:\tchunked\r\nContent-Length: 4\r\n', `0\r\n\r\n${honest}`), '400', { closes: true });
add('smuggling: gzip, chunked', post('Transfer-Encoding: gzip, chunked\r\n', `0\r\n\r\n${honest}`), '400', { closes: true });
add('smuggling: chunked twice', post('Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n', `0\r\n\r\n${honest}`), '400', { closes: true });
add('smuggling: folded header field', post('Transfer-Encoding:\r\n chunked\r\nContent-Length: 4\r\n', `0\r\n\r\n${honest}`), '400', { closes: true });
add('chunk size that is no number', post('Transfer-Encoding: chunked\r\n', `zz\r\nabc\r\n0\r\n\r\n`), ['400', ''], { closes: true });
add('chunk size beyond 64 bits', post('Transfer-Encoding: chunked\r\n', `fffffffffffffffffff\r\nabc\r\n0\r\n\r\n`), ['400', '413', ''], { closes: true });
add('negative chunk size', post('Transfer-Encoding: chunked\r\n', `-1\r\nabc\r\n0\r\n\r\n`), ['400', ''], { closes: true });
add('body announced as 2 GiB', post('Content-Length: 2147483648\r\n', ''), '413', { closes: true });
add('chunked body of 20 MB', [post('Transfer-Encoding: chunked\r\n', ''), ...Array(320).fill(`10000\r\n${' '.repeat(65536)}\r\n`), '0\r\n\r\n'], '413', { closes: true });
add('chunked body without end', [post('Transfer-Encoding: chunked\r\n', ''), ...Array(4000).fill(`10000\r\n${' '.repeat(65536)}\r\n`)], ['413', ''], { closes: true });
add('compressed body', post('Content-Encoding: gzip\r\nContent-Length: 2\r\n', '{}'), '415', { closes: true });
add('two Hosts', `GET /healthz HTTP/1.1\r\n${own}Host: evil.example\r\n\r\n`, '400', { closes: true });
add('no Host', 'GET /healthz HTTP/1.1\r\n\r\n', '400', { closes: true });
add('empty Host', 'GET /healthz HTTP/1.1\r\nHost: \r\n\r\n', ['400', '421']);
add('Host of a stranger (DNS rebinding)', 'GET /v1/jobs HTTP/1.1\r\nHost: evil.example\r\n\r\n', '421');
add('Host with a name that begins as ours', 'GET /v1/jobs HTTP/1.1\r\nHost: localhost.evil.example\r\n\r\n', '421');
add('Host with a port and a user', 'GET /v1/jobs HTTP/1.1\r\nHost: localhost@evil.example\r\n\r\n', ['400', '421']);
add('POST from a stranger\'s page', `POST /v1/jobs HTTP/1.1\r\n${own}${json}Origin: http://evil.example\r\nContent-Length: 2\r\n\r\n{}`, '403', { closes: true });
add('POST from a page without an origin', `POST /v1/jobs HTTP/1.1\r\n${own}${json}Origin: null\r\nContent-Length: 2\r\n\r\n{}`, '403', { closes: true });
add('DELETE from another port of this host', `DELETE /v1/jobs/x HTTP/1.1\r\n${own}Origin: http://127.0.0.1:1\r\n\r\n`, '403');
add('cancel by a form of a stranger\'s page', `POST /v1/jobs/x/cancel HTTP/1.1\r\n${own}Sec-Fetch-Site: cross-site\r\nContent-Length: 0\r\n\r\n`, '403');
add('absolute target of a stranger', `GET http://evil.example/healthz HTTP/1.1\r\n${own}\r\n`, '400', { closes: true });
add('asterisk target', `OPTIONS * HTTP/1.1\r\n${own}\r\n`, ['400', '405'], { closes: true });
add('CONNECT', `CONNECT evil.example:443 HTTP/1.1\r\n${own}\r\n`, ['400', '405'], { closes: true });
add('TRACE', `TRACE /healthz HTTP/1.1\r\n${own}\r\n`, '405');
for (const target of ['/%00', '/healthz%00', '/assets/page.js%00.css', '/../etc/passwd', '/assets/../local.mk', '/assets/..%2flocal.mk',
  '/assets/%2e%2e/x', '/v1/schemas/..', '/assets/a%5cb', '//etc/passwd', '/%', '/%zz', '/%0d%0aSet-Cookie:x', '/v1/jobs?state=%00'])
  add(`target ${target}`, get(target), '400', { closes: true });
add('bad UTF-8 in the path, encoded', get('/v1/jobs/%ff%fe'), ['400', '404']);
add('bad UTF-8 in the query, encoded', get('/v1/jobs?label=%ff%fe'), '400');
add('bad UTF-8 in the target, raw', get('/v1/jobs/\xff\xfe'), ['400', '404']);
add('bad UTF-8 in a header field', get('/healthz', 'X-Strange: \xff\xfe\r\n'), '200');
add('bad UTF-8 in a document', post('Content-Length: 17\r\n', '{"name": "\xff\xfe\xfd"}\n '), '400');
add('overlong UTF-8 in a document', post('Content-Length: 15\r\n', '{"name": "\xc0\x80"} '), '400');
add('60 query parameters', get('/v1/jobs?' + 'a=1&'.repeat(60)), '400', { closes: true });
add('600 query parameters', get('/v1/jobs?' + 'a&'.repeat(600)), '400', { closes: true });
add('5000 query parameters', get('/v1/jobs?' + 'a&'.repeat(5000)), ['400', '413', '414', '431'], { closes: true });
add('target of 4 KB', get('/' + 'a'.repeat(4096)), '400', { closes: true });
add('target of 1 MB', get('/' + 'a'.repeat(1 << 20)), ['400', '414', '431'], { closes: true });
add('header field of 16 KB', get('/healthz', `X-Long: ${'a'.repeat(16384)}\r\n`), ['200', '431']);
add('header field of 1 MB', get('/healthz', `X-Long: ${'a'.repeat(1 << 20)}\r\n`), '431', { closes: true });
add('2000 header fields', get('/healthz', 'X-Many: 1\r\n'.repeat(2000)), ['400', '431'], { closes: true });
add('name of a header field of 16 KB', get('/healthz', `${'X'.repeat(16384)}: 1\r\n`), ['200', '431']);
add('header line without a colon', get('/healthz', 'nonsense\r\n'), '400', { closes: true });
// libmicrohttpd cuts a field at a NUL before anybody sees it
add('NUL in a header field', get('/healthz', 'X-Nul: a\0b\r\n'), ['200', '400']);
add('bare carriage return in a header field', get('/healthz', 'X-Cr: a\rTransfer-Encoding: chunked\r\n'), ['200', '400']);
add('lines that end in LF only', `GET /healthz HTTP/1.1\n${own.trim()}\n\n`, ['200', '400']);
add('HTTP/0.9', 'GET /healthz\r\n\r\n', ['400', ''], { closes: true });
add('HTTP/1.0', 'GET /healthz HTTP/1.0\r\n\r\n', ['200', '400'], { closes: true });
add('HTTP/2 preface', 'PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n', ['400', '505', ''], { closes: true });
add('HTTP/9.9', `GET /healthz HTTP/9.9\r\n${own}\r\n`, ['400', '505', ''], { closes: true });
add('TLS hello', '\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03' + '\x41'.repeat(500) + '\r\n\r\n', ['400', ''], { closes: true });
add('random bytes', Buffer.from(Array.from({ length: 4000 }, (_, i) => (i * 7919 + (i >> 3) * 104729) & 255)), ['400', ''], { closes: true, patience: 3000, closeOptional: true });
add('empty lines before the request', `\r\n\r\n${honest}`, ['200', '400', '']);
add('100 requests in one piece (pipelining)', honest.repeat(100), Array(100).fill('200').join(' '));
add('a request, a bad one, another in one piece', honest + get('/%00') + honest, '200 400', { closes: true });
add('Expect: 100-continue and nothing more', post('Content-Length: 4\r\nExpect: 100-continue\r\n', ''), ['100 408', '100'], { closes: true, slow: true });
add('Expect of something unknown', post('Content-Length: 2\r\nExpect: miracles\r\n', '{}'), ['417', '422', '400']);
add('Upgrade: websocket', get('/v1/events', 'Connection: Upgrade\r\nUpgrade: websocket\r\nAccept: image/png\r\n'), '406');
add('slowloris: a byte of the header each second', Array.from(get('/healthz', `X-Slow: ${'a'.repeat(60)}\r\n`).slice(0, -2)), ['408', ''], { closes: true, pause: 1000, slow: true });
add('slow body: a byte each second', [post('Content-Length: 100\r\n', ''), ...Array(60).fill(' ')], ['408', ''], { closes: true, pause: 1000, slow: true });
add('a connection on which nothing is said', '', ['408', ''], { closes: true, slow: true });

async function run(one) {
  const got = await talk(one.pieces, one);
  const answer = got.statuses.join(' ');
  let verdict = one.allowed.includes(answer);
  if (one.closes && !got.closed && !one.closeOptional) verdict = false;
  const health = await talk([honest], { quiet: 50 });
  if (health.statuses[0] !== 200) verdict = false;
  const same = got.statuses.length > 1 && new Set(got.statuses).size === 1;
  const short = same ? `${got.statuses.length} times ${got.statuses[0]}` : answer || 'no answer';
  const bad = Number(got.statuses.at(-1)) >= 400;
  const words = [short, bad ? (isProblem(got.text) ? 'problem document' : 'in libmicrohttpd\'s words') : '', one.closes && got.closed ? 'closed' : '']
    .filter(Boolean).join(', ');
  return { name: one.name, words, verdict, got };
}

// Holds many connections open in a state, and asks honestly on one more.
async function crowd(name, opening) {
  const sockets = [];
  let refused = 0;
  for (let i = 0; i < CONNECTIONS; i++) {
    try {
      const socket = await connect();
      socket.on('error', () => {});
      socket.on('data', () => {});
      socket.write(opening);
      sockets.push(socket);
    } catch {
      refused++;
    }
  }
  await sleep(300);
  const statuses = [];
  for (let i = 0; i < 5; i++) statuses.push((await talk([honest], { quiet: 30 })).statuses[0]);
  sockets.forEach((socket) => socket.destroy());
  await sleep(200);
  const verdict = refused === 0 && statuses.every((status) => status === 200);
  return { name: `${CONNECTIONS} connections from one address, ${name}`, words: verdict ? 'honest requests beside them: 200' : `honest requests: ${statuses}, ${refused} not connected`, verdict };
}

const rows = [];
const only = process.env.ONLY;
const chosen = cases.filter((one) => !only || one.name.includes(only));
const slow = Promise.all(chosen.filter((one) => one.slow).map(run));
for (const one of chosen.filter((one) => !one.slow)) rows.push(await run(one));
rows.push(...(await slow));
if (!only) {
  rows.push(await crowd('nothing said', ''));
  rows.push(await crowd('half a header said', 'GET /healthz HTTP/1.1\r\nHost: '));
  rows.push(await crowd('one answer taken', honest));
  rows.push(await crowd('half a body said', post('Content-Length: 100\r\n', '{')));
}
console.log('| tried | came back |\n|---|---|');
const shown = (text) => text.replaceAll('|', '\\|');
for (const row of rows) console.log(`| ${shown(row.name)} | ${row.verdict ? '' : '**NOT ALLOWED** '}${shown(row.words)} |`);
const wrong = rows.filter((row) => !row.verdict);
for (const row of wrong) console.error(`${row.name}: ${row.words}; closed ${row.got?.closed}; ${row.got?.text?.slice(0, 300)}`);
console.error(`${rows.length - wrong.length} of ${rows.length} as allowed`);
process.exit(wrong.length ? 1 : 0);

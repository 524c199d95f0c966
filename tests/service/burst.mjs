// Clients that ask in step:  node burst.mjs URL PID COUNT...
// For each count, so many connections are opened, the daemon is stopped, each asks, and the daemon goes on: it then finds all
// requests at once. Exit status 1 unless all are answered before the daemon has been found asleep, with all of its threads, in
// looks of 5 s together; it may sleep for 30 s when nothing else happens. How long it computes is the machine's affair.
import { readFileSync, readdirSync } from 'node:fs';
import net from 'node:net';

const url = new URL(process.argv[2]);
const daemon = Number(process.argv[3]);
const LOOK_MS = 50;
const LOOKS = 100;
const request = `GET /healthz HTTP/1.1\r\nHost: ${url.host}\r\n\r\n`;
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

const connect = () =>
  new Promise((done, failed) => {
    const socket = net.connect({ host: url.hostname, port: Number(url.port) }, () => done(socket));
    socket.once('error', failed);
  });

const isAsleep = () =>
  readdirSync(`/proc/${daemon}/task`).every((task) => {
    try {
      return readFileSync(`/proc/${daemon}/task/${task}/stat`, 'utf8').replace(/.*\) /s, '')[0] === 'S';
    } catch {
      return true; // a thread that has ended
    }
  });
const descriptors = () => readdirSync(`/proc/${daemon}/fd`).length;

// Waits until a condition holds, or the daemon has been asleep for too long.
async function until(condition) {
  for (let asleep = 0; !condition() && asleep < LOOKS; asleep += isAsleep() ? 1 : 0) await sleep(LOOK_MS);
}

// Asks on all at once; how many were answered.
async function burst(count) {
  const before = descriptors();
  const sockets = await Promise.all(Array.from({ length: count }, connect));
  await until(() => descriptors() >= before + count); // the daemon has seen them all come
  process.kill(daemon, 'SIGSTOP');
  let answered = 0;
  for (const socket of sockets) socket.once('data', () => answered++);
  await Promise.all(sockets.map((socket) => new Promise((done) => socket.write(request, done))));
  process.kill(daemon, 'SIGCONT');
  await until(() => answered === count);
  for (const socket of sockets) socket.destroy();
  await until(() => descriptors() <= before);
  return answered;
}

for (const count of process.argv.slice(4).map(Number)) {
  const answered = await burst(count);
  console.log(`${answered} of ${count} answered`);
  if (answered !== count) process.exitCode = 1;
}
process.exit();

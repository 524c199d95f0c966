// Clients that ask in step:  node burst.mjs URL PID COUNT...
// For each count, so many connections are opened, the daemon is stopped, each asks, and the daemon goes on: it then finds all
// requests at once. Exit status 1 unless all are answered within 5 s, which is a sixth of the time that it may wait when nothing
// else happens.
import net from 'node:net';

const url = new URL(process.argv[2]);
const daemon = Number(process.argv[3]);
const PATIENCE_MS = 5000;
const request = `GET /healthz HTTP/1.1\r\nHost: ${url.host}\r\n\r\n`;
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

const connect = () =>
  new Promise((done, failed) => {
    const socket = net.connect({ host: url.hostname, port: Number(url.port) }, () => done(socket));
    socket.once('error', failed);
  });

// Asks on all at once; how many were answered.
async function burst(count) {
  const sockets = await Promise.all(Array.from({ length: count }, connect));
  await sleep(300); // the daemon has seen them all come
  process.kill(daemon, 'SIGSTOP');
  const answers = sockets.map((socket) => new Promise((done) => socket.once('data', () => done(true))));
  await Promise.all(sockets.map((socket) => new Promise((done) => socket.write(request, done))));
  process.kill(daemon, 'SIGCONT');
  const late = sleep(PATIENCE_MS).then(() => false);
  const answered = (await Promise.all(answers.map((answer) => Promise.race([answer, late])))).filter(Boolean).length;
  for (const socket of sockets) socket.destroy();
  await sleep(300);
  return answered;
}

for (const count of process.argv.slice(4).map(Number)) {
  const answered = await burst(count);
  console.log(`${answered} of ${count} answered`);
  if (answered !== count) process.exitCode = 1;
}
process.exit();

// Holds long polls: node polls.mjs URL ADDRESS COUNT GRANTED PATH. Opens COUNT connections from ADDRESS, each of which asks for
// PATH and wants to wait for a minute, and more when fewer than GRANTED are left: a slow daemon puts some out before it has read
// them. Prints how many wait and how many were answered once no more than GRANTED wait and nothing more happens, and holds them
// until it is ended.
import { connect } from "node:net";

const [url, localAddress, count, granted, path] = process.argv.slice(2);
const { hostname, port } = new URL(url);
let asked = 0;
let answered = 0;
let refused = 0;
let last = Date.now();
const waiting = () => asked - answered - refused;

function ask() {
  const socket = connect({ host: hostname, port, localAddress });
  let said = "";
  asked++;
  socket.on("data", (data) => {
    if (!said) answered++;
    said += data;
    last = Date.now();
  });
  socket.on("close", () => {
    if (!said) refused++;
    last = Date.now();
    if (waiting() < granted) ask(); // it was put out before the daemon came to read it
  });
  socket.on("error", () => {});
  socket.write(`GET ${path} HTTP/1.1\r\nHost: ${hostname}\r\nPrefer: wait=60\r\n\r\n`);
}
for (let i = 0; i < Number(count); i++) ask();
const timer = setInterval(() => {
  if (waiting() > granted || Date.now() - last < 1500) return;
  console.log(`${waiting()} ${answered}`);
  clearInterval(timer);
}, 100);

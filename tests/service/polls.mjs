// Holds long polls: node polls.mjs URL ADDRESS COUNT GRANTED PATH. Opens COUNT connections from ADDRESS, each of which asks for
// PATH and wants to wait for a minute; prints how many of them wait and how many were answered once no more than GRANTED wait and
// nothing more happens, and holds them until it is ended.
import { connect } from "node:net";

const [url, localAddress, count, granted, path] = process.argv.slice(2);
const { hostname, port } = new URL(url);
let answered = 0;
let refused = 0;
let last = Date.now();
for (let i = 0; i < Number(count); i++) {
  const socket = connect({ host: hostname, port, localAddress });
  let said = "";
  socket.on("data", (data) => {
    if (!said) answered++;
    said += data;
    last = Date.now();
  });
  socket.on("close", () => {
    if (!said) refused++;
    last = Date.now();
  });
  socket.on("error", () => {});
  socket.write(`GET ${path} HTTP/1.1\r\nHost: ${hostname}\r\nPrefer: wait=60\r\n\r\n`);
}
const timer = setInterval(() => {
  const waiting = count - answered - refused;
  if (waiting > granted || Date.now() - last < 1500) return;
  console.log(`${waiting} ${answered}`);
  clearInterval(timer);
}, 100);

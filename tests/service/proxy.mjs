// A reverse proxy as a company's is: passes every request on, with the address that it came from in X-Forwarded-For.
// node proxy.mjs TARGET-PORT PORT-FILE join|line|silent: behind what the client wrote in the same line (nginx), in a line of
// its own (HAProxy), or not at all. Listens on all addresses of the loopback network.
import { renameSync, writeFileSync } from "node:fs";
import { createServer, request } from "node:http";

const [target, portFile, manner] = process.argv.slice(2);

function forwarded(headers, from) {
  const kept = [];
  const said = [];
  for (let i = 0; i < headers.length; i += 2)
    if (manner === "join" && headers[i].toLowerCase() === "x-forwarded-for") said.push(headers[i + 1]);
    else kept.push(headers[i], headers[i + 1]);
  if (manner === "silent") return kept;
  return [...kept, "X-Forwarded-For", [...said, from].join(", ")];
}

const server = createServer((incoming, outgoing) => {
  const headers = forwarded(incoming.rawHeaders, incoming.socket.remoteAddress.replace("::ffff:", ""));
  const onward = request({ host: "127.0.0.1", port: target, method: incoming.method, path: incoming.url, headers }, (answer) => {
    outgoing.writeHead(answer.statusCode, answer.rawHeaders);
    answer.pipe(outgoing);
  });
  outgoing.on("close", () => onward.destroy());
  onward.on("error", () => outgoing.destroy());
  incoming.pipe(onward);
});
server.listen(0, "0.0.0.0", () => {
  writeFileSync(`${portFile}.new`, String(server.address().port));
  renameSync(`${portFile}.new`, portFile);
});

// A receiver of webhooks: checks each signature by itself, with Node's own cryptography, and writes one JSON line for each
// request. node receiver.mjs PORT-FILE LOG-FILE SECRET-FILE DEAF-FILE; the secret file is read anew for each request. It answers
// 500 to the first request of each webhook-id whose event is job.queued, so that something has to be tried again. While the deaf
// file is there, connections are closed as soon as they come: as if there was no receiver, but nobody else can take its port.
import { createHmac, timingSafeEqual } from "node:crypto";
import { appendFileSync, existsSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";

const [portFile, logFile, secretFile, deafFile] = process.argv.slice(2);
const seen = new Set();

function isSigned(headers, body) {
  const key = Buffer.from(readFileSync(secretFile, "utf8").trim().replace(/^whsec_/, ""), "base64");
  const content = `${headers["webhook-id"]}.${headers["webhook-timestamp"]}.${body}`;
  const expected = createHmac("sha256", key).update(content).digest();
  return (headers["webhook-signature"] ?? "").split(" ").some((signature) => {
    const [version, value] = signature.split(",");
    const given = Buffer.from(value ?? "", "base64");
    return version === "v1" && given.length === expected.length && timingSafeEqual(given, expected);
  });
}

const server = createServer((request, response) => {
  const parts = [];
  request.on("data", (part) => parts.push(part));
  request.on("end", () => {
    const body = Buffer.concat(parts).toString();
    const id = request.headers["webhook-id"];
    const age = Date.now() / 1000 - Number(request.headers["webhook-timestamp"]);
    const message = JSON.parse(body);
    const status = message.type === "job.queued" && !seen.has(id) ? 500 : 200;
    seen.add(id);
    const line = { id, status, path: request.url, signed: isSigned(request.headers, body), fresh: age > -300 && age < 300, message };
    appendFileSync(logFile, `${JSON.stringify(line)}\n`);
    response.writeHead(status).end();
  });
});
server.on("connection", (socket) => existsSync(deafFile) && socket.destroy());
server.listen(0, "127.0.0.1", () => writeFileSync(portFile, `${server.address().port}\n`));

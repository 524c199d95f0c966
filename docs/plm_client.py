#!/usr/bin/env python3
"""A PLM system's side of quietgear, to begin one's own with. It needs Python 3.9 and nothing beyond its standard library.

    plm_client.py run DIR DOCUMENT.json...   submit, follow, fetch: DIR/NAME.result.json for each NAME.json
    plm_client.py list LABEL [PAGE]          the jobs with a label, newest first, read PAGE (100) at a time
    plm_client.py receive PORT               take webhooks on 127.0.0.1:PORT, print the genuine ones

Server, token and authority are those of `quietgear`: QUIETGEAR_SERVER, QUIETGEAR_TOKEN_FILE, QUIETGEAR_CA_FILE. `receive`
takes the webhook's secret from the file that QUIETGEAR_SECRET_FILE names. Exit status 0: done, 1: a job failed or the daemon
refuses, 2: wrong arguments.

What an integration has to get right, and where it is done here:
- A submission whose answer got lost is sent again with the same Idempotency-Key, and makes no second job: submit().
- 429 and 503 are waited out for as long as Retry-After says, and so is a daemon that restarts: call().
- Events go on after the last one seen (Last-Event-ID), over restarts of either side, and no end of a job falls between
  asking for it and listening: follow().
- A result that was fetched before is not fetched again (ETag, 304): fetch().
- Lists come in pages whose next one is in the Link field: jobs().
- A webhook is believed for its signature and its age, and each message is taken once: genuine(), Receiver.
"""
import base64
import gzip
import hashlib
import hmac
import http.client
import http.server
import json
import os
import pathlib
import re
import ssl
import sys
import time
import urllib.error
import urllib.parse
import urllib.request

OVER = ("succeeded", "failed", "cancelled")
PATIENCE_S = 120  # how long a daemon may be away or busy
SILENCE_S = 30  # how long an answer may not go on; event streams have a comment every ten seconds
MESSAGE_AGE_S = 300  # how old a webhook's message may be
LOST = (OSError, http.client.HTTPException)  # no answer, or half of one


def content_of(variable):
    """The content of the file that an environment variable names, without the line's end; None without the variable."""
    return pathlib.Path(os.environ[variable]).read_text().strip() if os.environ.get(variable) else None


def say(*words):
    print(*words, file=sys.stderr, flush=True)


class Client:
    """One daemon, and one token."""

    def __init__(self):
        self.server = os.environ.get("QUIETGEAR_SERVER") or "http://127.0.0.1:8080"
        self.token = content_of("QUIETGEAR_TOKEN_FILE")
        self.tls = None
        if self.server.startswith("https:"):
            self.tls = ssl.create_default_context(cafile=os.environ.get("QUIETGEAR_CA_FILE") or None)

    def open(self, method, path, headers, body=None):
        """One request. Raises SystemExit when the daemon refuses for good, HTTPError when it does for now, or one of LOST."""
        request = urllib.request.Request(self.server.rstrip("/") + path, method=method, data=body, headers=headers)
        if self.token:
            request.add_header("Authorization", "Bearer " + self.token)
        try:
            return urllib.request.urlopen(request, timeout=SILENCE_S, context=self.tls)
        except urllib.error.HTTPError as refusal:
            if refusal.code in (304, 429, 503):
                raise
            raise SystemExit(f"{method} {path}: {refusal.code} {refusal.read().decode()}") from None

    def call(self, method, path, headers=None, body=None):
        """Status, fields and content of an answer. What is asked here may be asked again: POST only with its key."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            try:
                with self.open(method, path, {"Accept-Encoding": "gzip", **(headers or {})}, body) as answer:
                    content = answer.read()
                    packed = answer.headers["Content-Encoding"] == "gzip"
                    return answer.status, answer.headers, gzip.decompress(content) if packed else content
            except LOST as fault:
                if getattr(fault, "code", 0) == 304:
                    return 304, fault.headers, b""
                if time.monotonic() > deadline:
                    raise SystemExit(f"{method} {path}: {fault}") from None
                self.wait(fault)

    @staticmethod
    def wait(fault):
        """Waits for as long as a refusal asks for, or a second."""
        seconds = int(fault.headers.get("Retry-After") or 1) if isinstance(fault, urllib.error.HTTPError) else 1
        say(f"{fault}: again in {seconds} s")
        time.sleep(seconds)

    def submit(self, document, external_id):
        """The job of a document: the same one for the same document and external_id, for seven days."""
        body = json.dumps({**document, "external_id": external_id}, sort_keys=True).encode()
        key = hashlib.sha256(body).hexdigest()
        fields = {"Content-Type": "application/json", "Idempotency-Key": key}
        _, answer, content = self.call("POST", "/v1/jobs", fields, body)
        job = json.loads(content)
        say(job["id"], external_id, "known" if answer["Idempotency-Replayed"] else "new")
        return job

    def job(self, id):
        return json.loads(self.call("GET", "/v1/jobs/" + id)[2])

    def events(self, last):
        """The events of one connection as (id, name, data), after the event `last` (None: from now on). The first has
        neither name nor data. It ends, or raises one of LOST, at any time."""
        headers = {"Accept": "text/event-stream", **({"Last-Event-ID": last} if last else {})}
        with self.open("GET", "/v1/events", headers) as stream:
            fields = {}
            for line in stream:
                name, _, value = line.decode().rstrip("\n").partition(":")
                if name:
                    fields[name] = value.removeprefix(" ")
                elif fields and not value:
                    yield fields.get("id"), fields.get("event"), json.loads(fields.get("data", "null"))
                    fields = {}

    def changes(self, waiting, remembered):
        """The jobs of `waiting` (ids), as they were and whenever they change, over as many connections as that takes.
        `remembered` is the file that keeps the last event's id."""
        while waiting:
            last = remembered.read_text().strip() if remembered.exists() else None
            try:
                for id, name, data in self.events(last):
                    if name == "job" and data["id"] in waiting:
                        yield data
                    elif name in (None, "reset"):  # from here on we listen, so whatever is over already shows now
                        yield from [self.job(job) for job in sorted(waiting)]
                    remembered.write_text(id or "")
                    if not waiting:
                        return
            except LOST as fault:
                self.wait(fault)

    def follow(self, waiting, remembered):
        """Yields each job as it ends, and takes it from `waiting`."""
        for job in self.changes(waiting, remembered):
            if job["state"] in OVER and job["id"] in waiting:
                waiting.discard(job["id"])
                yield job

    def fetch(self, job, file):
        """Puts a job's result into a file, unless it is there already; returns the status of the answer."""
        tag = file.with_suffix(".etag")
        fields = {"If-None-Match": tag.read_text()} if tag.exists() and file.exists() else {}
        status, answer, content = self.call("GET", job["links"]["result"], fields)
        if status == 200:
            file.write_bytes(content)
            tag.write_text(answer["ETag"])
        return status

    def jobs(self, label, page):
        """All jobs with a label, newest first."""
        path = "/v1/jobs?" + urllib.parse.urlencode({"label": label, "limit": page})
        while path:
            _, answer, content = self.call("GET", path)
            yield from json.loads(content)["jobs"]
            following = re.search(r'<([^>]*)>; rel="next"', answer["Link"] or "")
            path = following and following[1]


def genuine(secret, fields, body, now):
    """Whether a message is signed with the secret (whsec_...) and no more than five minutes old."""
    key = base64.b64decode(secret.removeprefix("whsec_"))
    id, sent, signatures = (fields.get("webhook-" + name, "") for name in ("id", "timestamp", "signature"))
    if not re.fullmatch("[0-9]{1,12}", sent) or abs(now - int(sent)) > MESSAGE_AGE_S:
        return False
    digest = hmac.digest(key, f"{id}.{sent}.".encode() + body, "sha256")
    ours = b"v1," + base64.b64encode(digest)
    return any(hmac.compare_digest(ours, theirs.encode()) for theirs in signatures.split())


class Receiver(http.server.BaseHTTPRequestHandler):
    """Answers webhooks at once; the work is that of whoever reads our standard output."""

    secret = None
    seen = set()  # a lasting system keeps them where it keeps its data

    def do_POST(self):
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        believed = genuine(self.secret, self.headers, body, time.time())
        self.send_response(204 if believed else 400)
        self.end_headers()
        if believed and self.headers["webhook-id"] not in self.seen:
            self.seen.add(self.headers["webhook-id"])
            message = json.loads(body)
            print(message["type"], message["data"]["external_id"], message["data"]["id"], flush=True)

    def log_message(self, *_):
        """Says nothing of requests: what counts is printed."""


def run(directory, files):
    client, directory = Client(), pathlib.Path(directory)
    names = {}
    for file in map(pathlib.Path, files):
        names[client.submit(json.loads(file.read_text()), file.stem)["id"]] = file.stem
    failed = False
    for job in client.follow(set(names), directory / "last-event-id"):
        name, good = names[job["id"]], job["state"] == "succeeded"
        print(name, job["state"], client.fetch(job, directory / f"{name}.result.json") if good else job["error"], flush=True)
        failed = failed or not good
    return int(failed)


def main(command=None, *arguments):
    if command == "run" and len(arguments) > 1:
        return run(arguments[0], arguments[1:])
    if command == "list" and len(arguments) in (1, 2):
        for job in Client().jobs(arguments[0], arguments[1] if len(arguments) > 1 else "100"):
            print(job["id"], job["state"], job["external_id"])
        return 0
    if command == "receive" and len(arguments) == 1 and os.environ.get("QUIETGEAR_SECRET_FILE"):
        Receiver.secret = content_of("QUIETGEAR_SECRET_FILE")
        http.server.ThreadingHTTPServer(("127.0.0.1", int(arguments[0])), Receiver).serve_forever()
    say(__doc__)
    return 2


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

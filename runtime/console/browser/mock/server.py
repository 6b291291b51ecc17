#!/usr/bin/env python3
"""A mock of the console's program. See `server.py --help`."""
import argparse
import json
import mimetypes
import os
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, urlparse

sys.path.insert(0, os.path.dirname(__file__))
import invent  # noqa: E402
from run import Run  # noqa: E402
from socket_frames import accept_key, text_frame  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
ASSETS = os.path.join(HERE, "..", "..", "assets")
CSP = ("default-src 'self'; img-src 'self' data:; connect-src 'self'; "
       "style-src 'self' 'unsafe-inline'")
FREQUENT = {"navigation": 1.0, "beat": 1.0, "measure": 2.0, "sensor": 5.0, "truth": 5.0,
            "counts": 5.0, "headroom": 30.0, "steering": 2.0}


def load(path):
    """The log's items, kept beside it because converting takes some seconds."""
    sources = [path, os.path.join(HERE, "convert.py")]
    mark = "-".join(str(int(os.stat(p).st_mtime)) for p in sources)
    cache = f"{path}.{mark}.items.json"
    if os.path.exists(cache):
        with open(cache) as file:
            return json.load(file)
    from convert import convert
    made = convert(path)
    with open(cache, "w") as file:
        json.dump(made, file)
    return made


def thin(items):
    """What /api/history gives: frequent kinds only every so often."""
    last = {}
    for item in items:
        step = FREQUENT.get(item["kind"])
        if step and not (item["kind"] == "steering" and "owner" not in item):
            key = (item["kind"], item.get("name"), item.get("plugin"))
            if item["t"] - last.get(key, -99) < step - 0.05:
                continue
            last[key] = item["t"]
        yield item


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    run = None
    args = None

    def log_message(self, *_):
        pass

    def answer(self, code, body=b"", kind="application/json"):
        if not isinstance(body, bytes):
            body = json.dumps(body, separators=(",", ":")).encode()
        self.send_response(code)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Content-Security-Policy", CSP.replace(" 'unsafe-inline'", "") if self.args.strict else CSP)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def do_GET(self):
        url = urlparse(self.path)
        if url.path == "/":
            self.file("index.html")
        elif url.path.startswith("/assets/"):
            self.file(url.path[len("/assets/"):])
        elif url.path == "/api/about":
            self.answer(200, self.run.about_now())
        elif url.path == "/api/history":
            self.history()
        elif url.path == "/api/feed" and self.run.about["kind"] != "recorded":
            self.feed(int(parse_qs(url.query).get("after", ["0"])[0]))
        else:
            self.answer(404, {"error": "no such thing"})

    def file(self, name):
        path = os.path.realpath(os.path.join(ASSETS, name))
        if not path.startswith(os.path.realpath(ASSETS) + os.sep) or not os.path.isfile(path):
            return self.answer(404, {"error": "no such file"})
        kind = mimetypes.guess_type(path)[0] or "application/octet-stream"
        with open(path, "rb") as file:
            self.answer(200, file.read(), kind)

    def history(self):
        """Sent in pieces as they are made, without a length."""
        self.send_response(200)
        self.send_header("Content-Type", "application/x-ndjson")
        self.send_header("Transfer-Encoding", "chunked")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        rows = ['{"n": 12, "t": oops', "[]", '{"n":"x","t":"y","kind":7}'] if self.args.malformed else []
        for item in thin(self.run.snapshot()):
            rows.append(json.dumps(item, separators=(",", ":")))
            if len(rows) >= 1000:
                self.piece(rows)
                rows = []
        self.piece(rows)
        self.wfile.write(b"0\r\n\r\n")

    def piece(self, rows):
        data = ("\n".join(rows) + "\n").encode()
        self.wfile.write(b"%x\r\n" % len(data) + data + b"\r\n")

    def feed(self, after):
        self.send_response_only(101)
        for key, value in (("Upgrade", "websocket"), ("Connection", "Upgrade"),
                           ("Sec-WebSocket-Accept", accept_key(self.headers["Sec-WebSocket-Key"]))):
            self.send_header(key, value)
        self.end_headers()
        self.close_connection = True
        resets, quiet_since = self.run.resets, time.monotonic()
        try:
            if after > self.run.newest():
                return self.send([{"kind": "reset"}])
            while True:
                time.sleep(0.1)
                if self.run.stalled:
                    continue
                if self.run.resets != resets:
                    return self.send([{"kind": "reset"}])
                items = self.run.since(after)
                if items:
                    after = items[-1]["n"]
                if items or time.monotonic() - quiet_since >= 1.0:
                    quiet_since = time.monotonic()
                    self.send(items)
        except OSError:
            pass

    def send(self, items):
        self.wfile.write(text_frame(json.dumps(items, separators=(",", ":"))))
        self.wfile.flush()

    def do_POST(self):
        length = int(self.headers.get("Content-Length") or 0)
        try:
            body = json.loads(self.rfile.read(length) or b"{}")
        except ValueError:
            return self.answer(400, {"error": "not JSON"})
        if self.path == "/api/operator":
            return self.operator(body)
        if self.path == "/api/pace" and "pace" in self.run.about:
            self.run.set_pace(float(body["times"]))
            return self.answer(202, {})
        if self.path == "/mock/stall":
            self.run.stalled = bool(body.get("on"))
        elif self.path == "/mock/reset":
            self.run.resets += 1
        elif self.path == "/mock/item":
            self.run.say(body)
        else:
            return self.answer(404, {"error": "no such thing"})
        self.answer(200, {})

    def operator(self, body):
        if not self.run.about["operator"]:
            return self.answer(409, {"error": "there is no operator's token in this run"})
        if self.run.tries >= 5:
            return self.answer(429, {"error": "too many tries"})
        if self.headers.get("Authorization") != "Bearer secret":
            self.run.tries += 1
            time.sleep(0.5)
            return self.answer(401, {"error": "wrong token"})
        self.run.tries = 0
        error = self.run.operate(body.get("act"), str(body.get("who", "")))
        self.answer(409 if error else 202, {"error": error} if error else {})


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--mode", choices=["recorded", "live"], default="recorded")
    p.add_argument("--kind", choices=["live", "simulated"], default="live", help="what `live` says it is")
    p.add_argument("--at", type=float, default=100.0, help="live: starts at this time of the log")
    p.add_argument("--times", type=float, default=1.0, help="live: speed")
    p.add_argument("--invent", action="store_true", help="with invented items")
    p.add_argument("--malformed", action="store_true", help="with malformed lines in the history")
    p.add_argument("--hours", type=float, default=0, help="repeat the dive up to so many hours")
    p.add_argument("--strict", action="store_true", help="a stricter CSP: no inline styles")
    p.add_argument("--no-operator", action="store_true")
    p.add_argument("--port", type=int, default=8123)
    p.add_argument("--log", default=os.environ.get("CONSOLE_LOG", "isobath.mcap"), help="of `sim missions/isobath --log`")
    args = p.parse_args()
    about, items = load(args.log)
    if args.invent:
        about, items = invent.embellish(about, items, args.kind == "simulated")
    if args.hours:
        items = invent.lengthen(items, args.hours)
    Handler.args = args
    Handler.run = Run(about, items, args)
    threading.Thread(target=Handler.run.forever, daemon=True).start()
    server = ThreadingHTTPServer(("127.0.0.1", args.port), Handler)
    server.daemon_threads = True
    print(f"http://127.0.0.1:{args.port}/", flush=True)
    server.serve_forever()


if __name__ == "__main__":
    main()

"""A run that plays a list of items, with hold, release and pace."""
import threading
import time


class Run:
    """Items become visible as the time of the run passes; each gets its `n` then."""

    def __init__(self, about, items, args):
        self.lock = threading.Lock()
        self.live = args.mode == "live"
        self.waiting = items
        self.next = 0
        self.seen = []
        self.held = False
        self.stalled = False
        self.resets = 0
        self.tries = 0
        self.about = dict(about)
        self.base_t, self.base_wall, self.times = args.at, time.monotonic(), args.times
        if self.live:
            self.about["kind"] = args.kind
            self.about["operator"] = not args.no_operator
            if args.kind == "simulated":
                self.about["pace"] = {"times": args.times}
            else:
                self.base_t = args.at
        self.advance(args.at if self.live else float("inf"))

    def now(self):
        return self.base_t + (time.monotonic() - self.base_wall) * self.times

    def add(self, item):
        self.seen.append({"n": len(self.seen) + 1, **item})

    def advance(self, t):
        while self.next < len(self.waiting) and self.waiting[self.next]["t"] <= t:
            item = self.waiting[self.next]
            self.next += 1
            if self.held and item["kind"] in ("steering", "status", "control"):
                continue
            if self.held and item["kind"] == "beat":
                item = {k: v for k, v in item.items() if k != "refreshed"}
            self.add(item)

    def forever(self):
        while self.live:
            time.sleep(0.05)
            with self.lock:
                self.advance(self.now())

    def snapshot(self):
        with self.lock:
            return list(self.seen)

    def since(self, n):
        with self.lock:
            return self.seen[n:n + 20000]

    def newest(self):
        return len(self.seen)

    def about_now(self):
        about = dict(self.about)
        if self.live:
            about["now"] = round(self.now(), 3)
        return about

    def say(self, item):
        with self.lock:
            self.add({"t": round(self.now(), 3), **item})

    def set_pace(self, times):
        with self.lock:
            self.base_t, self.base_wall, self.times = self.now(), time.monotonic(), min(times, 10000)
            self.about["pace"] = {"times": times}
            self.add({"t": round(self.base_t, 3), "kind": "pace", "times": times})

    def operate(self, act, who):
        """Holds or releases; returns why not."""
        if act not in ("hold", "release"):
            return "no such act"
        if self.held == (act == "hold"):
            return "it is held already" if self.held else "nobody holds it"
        self.held = act == "hold"
        self.say({"kind": "operator", "act": act, "who": who, "by": "console"})
        if self.held:
            self.say({"kind": "steering", "reason": "the operator's hold is set"})
            self.say({"kind": "control", "granted": False, "reason": "the operator's hold is set"})
            self.say({"kind": "status", "text": "the operator's hold is set"})
        else:
            self.say({"kind": "control", "granted": True})
            self.say({"kind": "status", "text": "steering"})
        return None

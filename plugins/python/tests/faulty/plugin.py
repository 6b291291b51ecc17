"""A plugin for tests: it does what its configuration says, at one of its steps, and otherwise what the template
does."""

import datetime
import random
import threading
import time
from dataclasses import dataclass, field
from enum import Enum

from backseat_sdk import (
    SECOND_NS,
    Depth,
    Description,
    Grant,
    Modify,
    Plugin,
    Refused,
    Restored,
    Topic,
    fence,
    log,
    measures,
)
from backseat_sdk.survey import Timers

#: Read while the component is built, as an author may do.
OWN_SOURCE = open(__file__, encoding="utf-8").read()


class What(Enum):
    NOTHING = "nothing"
    RAISE = "raise"
    RAISE_ALWAYS = "raise-always"
    WRONG_TAG = "wrong-tag"
    NO_REQUEST = "no-request"
    RECURSE = "recurse"
    MEMORY = "memory"
    LOOP = "loop"
    EXIT = "exit"
    CLOCK = "clock"
    SLEEP = "sleep"
    CHANCE = "chance"
    LATE_IMPORT = "late-import"
    NUMPY = "numpy"
    FILE = "file"
    THREAD = "thread"
    PRINT = "print"
    TRAP = "trap"
    REFUSE = "refuse"
    FAIL_IN_INIT = "fail-in-init"
    FAIL_IN_SNAPSHOT = "fail-in-snapshot"
    FAIL_IN_RESTORE = "fail-in-restore"
    BIG_STATE = "big-state"
    ASK_FENCE = "ask-fence"
    TELL_BRIEFING = "tell-briefing"
    FAIL_IN_BRIEF = "fail-in-brief"


@dataclass(frozen=True)
class Config:
    what: What = What.NOTHING
    at_step: int = 40


@dataclass
class State:
    tag: int = 0
    restarts: int = 0
    lost: int = 0
    timers: Timers = field(default_factory=Timers)
    numbers: list[float] = field(default_factory=list)


class Faulty(Plugin):
    Config = Config
    State = State

    def describe(self):
        return Description("faulty", "0.1.0", SECOND_NS, (Topic.CTD, Topic.PLAN, Topic.BEHAVIOR), (Grant.MODIFY,))

    def init(self, config):
        self.config = config
        self.steps = 0
        if config.what is What.REFUSE:
            raise Refused("what: this setting is refused")
        if config.what is What.FAIL_IN_INIT:
            return {}["missing"]

    def brief(self, briefing):
        if self.config.what is What.FAIL_IN_BRIEF:
            raise Refused(f"speed_max_mps: {briefing.limits.speed_max} is too slow")
        self.briefing = briefing

    def step(self, input):
        self.steps += 1
        for restored in input.of(Restored):
            self.state.restarts += 1
            self.state.lost += restored.lost_steps
            measures.publish("restarts", self.state.restarts)
            measures.publish("lost_steps", self.state.lost)
            measures.publish("tag_after_restart", self.state.tag)
        if self.config.what is What.RAISE_ALWAYS or (self.steps == self.config.at_step and self.state.restarts == 0):
            self.fault()
        requests = []
        for name in self.state.timers.expired(input):
            measures.publish("timers", len(name))
        if self.steps == 2:
            requests.append(self.state.timers.start("five", 5.0, input))
        if input.control:
            self.state.tag += 1
            requests.append(Modify(self.state.tag, 80.0, Depth(10.0), 1.5, 3 * SECOND_NS))
        if self.wrong:
            requests.append(self.wrong.pop())
        return requests

    wrong = []

    def fault(self):
        match self.config.what:
            case What.RAISE | What.RAISE_ALWAYS:
                self.divide(1.0, 0.0)
            case What.WRONG_TAG:
                self.wrong.append(Modify(-1, 80.0, Depth(10.0), 1.5, SECOND_NS))
            case What.NO_REQUEST:
                self.wrong.append("north")
            case What.RECURSE:
                self.fault()
            case What.MEMORY:
                bytearray(200_000_000)
            case What.LOOP | What.FAIL_IN_RESTORE:
                while True:
                    pass
            case What.EXIT:
                raise SystemExit(3)
            case What.CLOCK:
                time.monotonic()
            case What.SLEEP:
                time.sleep(1.0)
            case What.CHANCE:
                random.random()
            case What.LATE_IMPORT:
                import fractions

                fractions.Fraction(1)
            case What.NUMPY:
                import numpy

                numpy.zeros(1)
            case What.FILE:
                open("/etc/hostname", encoding="utf-8")
            case What.THREAD:
                threading.Thread(target=print).start()
            case What.PRINT:
                print("a line of", "print")
            case What.TRAP:
                datetime.datetime.now()
            case What.BIG_STATE:
                self.state.numbers = [number / 7 for number in range(5_000)]
            case What.ASK_FENCE:
                log.info(f"shallow: {fence.check(Modify(1, 80.0, Depth(10.0), 1.5, SECOND_NS)):.0f} m")
                refusal = fence.check(Modify(1, 80.0, Depth(39.0), 1.5, SECOND_NS))
                log.info(f"deep: {refusal.rule.name}, {refusal.most} m, {refusal.text}")
            case What.TELL_BRIEFING:
                (zone,) = self.briefing.zones
                ring = zone.areas[0].outer
                log.info(f"{zone.name}: {zone.keep_in.altitude_min} m, {zone.depth_max} m, {len(zone.areas)} area")
                log.info(f"west to east: {ring[0].distance(ring[1]):.0f} m, holes: {len(zone.areas[0].holes)}")
                log.info(f"grants: {', '.join(grant.value for grant in self.briefing.grants)}")
                log.info(
                    f"fuel: {self.briefing.budget.fuel_per_step}, inserts: {self.briefing.limits.inserts_open_max}"
                )
            case _:
                pass

    def divide(self, one, other):
        return one / other

    def snapshot(self):
        if self.config.what is What.FAIL_IN_SNAPSHOT and self.steps >= self.config.at_step:
            raise OSError("no snapshot today")
        return super().snapshot()

    def restore(self, state):
        if self.config.what is What.FAIL_IN_RESTORE:
            raise ValueError("state: not today")
        super().restore(state)

"""Tracks the thermocline: finds the depth at which the temperature changes most, then crosses it again and again.

The vehicle flies a straight line and goes up and down (a *yo-yo*). At first it sweeps the whole range of depths. At the
end of each leg it takes the depth of the strongest vertical gradient from the leg's binned temperatures. Once it has
one, it turns around a few metres above and below that depth, so that it spends its time in the layer, and corrects the
depth with each crossing. If the gradient is lost, it sweeps the whole range again.

Source: Zhang, Bellingham, Godin, Ryan, "Using an autonomous underwater vehicle to track the thermocline based on
peak-gradient detection", IEEE Journal of Oceanic Engineering 37(3), 2012, 544-553. From the paper is the idea
that the depth of the peak gradient of each leg steers the next ones; bins, weights and turning distances are this
plugin's own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Literal

from backseat_sdk import (
    SECOND_NS,
    Ctd,
    Depth,
    Description,
    Failed,
    Grant,
    Modify,
    Outcome,
    Plugin,
    Refusal,
    Refused,
    Rejected,
    Rule,
    TimedOut,
    Topic,
    Within,
    fence,
    log,
    measures,
)
from backseat_sdk.survey import Line, Local
from gradient_peak import Peak, Profile

PERIOD_NS = 1 * SECOND_NS
#: A request outlasts two late steps.
STANDS_NS = 4 * PERIOD_NS
#: How far behind the turning depth the setpoint is, so that the vehicle does not slow down before it turns.
BEHIND_M = 3.0
#: How near to a setpoint that could not be put behind the turning depth the vehicle turns.
NEAR_M = 1.0
#: The share of a new peak in the estimate of the depth.
SHARE = 0.4
#: How many peaks the spread is computed from.
PEAKS = 10
#: How many legs in a row may have no gradient before the search begins again.
LOST_LEGS = 2


@dataclass(frozen=True)
class Config:
    heading_deg: Annotated[float, Within(0.0, 360.0)]
    speed_mps: Annotated[float, Within(0.5, 5.0)]
    #: The range of depths to search. The fence may make it smaller.
    shallowest_m: Annotated[float, Within(0.5, 1000.0)]
    deepest_m: Annotated[float, Within(1.0, 1000.0)]
    #: How far above and below the thermocline to turn.
    half_span_m: Annotated[float, Within(2.0, 100.0)] = 5.0
    bin_m: Annotated[float, Within(0.2, 20.0)] = 1.0
    #: A weaker gradient is no thermocline.
    gradient_min_c_per_m: Annotated[float, Within(0.001, 10.0)] = 0.08
    #: "yoyo" sweeps the whole range all the time, for comparison.
    mode: Literal["track", "yoyo"] = "track"


class Phase(Enum):
    SEARCH = "search"
    TRACK = "track"


@dataclass
class State:
    tag: int = 0
    phase: Phase = Phase.SEARCH
    #: Whether the present leg goes down.
    down: bool = True
    #: Where the line began; none before the first step with control.
    start: Local | None = None
    profile: Profile = field(default_factory=Profile)
    #: The estimated depth of the thermocline, metres; none before the first peak.
    depth: float | None = None
    #: The depths of the last peaks.
    peaks: list[float] = field(default_factory=list)
    legs: int = 0
    crossings: int = 0
    lost: int = 0
    #: On which side of the estimated depth the vehicle was: below it, above it, or not known.
    below: bool | None = None


class Thermocline(Plugin):
    Config = Config
    State = State
    state: State

    def describe(self):
        return Description("thermocline", "0.1.0", PERIOD_NS, (Topic.CTD,), (Grant.MODIFY,))

    def init(self, config: Config):
        if config.shallowest_m + 2.0 * config.half_span_m > config.deepest_m:
            raise Refused(
                f"deepest_m: {config.deepest_m} leaves less than twice half_span_m ({config.half_span_m}) below "
                f"shallowest_m ({config.shallowest_m})"
            )
        self.config = config
        self.state.profile = Profile(config.bin_m)

    def brief(self, briefing):
        limits = briefing.limits
        if not limits.speed_min <= self.config.speed_mps <= limits.speed_max:
            raise Refused(
                f"speed_mps: {self.config.speed_mps} is not within limits.speed_min_mps and limits.speed_max_mps, "
                f"{limits.speed_min} to {limits.speed_max}"
            )

    def step(self, input):
        for outcome in input.of(Outcome):
            if isinstance(outcome.state, (Rejected, Failed, TimedOut)):
                log.warn(f"request {outcome.tag}: {outcome.reason or 'not answered'}")
        navigation = input.navigation
        if navigation is None:
            return []
        for ctd in input.of(Ctd):
            # The navigation is newer than the sample by the difference of their ages.
            older_s = (ctd.age_ns - navigation.age_ns) / SECOND_NS
            self._sample(navigation.depth - navigation.velocity_down * older_s, ctd.temperature)
        if not input.control:
            return []
        if self.state.start is None:
            self.state.start = navigation.local
            self.state.down = navigation.depth < 0.5 * (self.config.shallowest_m + self.config.deepest_m)
        return [self._steer(navigation)]

    def _sample(self, depth, temperature):
        state = self.state
        state.profile.add(depth, temperature)
        if state.depth is not None:
            # A band of half a metre, so that a vehicle at the layer does not count its noise.
            below = True if depth > state.depth + 0.25 else False if depth < state.depth - 0.25 else state.below
            if state.below is not None and below is not state.below:
                state.crossings += 1
                measures.publish("crossings", state.crossings)
            state.below = below

    def _steer(self, navigation):
        turn, setpoint = self._leg(navigation)
        beyond = navigation.depth >= turn if self.state.down else navigation.depth <= turn
        near = abs(navigation.depth - setpoint.vertical.depth) < NEAR_M
        if beyond or near:
            self._end_leg()
            _, setpoint = self._leg(navigation)
        self.state.tag = setpoint.tag
        return setpoint

    def _leg(self, navigation):
        """The depth at which the present leg ends, and the request that leads there."""
        config, state = self.config, self.state
        top, bottom = config.shallowest_m, config.deepest_m
        if state.phase is Phase.TRACK and state.depth is not None:
            top = max(top, state.depth - config.half_span_m)
            bottom = min(bottom, state.depth + config.half_span_m)
        turn = bottom if state.down else top
        behind = turn + BEHIND_M if state.down else turn - BEHIND_M
        depth = max(config.shallowest_m, min(config.deepest_m, behind))
        line = Line(state.start, state.start.offset(config.heading_deg, 1000.0))
        request = Modify(
            tag=state.tag + 1,
            heading=line.heading_to_follow(navigation.local),
            vertical=Depth(depth),
            speed=config.speed_mps,
            duration_ns=STANDS_NS,
        )
        return turn, self._inside(request)

    def _inside(self, request):
        """The request, with a depth that the fence allows: as far as its refusal says that it is away."""
        for _ in range(3):
            answer = fence.check(request)
            if not isinstance(answer, Refusal) or answer.missing_m is None:
                break
            if answer.rule not in (Rule.DEPTH, Rule.ALTITUDE):
                break
            back = answer.missing_m + 0.1
            depth = request.vertical.depth - back if self.state.down else request.vertical.depth + back
            request = Modify(request.tag, request.heading, Depth(max(0.5, depth)), request.speed, request.duration_ns)
        return request

    def _end_leg(self):
        config, state = self.config, self.state
        peak = state.profile.peak()
        state.profile = Profile(config.bin_m)
        state.down = not state.down
        state.legs += 1
        if peak is None or peak.gradient < config.gradient_min_c_per_m:
            state.lost += 1
            if state.phase is Phase.TRACK and state.lost >= LOST_LEGS:
                log.info(f"leg {state.legs}: no gradient, searching again")
                state.phase, state.depth, state.peaks, state.below = Phase.SEARCH, None, [], None
            return
        state.lost = 0
        self._found(peak)

    def _found(self, peak: Peak):
        config, state = self.config, self.state
        if state.depth is None:
            log.info(f"leg {state.legs}: thermocline at {peak.depth:.1f} m, {peak.gradient:.2f} degC/m")
            state.depth = peak.depth
        else:
            state.depth += SHARE * (peak.depth - state.depth)
        state.peaks = [*state.peaks, peak.depth][-PEAKS:]
        if config.mode == "track":
            state.phase = Phase.TRACK
        mean = sum(state.peaks) / len(state.peaks)
        measures.publish("depth", state.depth, "m")
        measures.publish("gradient", peak.gradient, "degC/m")
        measures.publish("legs", state.legs)
        if len(state.peaks) > 2:
            measures.publish(
                "spread", math.sqrt(sum((each - mean) ** 2 for each in state.peaks) / len(state.peaks)), "m"
            )

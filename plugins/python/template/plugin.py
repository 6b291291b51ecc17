"""A template for new plugins. It keeps a heading, a depth and a speed while the backseat has control.

Copy this folder, change the name in ``describe``, and change ``step``. ``python -m pytest`` runs the tests on this
computer; ``python -m backseat_sdk.build`` makes the component for the runtime.
"""

from dataclasses import dataclass
from typing import Annotated

from backseat_sdk import (
    SECOND_NS,
    Depth,
    Description,
    Failed,
    Grant,
    Modify,
    Outcome,
    Plugin,
    Rejected,
    Restored,
    Within,
    log,
)

#: The time from one step to the next.
PERIOD_NS = 1 * SECOND_NS
#: How long a request lasts. This is longer than the period, so that the request does not lapse if one step is late.
STANDS_NS = 3 * PERIOD_NS


@dataclass(frozen=True)
class Config:
    """The plugin's settings, read from ``[plugin.config]`` in the mission file. Each key names its unit. A misspelt key
    is an error, and so is a value out of its range: then the mission does not start."""

    heading_deg: Annotated[float, Within(0.0, 360.0)]
    depth_m: Annotated[float, Within(0.0, 300.0)]
    speed_mps: Annotated[float, Within(0.5, 5.0)]


@dataclass
class State:
    """What a new instance needs to continue after a failure."""

    #: The tag of the newest request. Each request has its own tag, and its outcomes carry the same one.
    tag: int = 0


class HoldHeading(Plugin):
    """Keeps a heading."""

    Config = Config
    State = State

    def describe(self):
        # Every plugin receives outcomes, control, timers, restored and shutdown. List a topic here to receive more:
        # topics=(Topic.CTD,). A mission that does not give the grants is refused.
        return Description("template", "0.1.0", step_period_ns=PERIOD_NS, grants=(Grant.MODIFY,))

    def step(self, input):
        for outcome in input.of(Outcome):
            # A refused request is not a failure of the plugin. The outcome gives the reason, and the plugin may try
            # again.
            if isinstance(outcome.state, (Rejected, Failed)):
                log.warn(f"request {outcome.tag}: {outcome.reason}")
        for restored in input.of(Restored):
            # The instance that failed made at most one request a step after its snapshot. Use none of their tags again.
            self.state.tag += restored.lost_steps
        # Without control the runtime rejects every request, so make none.
        if not input.control:
            return []
        self.state.tag += 1
        return [
            Modify(
                tag=self.state.tag,
                heading=self.config.heading_deg,
                vertical=Depth(self.config.depth_m),
                speed=self.config.speed_mps,
                duration_ns=STANDS_NS,
            )
        ]

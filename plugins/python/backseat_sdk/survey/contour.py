"""Following a contour of a field."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..frame import wrap_360
from .gradient import Slope


@dataclass(frozen=True)
class ContourFollower:
    """The heading that brings a vehicle onto a contour and along it: line-of-sight guidance with the gradient's
    estimate of where the contour is.

    - ``level``: the value of the contour.
    - ``higher_to_starboard``: the side on which the value is higher.
    - ``lookahead_m``: how far ahead on the contour to aim, metres: smaller turns in sooner and is less steady.
    - ``approach_max_deg``: the steepest angle at which it approaches, degrees.
    - ``steepness_min``: with a flatter gradient, there is no heading: per metre.
    """

    level: float
    higher_to_starboard: bool = True
    lookahead_m: float = 60.0
    approach_max_deg: float = 60.0
    steepness_min: float = 1e-6

    def offset(self, slope: Slope) -> float | None:
        """How far the contour is from the place of the slope, metres, positive uphill; ``None`` if it is too flat."""
        if slope.steepness < self.steepness_min:
            return None
        return (self.level - slope.value) / slope.steepness

    def heading(self, slope: Slope) -> float | None:
        """The heading, degrees from the frame's north, 0 to 360; ``None`` if it is too flat."""
        offset = self.offset(slope)
        if offset is None:
            return None
        side = 1.0 if self.higher_to_starboard else -1.0
        along = slope.bearing - 90.0 * side
        approach = math.degrees(math.atan2(offset, self.lookahead_m))
        approach = max(-self.approach_max_deg, min(self.approach_max_deg, approach))
        return wrap_360(along + side * approach)

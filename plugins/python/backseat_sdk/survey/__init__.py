"""Tools for surveys: plane geometry on WGS84, lines, lawnmowers, inserts, timers, coverage, gradients, contours.

Everything is plain Python: there is no numpy in the sandbox. What has a state is a dataclass that a plugin's ``State``
can have as a field, so that it survives a restart.
"""

from .contour import ContourFollower
from ..frame import Local, LocalFrame, wrap_180, wrap_360
from .gradient import PlaneFit, Slope
from .grid import CoverageGrid
from .inserts import Insert, InsertQueue, Progress
from .shapes import Box, Line, lawnmower
from .timers import Timers

__all__ = [
    "Box",
    "ContourFollower",
    "CoverageGrid",
    "Insert",
    "InsertQueue",
    "Line",
    "Local",
    "LocalFrame",
    "PlaneFit",
    "Progress",
    "Slope",
    "Timers",
    "lawnmower",
    "wrap_180",
    "wrap_360",
]

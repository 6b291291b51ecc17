"""Which part of a box was seen."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ..frame import Local
from .shapes import Box, Line


@dataclass
class CoverageGrid:
    """A grid over a box that counts how often each cell was seen. A cell counts as seen at its centre.

    - ``cell``: the side of a cell, metres.
    - ``counts``: row by row along the length of the box, from its left side.
    """

    box: Box = field(default_factory=lambda: Box(Local(0.0, 0.0), 1.0, 1.0))
    cell: float = 10.0
    counts: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        if not self.counts:
            self.counts = [0] * (self.rows * self.columns)

    @property
    def rows(self) -> int:
        """Cells along the length."""
        return max(1, math.ceil(self.box.length / self.cell - 1e-9))

    @property
    def columns(self) -> int:
        """Cells across the width."""
        return max(1, math.ceil(self.box.width / self.cell - 1e-9))

    def see(self, place: Line, port: float, starboard: float) -> int:
        """Counts what a sensor saw that moved along ``place`` and looks so many metres to both sides. Returns how many
        cells were seen for the first time."""
        length, new = place.length, 0
        sides = (place.start, place.end)
        axis = self.box.axis
        reach = max(port, starboard, 0.0) + self.cell
        alongs = sorted(axis.along(each) for each in sides)
        acrosses = sorted(axis.across(each) + self.box.width / 2.0 for each in sides)
        rows = _between(alongs[0] - reach, alongs[1] + reach, self.cell, self.rows)
        columns = _between(acrosses[0] - reach, acrosses[1] + reach, self.cell, self.columns)
        for row in rows:
            for column in columns:
                centre = self.centre_of(row, column)
                if 0.0 <= place.along(centre) <= length and -port <= place.across(centre) <= starboard:
                    index = row * self.columns + column
                    new += self.counts[index] == 0
                    self.counts[index] += 1
        return new

    def centre_of(self, row: int, column: int) -> Local:
        """The centre of a cell."""
        along = self.box.axis.at((row + 0.5) * self.cell)
        return along.offset(self.box.bearing + 90.0, (column + 0.5) * self.cell - self.box.width / 2.0)

    @property
    def percent(self) -> float:
        """How much of the box was seen at least once, percent."""
        return 100.0 * sum(count > 0 for count in self.counts) / len(self.counts)

    def unseen(self) -> list[Local]:
        """The centres of the cells that were not seen."""
        return [self.centre_of(*divmod(index, self.columns)) for index, count in enumerate(self.counts) if count == 0]


def _between(least: float, most: float, cell: float, count: int) -> range:
    return range(max(0, math.floor(least / cell)), min(count, math.floor(most / cell) + 1))

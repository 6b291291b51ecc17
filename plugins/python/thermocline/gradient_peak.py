"""The depth of the strongest vertical temperature gradient of one profile."""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Peak:
    """The strongest gradient of a profile.

    - ``depth``: metres.
    - ``gradient``: degrees Celsius per metre, by its amount.
    """

    depth: float
    gradient: float


@dataclass
class Profile:
    """The temperatures of one leg of a yo-yo, in bins of depth.

    A bin holds the number of its samples and the sums of their depths and temperatures, so that a snapshot stays small
    however long the leg takes.
    """

    #: The height of a bin, metres.
    bin_m: float = 1.0
    #: By the number of the bin from the surface: samples, sum of depths, sum of temperatures.
    bins: dict[int, tuple[float, float, float]] = field(default_factory=dict)

    def add(self, depth: float, temperature: float) -> None:
        """Adds a sample; one that is not finite is left out."""
        if not (math.isfinite(depth) and math.isfinite(temperature)) or depth < 0.0:
            return
        number = int(depth / self.bin_m)
        count, depths, temperatures = self.bins.get(number, (0.0, 0.0, 0.0))
        self.bins[number] = (count + 1.0, depths + depth, temperatures + temperature)

    def peak(self) -> Peak | None:
        """The strongest gradient, or ``None`` with fewer than four bins.

        The gradient of a bin is the slope of a straight line through it and its two neighbours, so that one noisy bin
        does not make a peak. The depth of the peak is the mean depth of the bins around the strongest one, weighted by
        how far their gradients are above half of the strongest.
        """
        means = [
            (depths / count, temperatures / count) for _, (count, depths, temperatures) in sorted(self.bins.items())
        ]
        if len(means) < 4:
            return None
        gradients = [(means[i][0], abs(_slope(means[max(0, i - 1) : i + 2]))) for i in range(len(means))]
        best = max(range(len(gradients)), key=lambda i: gradients[i][1])
        strongest = gradients[best][1]
        first, last = best, best
        while first > 0 and gradients[first - 1][1] > 0.5 * strongest:
            first -= 1
        while last + 1 < len(gradients) and gradients[last + 1][1] > 0.5 * strongest:
            last += 1
        weights = [(depth, max(0.0, gradient - 0.5 * strongest)) for depth, gradient in gradients[first : last + 1]]
        total = sum(weight for _, weight in weights)
        if total <= 0.0:
            return None
        return Peak(sum(depth * weight for depth, weight in weights) / total, strongest)


def _slope(points: list[tuple[float, float]]) -> float:
    """The slope of the straight line through points by least squares; 0 if they have one depth."""
    middle = sum(x for x, _ in points) / len(points)
    mean = sum(y for _, y in points) / len(points)
    spread = sum((x - middle) ** 2 for x, _ in points)
    return sum((x - middle) * (y - mean) for x, y in points) / spread if spread > 0.0 else 0.0

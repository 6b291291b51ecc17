"""Simulate missions of a Bluefin underwater vehicle that plugins steer, and read their logs.

    import backseat

    run = backseat.simulate("missions/isobath", seed=7, log="dive.mcap")
    print(run.outcome, run.measures["contour_rms_m"])        # metres
    track = backseat.Log(run.log).to_pandas("/navigation")

`simulate` flies a mission as `backseat sim` does, `campaign` flies many runs on all cores, `Log` reads the log of a simulation or of a dive, and `spi` decodes
and encodes sentences of the Standard Payload Interface.
"""

from . import spi
from ._native import LogError, MissionError, SpiError, __version__
from .campaign import Campaign, campaign
from .log import Log
from .simulation import Run, simulate

__all__ = ["Campaign", "Log", "LogError", "MissionError", "Run", "SpiError", "__version__", "campaign", "simulate", "spi"]

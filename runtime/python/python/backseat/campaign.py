"""Campaigns: simulated missions by the thousand."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Union

from . import _native
from .simulation import _toml

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

_Path = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True)
class Campaign:
    """The results of a campaign. `Campaign(folder)` opens results that `backseat campaign` has written."""

    out: str
    """The results folder, with `runs.parquet`, `timing.parquet`, `manifest.json` and `report.html`."""

    @property
    def report(self) -> str:
        """The path of the report, a page for a browser."""
        return os.path.join(self.out, "report.html")

    @property
    def manifest(self) -> dict[str, Any]:
        """What was flown: the campaign, the version, and the hashes of missions and components."""
        with open(os.path.join(self.out, "manifest.json"), encoding="utf-8") as file:
            return json.load(file)

    def table(self) -> pyarrow.Table:
        """The runs as a table of pyarrow, one row a run."""
        import pyarrow.parquet

        return pyarrow.parquet.read_table(os.path.join(self.out, "runs.parquet"))

    def to_pandas(self) -> pandas.DataFrame:
        """The runs as a data frame of pandas."""
        return self.table().to_pandas()

    def to_polars(self) -> polars.DataFrame:
        """The runs as a data frame of polars."""
        import polars

        return polars.read_parquet(os.path.join(self.out, "runs.parquet"))


def campaign(
    campaign: _Path,
    out: _Path,
    seeds: str | range | None = None,
    set: Mapping[str, Any] | None = None,
    plugins: _Path | None = None,
    workers: int | None = None,
) -> Campaign:
    """Flies a campaign on all cores, as `backseat campaign` does, and returns its results.

    If `out` has a part of this campaign, the campaign goes on; if it has all of it, nothing is flown. Ctrl-C stops it, and
    what was flown stays. A run that cannot be flown is a row with its reason in the column `error`.

    Args:
        campaign: A campaign's file, or a mission's folder.
        out: The results folder.
        seeds: `"1..1000"`, both ends count, or `range(1, 1001)`. Without it: those of the file; for a mission 1 to 100.
        set: Keys of `mission.toml`, and of `world.toml` behind `world.`, that are set in every run.
        plugins: The folder in which plugins are looked for first.
        workers: The number of threads; one for each core without it.

    Raises:
        MissionError: The campaign, a mission or a plugin is invalid, or `out` has results of another campaign.
    """
    if isinstance(seeds, range):
        if seeds.step != 1 or len(seeds) == 0:
            raise ValueError(f"invalid seeds {seeds!r}: expected a range with steps of 1 that is not empty")
        seeds = f"{seeds.start}..{seeds.stop - 1}"
    settings = [f"{key}={_toml(value)}" for key, value in (set or {}).items()]
    _native.campaign(campaign, out, seeds, settings, plugins, workers)
    return Campaign(os.fspath(out))

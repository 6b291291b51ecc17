"""The log of a run."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from . import _native

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow
    import xarray

_Path = Union[str, "os.PathLike[str]"]


class Log:
    """The log of a simulation or of a dive, written by `simulate(log=...)` or by `backseat run`, `fly` or `sim --log`.

        log = backseat.Log("dive.mcap")
        log.channels["/navigation"]["columns"]          # name, type, and description with the unit
        log.to_pandas("/sensors/BFCTD")

    Each table has a row for each message of its channel: `time` in UTC, `t_s` in seconds since the start of the run,
    and a column for each property, whose name has its unit (`depth_m`). Absent values are null.

    If a process was killed, its log ends early; what there is of it is read, with a `UserWarning` that says where it
    ends.

    Raises:
        FileNotFoundError: There is no such file.
        LogError: The file is not the log of a run. The message is one line.
    """

    def __init__(self, path: _Path) -> None:
        self.path = Path(path)
        self.info  # noqa: B018 - so that a wrong file is found here

    def __repr__(self) -> str:
        return f"Log({str(self.path)!r})"

    @cached_property
    def _description(self) -> dict[str, Any]:
        return json.loads(_native.describe(self.path))

    @property
    def info(self) -> dict[str, Any]:
        """What the log is of: `run` (mission, seed, version, hashes), `start` (UTC), `seconds` from there to the last
        message, `complete`, and `gaps`, where a slow disk left records out."""
        return {key: self._description[key] for key in ("run", "start", "seconds", "complete", "gaps")}

    @property
    def channels(self) -> dict[str, dict[str, Any]]:
        """Each channel by its topic, with `rows`, `schema`, and `columns`: `name`, `type`, and `description` with the
        unit, where the log has one."""
        tables = self._description["tables"]
        return {table["topic"]: {key: table[key] for key in ("rows", "schema", "columns")} for table in tables}

    def table(self, channel: str) -> pyarrow.Table:
        """The table of a channel, such as `/navigation`. DuckDB reads it by its name in SQL. Needs pyarrow.

        The table is read from Parquet, which the package writes to a temporary file.

        Raises:
            LogError: The log does not have the channel.
        """
        import pyarrow.parquet

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "table.parquet"
            _warn(_native.table(self.path, channel, path))
            # Closed before the folder is removed.
            with open(path, "rb") as file:
                return pyarrow.parquet.read_table(file)

    def to_pandas(self, channel: str) -> pandas.DataFrame:
        """The table of a channel as a data frame of pandas. Needs pyarrow and pandas.

        Raises:
            LogError: The log does not have the channel.
        """
        return self.table(channel).to_pandas()

    def to_polars(self, channel: str) -> polars.DataFrame:
        """The table of a channel as a data frame of Polars, which shares the table's memory. Needs pyarrow and Polars.

        Raises:
            LogError: The log does not have the channel.
        """
        import polars

        frame = polars.from_arrow(self.table(channel))
        assert isinstance(frame, polars.DataFrame), "a table has columns"
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """The trajectory with what was measured on it, by the conventions CF 1.8. Needs xarray and SciPy.

        It is what `backseat log export --to netcdf` writes: `lat`, `lon` and `depth` (m) over `time` (UTC), with
        `temperature`, `salinity`, flags such as `control`, and units and standard names in the attributes.

        Raises:
            LogError: The log has no position.
        """
        import xarray

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "track.nc"
            _warn(_native.trajectory(self.path, path))
            with xarray.open_dataset(path, engine="scipy") as dataset:
                return dataset.load()


def _warn(remarks: list[str]) -> None:
    for remark in remarks:
        warnings.warn(remark, stacklevel=3)

import warnings

import backseat
import duckdb
import numpy
import pandas
import polars
import pyarrow
import pytest


@pytest.fixture(scope="module")
def log(flown):
    return backseat.Log(flown.log)


def test_a_log_says_what_run_it_is_of_and_what_it_has(log, flown):
    assert log.info["run"]["mission"] == flown.mission and log.info["run"]["seed"] == "3"
    assert log.info["complete"] is True and log.info["gaps"] == []
    assert log.info["start"].endswith("Z") and abs(log.info["seconds"] - flown.report["sim_seconds"]) < 60
    navigation = log.channels["/navigation"]
    columns = {column["name"]: column for column in navigation["columns"]}
    assert navigation["rows"] > 1000 and navigation["schema"] == "backseat.Navigation"
    assert columns["depth_m"]["type"] == "number" and "True" in columns["heading_deg"]["description"]


def test_a_table_has_a_row_for_each_message_in_every_library(log):
    table = log.table("/navigation")
    assert isinstance(table, pyarrow.Table) and table.num_rows == log.channels["/navigation"]["rows"]
    assert table.column_names == [column["name"] for column in log.channels["/navigation"]["columns"]]
    assert table.schema.field("time").type == pyarrow.timestamp("ns", "UTC")
    depths_m = table["depth_m"].to_numpy()
    frame = log.to_pandas("navigation")
    assert isinstance(frame, pandas.DataFrame) and numpy.array_equal(frame["depth_m"], depths_m)
    frame = log.to_polars("/navigation")
    assert isinstance(frame, polars.DataFrame) and numpy.array_equal(frame["depth_m"].to_numpy(), depths_m)
    # DuckDB finds the table by the variable's name.
    navigation = table
    [(rows, deepest_m)] = duckdb.sql("SELECT count(*), max(depth_m) FROM navigation").fetchall()
    assert (rows, deepest_m) == (navigation.num_rows, depths_m.max())


def test_the_trajectory_has_units_and_what_the_ctd_measured(log):
    track = log.to_xarray()
    assert track.attrs["featureType"] == "trajectory" and track.sizes["time"] > 1000
    assert set(track.coords) == {"time", "lat", "lon", "depth"}
    assert track["temperature"].attrs["standard_name"] == "sea_water_temperature"
    celsius = log.to_pandas("/sensors/BFCTD")["temperature_c"]
    assert float(track["temperature"].max()) == celsius.max()
    assert numpy.array_equal(track["depth"], log.table("/navigation")["depth_m"].to_numpy())
    assert 30 < float(track["salinity"].mean()) < 40
    assert set(numpy.unique(track["control"])) == {0, 1}


def test_what_is_no_log_raises_one_line(tmp_path, log):
    with pytest.raises(FileNotFoundError, match="nowhere.mcap"):
        backseat.Log(tmp_path / "nowhere.mcap")
    text = tmp_path / "notes.txt"
    text.write_text("not a log")
    with pytest.raises(backseat.LogError, match="is not an MCAP file") as raised:
        backseat.Log(text)
    assert "\n" not in str(raised.value)
    with pytest.raises(backseat.LogError, match="no channel /nav; the log has "):
        log.table("/nav")


def test_a_log_cut_short_is_read_as_far_as_it_goes_with_a_warning(flown, tmp_path):
    cut = tmp_path / "cut.mcap"
    data = open(flown.log, "rb").read()
    cut.write_bytes(data[: len(data) // 2])
    log = backseat.Log(cut)
    assert log.info["complete"] is False
    with pytest.warns(UserWarning, match="cut short: the log ends at "):
        rows = log.table("/navigation").num_rows
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert 0 < rows < backseat.Log(flown.log).table("/navigation").num_rows

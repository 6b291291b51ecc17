import backseat
import pytest


def test_a_campaign_has_a_row_for_each_run(missions, plugins, tmp_path):
    settings = {"world.plan.1.timeout_s": 120}
    results = backseat.campaign(
        missions / "isobath", tmp_path / "out", seeds=range(1, 5), set=settings, plugins=plugins, workers=2
    )
    runs = results.to_pandas()
    assert list(runs.seed) == [1, 2, 3, 4]
    assert results.table().num_rows == results.to_polars().height == 4
    alone = backseat.simulate(missions / "isobath", seed=3, set=settings, plugins=plugins)
    assert runs.digest[2] == alone.digest
    assert open(results.report, encoding="utf-8").read().startswith("<!DOCTYPE html>")
    assert results.manifest["format"] == 1
    # It is whole, so nothing is flown again.
    before = (tmp_path / "out" / "runs.parquet").read_bytes()
    backseat.campaign(missions / "isobath", tmp_path / "out", seeds="1..4", set=settings, plugins=plugins)
    assert (tmp_path / "out" / "runs.parquet").read_bytes() == before


def test_what_is_wrong_with_a_campaign_is_one_line(missions, plugins, tmp_path):
    for arguments, expected in [
        ({"campaign": tmp_path / "nothing.toml"}, "expected a campaign's file or a mission's folder"),
        ({"campaign": missions / "isobath", "seeds": "3..1"}, "the range is empty"),
        ({"campaign": missions / "isobath", "set": {"world.nothing": 1}}, "unknown field `nothing`"),
    ]:
        with pytest.raises(backseat.MissionError) as raised:
            backseat.campaign(out=tmp_path / "out", plugins=plugins, **arguments)
        assert expected in str(raised.value) and "\n" not in str(raised.value)
    with pytest.raises(ValueError, match="steps of 1"):
        backseat.campaign(missions / "isobath", tmp_path / "out", seeds=range(1, 9, 2))

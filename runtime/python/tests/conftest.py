import os
from pathlib import Path

import backseat
import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def missions():
    return ROOT / "missions"


@pytest.fixture(scope="session")
def plugins():
    return Path(os.environ.get("BACKSEAT_PLUGINS", ROOT / "target" / "plugins"))


@pytest.fixture(scope="session")
def flown(missions, plugins, tmp_path_factory):
    """A dive with a CTD, and its log."""
    log = tmp_path_factory.mktemp("dive") / "plume.mcap"
    return backseat.simulate(missions / "plume", seed=3, plugins=plugins, log=log)

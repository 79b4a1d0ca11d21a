"""A run of seconds, and a copy of it to be spoiled."""

import shutil
from pathlib import Path

import pytest

from taichi_silo import one_run
from tests.faults.bad import SCENE


@pytest.fixture(scope="session")
def whole(tmp_path_factory):
    """The folder of a run, without figures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(one_run._Session, "_draw", lambda self: None)
        return one_run.run(SCENE, tmp_path_factory.mktemp("runs") / "whole", film=False)


@pytest.fixture
def left(whole, tmp_path):
    """A copy of it, in which it is not finished."""
    place = Path(shutil.copytree(whole, tmp_path / "left"))
    made = place / "run.toml"
    made.write_text(made.read_text().replace("finished = true", "finished = false"))
    return place

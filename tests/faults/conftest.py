"""What the tests of faults share: a run that nothing befell, and runs without what takes them their time."""

import copy
import dataclasses
import shutil
from pathlib import Path

import pytest

from taichi_silo import api
from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import ti
from taichi_silo.runs import session
from taichi_silo.runs.session import run
from taichi_silo.scene.scene import Machine
from taichi_silo.simulation.simulation import Simulation
from tests.smallest import SMALLEST


@pytest.fixture(scope="module")
def quick():
    """Runs of a scene after the other step with one simulation, put back to its start; no figures."""
    made = []

    def simulation(scene):
        key = scene.model_dump_json(exclude={"output"})
        if not made or made[2:] != [key, ti.lang.impl.get_runtime()]:  # fields end with it
            runtime.init()  # afresh: the compiled kernels that are kept know fields by their numbers
            first = Simulation(scene)
            made[:] = first, copy.deepcopy(first.state()), key, ti.lang.impl.get_runtime()
        found, start, *_ = made
        found.model, found.warnings = dataclasses.replace(found.model, scene=scene), []
        found.restore(start)
        return found

    with pytest.MonkeyPatch.context() as patch:
        runtime.init()
        patch.setattr(Machine, "start", lambda self: None)
        patch.setattr(session, "Simulation", simulation)
        patch.setattr(api, "DRAWING", ())
        yield simulation


@pytest.fixture(scope="session")
def whole(tmp_path_factory):
    """The folder of a run that nothing befell, without film and figures; not to be changed."""
    return run(SMALLEST, tmp_path_factory.mktemp("runs") / "whole")


@pytest.fixture
def left(whole, tmp_path):
    """A copy of it, in which it is not finished."""
    place = Path(shutil.copytree(whole, tmp_path / "left"))
    made = place / "run.toml"
    made.write_text(made.read_text().replace("finished = true", "finished = false"))
    return place

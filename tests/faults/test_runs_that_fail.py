"""A run that goes wrong stops with time, place and cause, and keeps everything up to then."""

import json

import numpy as np
import pandas as pd
import pytest

from taichi_silo import Flow, Mesh, Method, RunFailed, Scene, run
from taichi_silo.observers import Observer

SCENE = Scene(
    grid=Mesh(cell_size_m=0.05), flow=Flow(speed_m_per_s=0.02, displacement_m=0.004), method=Method(filling_time_s=0.2)
)


class Saboteur(Observer):
    """Changes a field of the points at a time."""

    def __init__(self, time_s, **fields):
        self.time, self.fields, self.done = time_s, fields, False

    def begin(self, simulation):
        self.simulation = simulation

    def observe(self, record):
        if record.time_s > self.time and not self.done:
            arrays = self.simulation.particles.arrays()
            for name, value in self.fields.items():
                arrays[name][7] = value
            self.simulation.particles.load(arrays)
            self.done = True


def fails(folder, scene=SCENE, extra=()):
    with pytest.raises(RunFailed) as caught:
        run(scene, folder, film=False, extra=extra)
    forces = pd.read_csv(folder / "forces.csv")
    summary = json.loads((folder / "summary.json").read_text())
    assert not summary["finished"]
    assert summary["failure"] == str(caught.value)
    assert len(forces) > 3
    assert np.isfinite(forces.drop(columns="stage").iloc[:-1]).all(axis=None)
    assert (folder / "checkpoint.npz").exists()
    return str(caught.value)


def test_a_nan_is_found_at_once(tmp_path):
    message = fails(tmp_path / "run", extra=(Saboteur(0.1, stress=np.nan),))
    assert "t = 0.1" in message
    assert "points left the silo or are not finite" in message


def test_a_point_outside_is_found_and_does_not_crash_the_process(tmp_path):
    message = fails(tmp_path / "run", extra=(Saboteur(0.1, position=[5.0, -3.0]),))
    assert "x = 5000" in message


def test_a_time_step_above_the_stable_one_is_refused_before_the_sand_explodes(tmp_path):
    scene = SCENE.model_copy(update={"method": Method(filling_time_s=0.2, time_step_s=1e-3)})
    message = fails(tmp_path / "run", scene)
    assert "is above 1.5 times the stable one of" in message


def test_sand_denser_than_any_packing_is_found(tmp_path):
    message = fails(tmp_path / "run", extra=(Saboteur(0.1, volume=0.0025 * 1.40 / 1.60),))
    assert "void ratio falls to 0.4" in message

"""What `make bench` and `make parts` time is the present solver."""

from contextlib import nullcontext

import pandas as pd
import pytest

from benchmarks import bench
from benchmarks.figure import draw
from benchmarks.parts import markdown, row, standard, trials
from benchmarks.phases import Averages, Phases
from taichi_silo.mpm.grid_means import GridMeans
from taichi_silo.mpm.neighbour_rows import NeighbourRows
from taichi_silo.mpm.nonlocal_average import Gaussian
from taichi_silo.scene.scene import Mesh, Scene
from taichi_silo.simulation.simulation import Simulation

LANES = True  # see conftest.py


@pytest.mark.long
def test_every_phase_runs():
    simulation = Simulation(Scene(grid=Mesh(cell_size_m=0.02)))
    phases = Phases(simulation.solver).all()
    assert list(phases) == ["particles to grid", "grid", "grid to particles", "grid to particles, law"]
    for run in phases.values():
        run(1, 1e-9)
    kernel, particles = Gaussian(simulation.model.spacing), simulation.model.particles
    for means in (
        NeighbourRows(kernel, particles, simulation.model.spacing), GridMeans(kernel, particles, simulation.model.grid),
    ):  # fmt: skip
        means.build()
        alone = Averages(means)
        alone.steps(2)
        assert abs(alone.found.to_numpy() - 1.0).max() < 1e-14


def test_every_trial_of_a_part_changes_the_scene_or_how_it_is_compiled():
    base = standard("smooth", 0.05, 0.001)
    for trial in trials(0.05):
        with trial.otherwise():
            changed = Scene.model_validate(base.model_dump() | {k: v for k, v in trial.tables(base).items()})
        assert changed != base or trial.otherwise is not nullcontext, trial


def test_the_table_has_a_line_for_each_row_and_signs_its_percents():
    lines = markdown([row("smooth", "half model", "put in", -0.5, (0.0, 1e-3, -0.02))]).splitlines()
    assert lines[2] == "| smooth | half model | put in | -50 % | 0 | +0.10 % | -2.00 % |"


def table(ratio, other):
    """Two lines of a benchmark, at shares of a yardstick of 1e7 point-steps a second."""
    return pd.DataFrame([
        bench.row((4000, 1, 1), "step", 4000 / (ratio * 1e7), ratio),
        bench.row((4000, 1, 1), "law", 4000 / (other * 1e7), other),
    ], columns=bench.COLUMNS)  # fmt: skip


def test_only_what_lost_more_than_a_tenth_beside_the_yardstick_is_named():
    assert bench.slower(table(0.95, 0.95), table(1.0, 1.0)) == []
    assert bench.slower(table(1.5, 0.8), table(1.0, 1.0)) == [
        "4000 points, 1 a cell, 1 thread(s), law: 0.80 of the yardstick, it was 1.00"
    ]


@pytest.mark.long
def test_the_figure_is_drawn_with_and_without_a_yardstick(tmp_path):
    roof = {"arithmetic": 2e10, "cache": 1e11, "memory": 1e10}
    draw(table(1.0, 1.0), roof, tmp_path / "with.png")
    draw(table(1.0, 1.0).assign(yardstick_ratio=None), roof, tmp_path / "without.png")
    assert (tmp_path / "with.png").stat().st_size > 10_000
    assert (tmp_path / "without.png").exists()

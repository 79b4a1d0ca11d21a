"""What `make bench` and `make parts` time is the present solver."""

from contextlib import nullcontext

from benchmarks.parts import markdown, row, standard, trials
from benchmarks.phases import Neighbours, Phases
from taichi_silo.averaging import Gaussian, NonLocal
from taichi_silo.scene import Mesh, Scene
from taichi_silo.simulation import Simulation

LANES = True  # see conftest.py


def test_every_phase_runs():
    simulation = Simulation(Scene(grid=Mesh(cell_size_m=0.02)))
    phases = Phases(simulation.solver).all()
    assert list(phases) == ["particles to grid", "grid", "grid to particles", "law"]
    for run in phases.values():
        run(1, 1e-9)
    average = NonLocal(Gaussian(simulation.spacing), simulation.particles, simulation.spacing)
    average.refresh()
    average.norm.fill(2.5)
    alone = Neighbours(average)
    alone.means(1)
    assert abs(alone.found.to_numpy() - 2.5).max() < 1e-14


def test_every_trial_of_a_part_changes_the_scene_or_how_it_is_compiled():
    base = standard("smooth", 0.05, 0.001)
    for trial in trials(0.05):
        with trial.otherwise():
            changed = Scene.model_validate(base.model_dump() | {k: v for k, v in trial.tables(base).items()})
        assert changed != base or trial.otherwise is not nullcontext, trial


def test_the_table_has_a_line_for_each_row_and_signs_its_percents():
    lines = markdown([row("smooth", "half model", "put in", -0.5, (0.0, 1e-3, -0.02))]).splitlines()
    assert lines[2] == "| smooth | half model | put in | -50 % | 0 | +0.10 % | -2.00 % |"

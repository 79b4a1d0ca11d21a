"""The same scene gives the same curves: byte by byte on one machine, to round-off where sums are added otherwise."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from taichi_silo import Flow, Machine, Mesh, Method, Scene, Silo, Walls
from taichi_silo.runs import session
from taichi_silo.runs.session import run

pytestmark = pytest.mark.usefixtures("all_cores")
ROOT = Path(__file__).parents[2]
CURVES = ("forces.csv", "balance.csv", "walls.csv")
ROUND_OFF = 1e-9  # of the largest value of a curve: what runs may differ by that add the same numbers in another order
CHILD = """
import sys
from pathlib import Path
from taichi_silo import Scene, one_run
one_run._Session._draw = lambda self: None
one_run.run(Scene.model_validate_json(sys.argv[1]), Path(sys.argv[2]), film=False)
"""


@pytest.fixture(autouse=True, scope="module")
def bare():
    """Figures take longer than these runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session._Session, "_draw", lambda self: None)
        yield


def scene(lanes: bool, threads: int = 1) -> Scene:
    """With lanes, which is how runs go if they can, or with the plain loop."""
    return Scene(
        silo=Silo(height_m=0.4), walls=Walls(kind="smooth", friction_angle_deg=19.0), grid=Mesh(cell_size_m=0.05),
        flow=Flow(speed_m_per_s=0.05, displacement_m=0.003), method=Method(filling_time_s=0.1, longest_settling_s=0.0),
        machine=Machine(threads=threads, lanes=lanes),
    )  # fmt: skip


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Folder of a run, each run once."""
    done = {}

    def folder(lanes, threads=1):
        if (lanes, threads) not in done:
            place = tmp_path_factory.mktemp("runs") / f"{lanes}_{threads}"
            done[lanes, threads] = run(scene(lanes, threads), place, film=False)
        return done[lanes, threads]

    return folder


def assert_equal(one: Path, other: Path) -> None:
    for name in CURVES:
        content = (one / name).read_bytes()
        assert len(content) > 500, name
        assert content == (other / name).read_bytes(), name


@pytest.mark.parametrize("threads", [1, 2])
def test_a_scene_run_again_gives_the_same_bytes(threads, runs, tmp_path, tried):
    again = run(scene(False, threads), tmp_path / "again", film=False)
    assert_equal(again, runs(False, threads))
    tried("loads held", f"run repeated byte by byte on {threads} thread{'s' * (threads > 1)}")


def test_another_process_gives_the_same_bytes(runs, tmp_path, tried):
    command = [sys.executable, "-c", CHILD, scene(True).model_dump_json(), str(tmp_path / "again")]
    subprocess.run(command, check=True, capture_output=True, cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)})
    assert_equal(tmp_path / "again", runs(True))
    tried("loads held", "run repeated byte by byte in another process")


def test_two_threads_give_the_bytes_of_one(runs, tried):
    """Lanes add up strips of points whose number is not that of the threads."""
    assert_equal(runs(True, 2), runs(True, 1))
    tried("loads held", "run on two threads byte by byte as on one")


def test_two_threads_of_the_plain_loop_give_the_curves_of_one_to_round_off(runs, tried):
    """There each thread adds up its own points first, so that sums are rounded otherwise, as on another machine."""
    one, two = (pd.read_csv(runs(False, threads) / "forces.csv") for threads in (1, 2))
    assert (one.stage == two.stage).all() and len(one) > 100
    for name in one.select_dtypes("number"):
        largest = np.abs(one[name]).max()
        assert np.abs(one[name] - two[name]).max() <= ROUND_OFF * largest, name
    tried("loads held", "run whose sums are added in another order: the same to 1e-9 of its largest forces")

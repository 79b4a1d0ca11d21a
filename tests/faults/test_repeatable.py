"""The same scene gives the same curves: byte by byte on one machine, to round-off where sums are added otherwise."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from taichi_silo import Scene, Walls
from taichi_silo.runs.session import run
from tests.faults.harness import child
from tests.smallest import smallest

pytestmark = pytest.mark.usefixtures("all_cores", "bare")
CURVES = ("forces.csv", "balance.csv", "walls.csv")
ROUND_OFF = 1e-9  # of the largest value of a curve: what runs may differ by that add the same numbers in another order


def scene(lanes: bool, threads: int = 1) -> Scene:
    """With lanes, which is how runs go if they can, or with the plain loop."""
    smooth = Walls(kind="smooth", friction_angle_deg=19.0)
    return smallest(walls=smooth, machine={"threads": threads, "lanes": lanes})


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Folder of a run, each run once."""
    done = {}

    def folder(lanes, threads=1):
        if (lanes, threads) not in done:
            place = tmp_path_factory.mktemp("runs") / f"{lanes}_{threads}"
            done[lanes, threads] = run(scene(lanes, threads), place)
        return done[lanes, threads]

    return folder


def assert_equal(one: Path, other: Path) -> None:
    for name in CURVES:
        content = (one / name).read_bytes()
        assert len(content) > 500, name
        assert content == (other / name).read_bytes(), name


@pytest.mark.parametrize("threads", [1, 2])
def test_a_scene_run_again_gives_the_same_bytes(threads, runs, tmp_path, tried):
    again = run(scene(False, threads), tmp_path / "again")
    assert_equal(again, runs(False, threads))
    tried("loads held", f"run repeated byte by byte on {threads} thread{'s' * (threads > 1)}")


def test_another_process_gives_the_same_bytes(runs, tmp_path, tried):
    process = child(tmp_path / "again", scene(True))
    assert process.communicate(timeout=300) and process.returncode == 0
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

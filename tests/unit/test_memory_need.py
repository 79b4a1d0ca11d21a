"""What `--check` tells as the need of memory is what has been measured (`make scale`, on docs/validation/scale.md)."""

from pathlib import Path

import pandas as pd
import pytest

from taichi_silo.scene import memory_need
from taichi_silo.scene.averaging import Averaging
from tests.smallest import SMALLEST, smallest

MEASURED = Path(__file__).parents[2] / "docs" / "data" / "memory.csv"

LOCAL = Averaging(characteristic_length_m=0.0)  # a mean takes memory of its own


def test_a_point_needs_what_was_measured_of_a_box_with_one_point_a_cell():
    measured = pd.read_csv(MEASURED, comment="#", index_col="what").bytes_a_point
    assert measured["steps"] == pytest.approx(memory_need.OF_STEPS + memory_need.OF_FILM, rel=0.05)
    assert measured["at most"] == pytest.approx(memory_need.OF_FIELDS + memory_need.OF_LOOKS, rel=0.05)
    assert measured["at most"] < 400.0


def test_half_of_a_silo_needs_less_than_the_whole_but_all_its_points_are_looked_at():
    half, whole = (
        memory_need.needed(smallest(silo=SMALLEST.silo.model_copy(update={"half": kind}), averaging=LOCAL))
        - memory_need.OF_PROCESS
        for kind in ("yes", "no")
    )
    looks = 0.5 * memory_need.OF_FIELDS + memory_need.OF_LOOKS
    assert half == pytest.approx(looks * SMALLEST.points, rel=1e-6)
    assert half < whole

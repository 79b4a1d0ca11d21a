"""The study of the silo with a resolved length: what it runs, and how it reads a sheared zone."""

import numpy as np
import pandas as pd
import pytest

from validation.resolved_silo import FINEST, LEFT_OUT, SANDS, planned, sheared_mm


def test_the_finest_cells_are_no_larger_than_the_sands_length_and_all_resolve_it(tmp_path):
    runs = planned(tmp_path)
    lengths = {name: run.scene.grid.cell_size_m / run.scene.characteristic_length_m for name, run in runs.items()}
    acts = {name: run.scene.averaging.kernel(0.0015, run.scene.spacing_m)[0] for name, run in runs.items()}
    for sand in SANDS:
        assert lengths[sand, f"cells-{FINEST}"] == pytest.approx(1.0, abs=0.03)
        assert acts[sand, "cells-40"] is None, "the paper's own, of 5 mm"
    assert lengths["dense", LEFT_OUT] == lengths["dense", "cells-80"]
    assert {run.scene.sand.loose for (sand, _), run in runs.items() if sand == "loose"} == {True}


@pytest.mark.parametrize("width", [4.0, 12.0])
def test_a_zone_is_where_the_shear_strain_is_above_half_of_its_greatest(width):
    """A way of tanh has a shear strain of 1 / cosh^2, half of it at 0.881 of its scale on either side."""
    x = np.arange(0.25, 100.0, 0.5)
    scale = 0.5 * width / np.arccosh(np.sqrt(2.0))
    left = np.tanh((x - 20.0) / scale)
    whole = pd.DataFrame({"x_mm": np.r_[x, 200.0 - x[::-1]], "way_mm": np.r_[left, left[::-1]]})
    begin, end = sheared_mm(whole)
    assert (begin, end) == pytest.approx((20.0 - 0.5 * width, 20.0 + 0.5 * width), abs=0.5)

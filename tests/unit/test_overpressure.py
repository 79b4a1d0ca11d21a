"""The largest over-pressure is found where and when it was put."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taichi_silo.analysis.measure.overpressure import largest_overpressure

TIME = np.linspace(0.0, 10.0, 21)


def history(nodes=101, wall=1, factor=2.5, place=0.25, when=13):
    """Heights, stresses and filling stresses with one broad peak."""
    height = np.linspace(0.0, 0.5, nodes)
    filling = np.tile(3000.0 * (1.0 - np.exp(-(0.5 - height) / 0.15)), (2, 1))
    stress = np.tile(filling, (len(TIME), 1, 1))
    stress[when, wall] *= 1.0 + (factor - 1.0) * (np.abs(height - place) < 0.05)
    return height, stress, filling


@pytest.mark.parametrize("nodes", [51, 101, 401])
def test_a_peak_is_found_at_any_spacing_of_the_nodes(nodes):
    height, stress, filling = history(nodes)
    found = largest_overpressure(TIME, height, stress, filling, displacement_m=2e-3 * TIME)
    assert found.factor == pytest.approx(2.5, rel=0.02)
    assert (found.wall, found.record, found.time_s) == (1, 13, TIME[13])
    assert found.displacement_m == pytest.approx(2e-3 * TIME[13])
    assert found.height_m == pytest.approx(0.25, abs=0.05)
    assert found.stress_Pa / found.filling_stress_Pa == pytest.approx(found.factor)


def test_corner_and_top_are_left_out():
    height, stress, filling = history(factor=1.0)
    stress[5, 0, height < 0.012] *= 30.0
    stress[5, 0, height > 0.49] *= 30.0
    found = largest_overpressure(TIME, height, stress, filling)
    assert found.factor == pytest.approx(1.0)
    assert np.isnan(found.displacement_m)
    low = height < 0.0225 - 1e-9
    top = filling[0] < 0.09 * filling[0].max()
    assert np.isnan(found.factor_by_height[:, low | top]).all()
    assert np.isfinite(found.factor_by_height[:, ~low & (filling[0] > 0.11 * filling[0].max())]).all()


def test_a_peak_narrower_than_a_cell_is_read_as_its_mean():
    height, stress, filling = history(nodes=1001, factor=1.0)
    filling[:], stress[:] = 1000.0, 1000.0
    stress[3, 0, np.abs(height - 0.2) < 0.005] = 3000.0
    assert largest_overpressure(TIME, height, stress, filling).factor == pytest.approx(2.0, rel=0.03)


def test_heights_without_sand_are_skipped():
    height, stress, filling = history()
    stress[10:, :, height > 0.35] = np.nan
    found = largest_overpressure(TIME, height, stress, filling)
    assert found.factor == pytest.approx(2.5, rel=0.02)
    empty = largest_overpressure(TIME, height, np.full_like(stress, np.nan), filling)
    assert np.isnan(empty.factor) and empty.wall == -1


@pytest.mark.parametrize(
    ("words", "change"),
    [
        ("shapes", lambda time, height, *rest: (time[:-1], height, *rest)),
        ("rise", lambda time, height, *rest: (time, height[::-1], *rest)),
        ("displacements", lambda *given: (*given, TIME[1:])),
    ],
)
def test_shapes_must_fit(words, change):
    with pytest.raises(ValueError, match=words):
        largest_overpressure(*change(TIME, *history()))


@settings(deadline=None, max_examples=30)
@given(st.floats(1.2, 6.0), st.floats(0.1, 0.35), st.integers(0, 20), st.floats(0.1, 10.0))
def test_the_other_wall_and_another_unit_change_nothing_else(factor, place, when, unit):
    height, stress, filling = history(factor=factor, place=place, when=when)
    found = largest_overpressure(TIME, height, stress, filling)
    other = largest_overpressure(TIME, height, unit * stress[:, ::-1], unit * filling[::-1])
    assert other.factor == pytest.approx(found.factor)
    assert (other.wall, other.record) == (1 - found.wall, found.record)

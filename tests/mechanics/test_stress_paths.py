"""The law along whole stress paths, against tightly integrated curves, at any size of step."""

from pathlib import Path

import numpy as np
import pytest

from taichi_silo.mpm.laws import GudehusBauer, Intergranular, integrate
from taichi_silo.mpm.laws.stress_point import StressPoint
from taichi_silo.studies.element_tests import TESTS, start_strain

SAND = GudehusBauer()
TOLERANCE = 1e-4  # of the stress; void ratio likewise
SHEARED = ("SS", "SSCV")
PATHS = {
    "OED": ("oedometer", "eps1_log"),
    "PSC": ("plane-strain", "eps1_log"),
    "TC": ("triaxial", "eps1_log"),
    "SS": ("simple-shear", "gamma"),
    "SSCV": ("simple-shear-constant-volume", "gamma"),
}
CURVES = sorted(file.stem for file in (Path(__file__).parents[1] / "data").glob("*_e0.??*.csv"))
PRESCRIBED = [name for name in CURVES if name.startswith(("OED", "SSCV"))]  # strain alone is given: any step is fair
MIXED = [name for name in CURVES if name.startswith(("PSC", "TC", "SS_"))]


def test_all_reference_curves_are_there():
    assert (len(PRESCRIBED), len(MIXED)) == (10, 26)


def follow(data, name, increment, longest=np.inf):
    """Largest error of the stresses over the largest of them, and of the void ratio, along a reference curve.

    A curve on which the sand liquefies is judged by its first stress.
    """
    test, column = PATHS[name.split("_")[0]]
    test = TESTS[test]
    curve = np.genfromtxt(data / f"{name}.csv", delimiter=",", names=True)
    keep = float(curve["sig22"][0]) * 1e3
    point = StressPoint(SAND, [-keep] * 3 + [0.0], curve["e"][0])
    floor = keep if name.startswith("SSCV_e0.90") else 0.0
    worst = 0.0
    for before, row in zip(curve[:-1], curve[1:], strict=True):
        if row[column] > longest:
            break
        whole = row[column] - before[column]
        size = np.sqrt(0.5) if test.sheared else 1.0  # ||D|| of unit shear, of unit compression about 1
        count = max(1, int(np.ceil(size * whole / increment)))
        step, turn = np.array(test.strain) * whole / count, test.spin * whole / count
        if test.free is None:
            point.step(step, turn, count)
        else:
            point.step_mixed(step, turn, test.free, -keep, test.tied, count)
        found = {"sig11": -point.stress[test.axial], "sig22": -point.stress[1 - test.axial]}
        if "sig12" in curve.dtype.names:
            found["sig12"] = point.stress[3]
        scale = max(1e3 * max(row[key] for key in found), floor)
        worst = max(worst, *(abs(value - 1e3 * row[key]) / scale for key, value in found.items()))
        worst = max(worst, abs(point.void_ratio - row["e"]) / row["e"])
    return worst


@pytest.mark.parametrize("increment", [1e-3, 1e-4, 1e-5, 3e-6, 1e-6, 1e-7])
@pytest.mark.parametrize("name", PRESCRIBED)
def test_where_the_strain_is_given_the_stress_is_exact_at_any_step(data, name, increment):
    assert follow(data, name, increment) < TOLERANCE


@pytest.mark.parametrize("name", PRESCRIBED)
def test_steps_of_1e_8_are_as_good(data, name):
    assert follow(data, name, 1e-8, longest=0.01) < TOLERANCE


@pytest.mark.parametrize("increment", [1e-4, 3e-6])
@pytest.mark.parametrize("name", MIXED)
def test_where_a_stress_is_kept_the_others_are_exact(data, name, increment):
    assert follow(data, name, increment) < TOLERANCE


@pytest.mark.parametrize("start", [(-5e3, -10e3, -5e3, 0.0), (-1e3, -1e3, -1e3, 500.0), (-5e5, -9e5, -3e5, 1e5)])
@pytest.mark.parametrize("direction", [(0, -1, 0, 0), (0, 1, 0, 0), (0, 0, 0, 1), (0.4, -0.6, 0, 0.5)])
def test_one_large_step_is_substepped_to_the_same_stress_as_ten_thousand_small_ones(start, direction):
    """Also where the large step empties the sand of stress."""
    ends = []
    for count in (1, 10_000):
        point = StressPoint(SAND, start, 0.60)
        point.step(np.array(direction) * 1e-3 / count, count=count)
        ends.append(point.stress)
    scale = max(np.abs(start).max(), np.abs(ends[1]).max())
    assert np.abs(ends[0] - ends[1]).max() < TOLERANCE * scale


def test_one_euler_step_of_that_size_would_be_far_off():
    """Why there is sub-stepping: the first rate, kept over the step, overshoots by half of the stress."""
    fine = StressPoint(SAND, [-5e3, -10e3, -5e3, 0.0], 0.60)
    tiny = fine.trial([0.0, -1e-9, 0.0, 0.0])[:4] - fine.stress
    euler = fine.stress + tiny * 1e6
    exact = fine.trial([0.0, -1e-3, 0.0, 0.0])[:4]
    assert np.abs(euler - exact).max() > 0.1 * np.abs(exact).max()


def test_without_error_control_steps_of_heuns_rule_miss_the_tolerance(data, monkeypatch):
    """The cure is the division of steps: undivided increments of 1e-3 leave the path."""
    monkeypatch.setattr(integrate, "LOCAL_ERROR", 1e100)
    loose = Twin()
    curve = np.genfromtxt(data / "SSCV_e0.75_s50.csv", delimiter=",", names=True)
    point = StressPoint(loose, [-50e3] * 3 + [0.0], 0.75)
    worst = 0.0
    for before, row in zip(curve[:-1], curve[1:], strict=True):
        whole = row["gamma"] - before["gamma"]
        count = max(1, round(whole / 1e-3))
        point.step([0.0, 0.0, 0.0, 0.5 * whole / count], 0.5 * whole / count, count)
        worst = max(worst, abs(-point.stress[1] / 1e3 - row["sig22"]) / row["sig22"])
    assert worst > 2.0 * TOLERANCE


class Twin(GudehusBauer):
    """The same law under another name, so that its kernels are compiled anew."""


# --- intergranular strain ---------------------------------------------------------------------------------------------


def cycled(law, amplitude, cycles, h=(0.0, 0.0, 0.0, 0.0), parts=10):
    """Vertical stress [Pa] after each cycle of uniaxial strain from 5 kPa."""
    point = StressPoint(law, [-5e3, -5e3, -5e3, 0.0], 0.60, h)
    after = []
    for _ in range(cycles):
        for sign in (1.0, -1.0, -1.0, 1.0):
            point.step([0.0, sign * amplitude / parts, 0.0, 0.0], count=parts)
        after.append(-point.stress[1])
    return np.array(after)


def test_plain_hypoplasticity_ratchets_two_thirds_of_its_stress_away_in_twenty_cycles():
    assert cycled(SAND, 1e-5, 20)[-1] == pytest.approx(1730.0, rel=0.01)


def test_intergranular_strain_keeps_the_stress_to_one_per_cent():
    assert cycled(Intergranular(), 1e-5, 20)[-1] == pytest.approx(5e3, rel=0.01)


def test_sand_that_remembers_its_filling_shakes_down_and_then_keeps_its_stress():
    """With h along the filling strain the first cycles cost a sixth of the stress; then nothing more is lost."""
    stress = cycled(Intergranular(), 1e-5, 60, h=(0.0, -1e-4, 0.0, 0.0))
    assert 0.80 < stress[19] / 5e3 < 0.86
    assert stress[59] == pytest.approx(stress[19], rel=1e-3)


def compressed(law, pressure, h, final, part=1e-5):
    """Friction angle by strain in triaxial compression."""
    point = StressPoint(law, [-pressure] * 3 + [0.0], 0.60, h)
    angles = []
    for _ in range(round(final / part / 4)):
        point.step_mixed([0.3 * part, -part, 0.3 * part, 0.0], 0.0, 0, -pressure, 2, 4)
        one, three = -point.stress[1], -point.stress[0]
        angles.append(np.degrees(np.arcsin((one - three) / (one + three))))
    return np.array(angles)


def test_triaxial_compression_with_intergranular_strain_has_the_reference_peak():
    assert compressed(Intergranular(), 50e3, (0, 0, 0, 0), 0.02).max() == pytest.approx(45.863, abs=0.01)


def test_at_silo_stress_sand_without_memory_of_its_filling_overshoots_and_with_it_does_not():
    plain = compressed(SAND, 5e3, (0, 0, 0, 0), 0.012).max()
    assert compressed(Intergranular(), 5e3, (0, 0, 0, 0), 0.012).max() == pytest.approx(66.71, abs=0.05)
    assert plain == pytest.approx(52.65, abs=0.05)
    filled = compressed(Intergranular(), 5e3, start_strain(Intergranular()), 0.012).max()
    assert filled == pytest.approx(plain, abs=0.2)


def test_stiffness_grows_by_m_R_on_reversal_and_by_m_T_on_a_right_angle():
    law = Intergranular()
    h = np.array([0.0, -law.radius, 0.0, 0.0])
    linear = _linear(np.array([0.0, 1.0, 0.0, 0.0]))
    point = StressPoint(law, [-50e3] * 3 + [0.0], 0.60, h)
    back = point.trial([0.0, 1e-9, 0.0, 0.0])[:4] - point.stress
    assert back[1] / 1e-9 == pytest.approx(law.m_R * linear[1], rel=1e-4)
    aside = point.trial([0.0, 0.0, 0.0, 1e-9])[:4] - point.stress
    assert aside[3] / 1e-9 == pytest.approx(law.m_T * _linear(np.array([0.0, 0.0, 0.0, 1.0]))[3], rel=1e-4)


def _linear(D):
    """L : D of the skeleton in an isotropic state of 50 kPa, e = 0.60: half the sum of loading and unloading."""
    point = StressPoint(SAND, [-50e3] * 3 + [0.0], 0.60)
    forward = point.trial(D * 1e-9)[:4] - point.stress
    backward = point.trial(-D * 1e-9)[:4] - point.stress
    return 0.5 * (forward - backward) / 1e-9


def test_mobilised_along_its_strain_it_is_the_skeleton():
    law = Intergranular()
    direction = np.array([0.0, -1.0, 0.0, 0.0])
    ends = [
        StressPoint(some, [-5e3, -9e3, -5e3, 1e3], 0.60, law.radius * direction).trial(1e-7 * direction)[:4]
        for some in (law, SAND)
    ]
    assert np.allclose(ends[0], ends[1], rtol=1e-12)


def test_intergranular_strain_never_leaves_its_bound_and_turns_with_the_sand():
    law = Intergranular()
    point = StressPoint(law, [-5e3] * 3 + [0.0], 0.60)
    point.step([0.0, -1e-5, 0.0, 0.0], count=200)
    size = np.sqrt(point.h @ (point.h * [1, 1, 1, 2]))
    assert size == pytest.approx(law.radius, rel=1e-3)
    assert size <= law.radius * (1 + 1e-12)
    point.step([0.0, 0.0, 0.0, 0.0], spin=np.pi / 2 / 5000, count=5000)  # a right angle: xx and yy change places
    assert point.h[0] == pytest.approx(-size, rel=1e-3)
    assert abs(point.h[1]) < 1e-3 * size

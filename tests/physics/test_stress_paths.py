"""The law along whole stress paths, against tightly integrated curves."""

import numpy as np
import pytest

from taichi_silo.laws import GudehusBauer
from taichi_silo.laws.stress_point import StressPoint

SAND = GudehusBauer()
TOLERANCE = 1e-3  # of the largest stress; void ratio likewise


def follow(data, name, void_ratio, pressure_kPa, column, step, columns, increments=25):
    """Largest relative error of the stresses (kPa, compression positive) and of the void ratio along a curve."""
    curve = np.genfromtxt(data / f"{name}.csv", delimiter=",", names=True)
    point = StressPoint(SAND, [-1e3 * pressure_kPa] * 3 + [0.0], void_ratio)
    worst = 0.0
    for before, row in zip(curve[:-1], curve[1:], strict=True):
        count = max(4, int(np.ceil((row[column] - before[column]) / 2e-4)))
        for _ in range(min(count, increments)):
            step(point, (row[column] - before[column]) / min(count, increments))
        stress = np.abs(point.stress) / 1e3
        wanted = {0: row["sig11"], 1: row["sig22"]}
        size = max(wanted.values())
        worst = max(worst, *(abs(stress[columns[k]] - value) / size for k, value in wanted.items()))
        if "sig12" in curve.dtype.names:
            worst = max(worst, abs(stress[3] - abs(row["sig12"])) / size)
        worst = max(worst, abs(point.void_ratio - row["e"]) / row["e"])
    return worst


@pytest.mark.parametrize(("e", "p"), [(0.60, 50), (0.90, 50)])
def test_plane_strain_compression(data, e, p):
    def step(point, d):
        point.step_mixed([0.3 * d, -d, 0.0, 0.0], 0.0, [0], [-1e3 * p])

    assert follow(data, f"PSC_e{e:.2f}_p{p}", e, p, "eps1_log", step, {0: 1, 1: 0}) < TOLERANCE


@pytest.mark.parametrize(("e", "p"), [(0.60, 500), (0.90, 50)])
def test_triaxial_compression(data, e, p):
    def step(point, d):
        point.step_mixed([0.3 * d, -d, 0.3 * d, 0.0], 0.0, [0], [-1e3 * p], tied=2)

    assert follow(data, f"TC_e{e:.2f}_p{p}", e, p, "eps1_log", step, {0: 1, 1: 0}) < TOLERANCE


def test_simple_shear_with_free_dilatancy(data):
    def step(point, d):
        point.step_mixed([0.0, 0.0, 0.0, 0.5 * d], 0.5 * d, [1], [-50e3])

    assert follow(data, "SS_e0.60_s50", 0.60, 50, "gamma", step, {0: 0, 1: 1}) < TOLERANCE


def test_simple_shear_at_constant_volume(data):
    def step(point, d):
        point.step([0.0, 0.0, 0.0, 0.5 * d], 0.5 * d)

    assert follow(data, "SSCV_e0.75_s50", 0.75, 50, "gamma", step, {0: 0, 1: 1}) < TOLERANCE


def test_oedometric_compression(data):
    def step(point, d):
        point.step([0.0, -d, 0.0, 0.0])

    assert follow(data, "OED_e0.60", 0.60, 1, "eps1_log", step, {0: 1, 1: 0}) < TOLERANCE


def test_one_large_step_is_substepped_to_the_same_stress_as_many_small_ones():
    ends = []
    for count in (1, 1000):
        point = StressPoint(SAND, [-5e3, -10e3, -5e3, 0.0], 0.60)
        for _ in range(count):
            point.step([0.0, -1e-3 / count, 0.0, 0.0])
        ends.append(point.stress)
    assert np.abs(ends[0] - ends[1]).max() < 1e-3 * np.abs(ends[1]).max()


def test_one_euler_step_of_that_size_would_be_far_off():
    """Why there is sub-stepping: the first rate, kept over the step, overshoots by half of the stress."""
    fine = StressPoint(SAND, [-5e3, -10e3, -5e3, 0.0], 0.60)
    tiny = fine.trial([0.0, -1e-9, 0.0, 0.0])[:4] - fine.stress
    euler = fine.stress + tiny * 1e6
    exact = fine.trial([0.0, -1e-3, 0.0, 0.0])[:4]
    assert np.abs(euler - exact).max() > 0.1 * np.abs(exact).max()

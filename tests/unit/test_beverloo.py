"""Rate of discharge: hand-computed values, exponents, the free fall that gives their order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import beta

from taichi_silo.analysis.theory.beverloo import (
    FREE_FALL_ORIFICE,
    FREE_FALL_SLOT,
    ORIFICE,
    ORIFICE_RANGE,
    SLOT,
    SLOT_RANGE,
    orifice_bounds_kg_per_s,
    orifice_rate_kg_per_s,
    slot_bounds_kg_per_s_m,
    slot_rate_kg_per_s_m,
)


def test_orifice_by_hand():
    # D = 0.0528, d = 0.002: D - 1.4 d = 0.05; 0.05^2.5 = 5.5901699e-4; sqrt(9.81) = 3.1320919
    # W = 0.58 * 1600 * 3.1320919 * 5.5901699e-4 = 2906.58128 * 5.5901699e-4 = 1.6248284 kg/s
    assert orifice_rate_kg_per_s(0.0528, 1600.0, 0.002) == pytest.approx(1.6248284, rel=1e-7)


def test_slot_by_hand():
    # b = 0.0414, d = 0.001: b - 1.4 d = 0.04; 0.04^1.5 = 0.008; W = 1.03 * 1600 * 3.1320919 * 0.008 = 41.293500 kg/s/m
    assert slot_rate_kg_per_s_m(0.0414, 1600.0, 0.001) == pytest.approx(41.2935, rel=1e-6)


@given(st.floats(0.02, 1.0), st.floats(1.1, 5.0), st.floats(0.0, 1e-3))
def test_rates_grow_with_the_free_width_to_their_exponents(free, ratio, grain):
    lost = 1.4 * grain
    for rate, power in ((orifice_rate_kg_per_s, 2.5), (slot_rate_kg_per_s_m, 1.5)):
        growth = rate(ratio * free + lost, 1500.0, grain) / rate(free + lost, 1500.0, grain)
        assert growth == pytest.approx(ratio**power, rel=1e-9)


@given(st.floats(1e-4, 1e-2), st.floats(0.0, 1.0), st.floats(1.0, 2.0))
def test_nothing_passes_an_opening_of_k_grains(grain, part, k):
    assert orifice_rate_kg_per_s(part * k * grain, 1500.0, grain, k=k) == 0.0
    assert slot_rate_kg_per_s_m(part * k * grain, 1500.0, grain, k=k) == 0.0


def test_rates_are_proportional_to_density_and_to_the_root_of_gravity():
    assert orifice_rate_kg_per_s(0.1, 3000.0) == pytest.approx(2.0 * orifice_rate_kg_per_s(0.1, 1500.0))
    heavy = slot_rate_kg_per_s_m(0.1, 1500.0, gravity_m_per_s2=4.0 * 9.81)
    assert heavy == pytest.approx(2.0 * slot_rate_kg_per_s_m(0.1, 1500.0))


def test_free_fall_from_an_arch_gives_the_order():
    # R = 1/2, g = 1: v = sqrt(2 sqrt(R^2 - r^2))
    def speed(r):
        return np.sqrt(2.0 * np.sqrt(0.25 - r**2))

    assert quad(lambda r: 2.0 * np.pi * r * speed(r), 0.0, 0.5)[0] == pytest.approx(FREE_FALL_ORIFICE, rel=1e-7)
    assert quad(speed, -0.5, 0.5)[0] == pytest.approx(FREE_FALL_SLOT, rel=1e-7)
    assert beta(0.5, 1.25) / 2.0 == pytest.approx(FREE_FALL_SLOT, rel=1e-14)
    assert ORIFICE_RANGE[0] < FREE_FALL_ORIFICE < ORIFICE_RANGE[1]
    assert round(FREE_FALL_SLOT, 2) == SLOT_RANGE[0]


def test_slot_is_an_orifice_of_its_area_and_hydraulic_diameter():
    # c = C / (pi/4); slot: c b sqrt(2 b) = (4 sqrt(2) / pi) C b^1.5 = 1.8006 * 0.58 = 1.0444
    transferred = 4.0 * np.sqrt(2.0) / np.pi * np.array([*ORIFICE_RANGE, ORIFICE])
    assert transferred[2] == pytest.approx(1.0444, abs=1e-4)
    assert transferred[2] == pytest.approx(SLOT, rel=0.02)
    assert round(transferred[1], 2) == SLOT_RANGE[1]
    assert SLOT_RANGE[0] < transferred[0]


@given(st.floats(0.01, 1.0), st.floats(0.0, 2e-3))
def test_bounds_enclose_the_rate(opening, grain):
    low, high = orifice_bounds_kg_per_s(opening, 1500.0, grain)
    assert low <= orifice_rate_kg_per_s(opening, 1500.0, grain) <= high
    low, high = slot_bounds_kg_per_s_m(opening, 1500.0, grain)
    assert low <= slot_rate_kg_per_s_m(opening, 1500.0, grain) <= high


def test_openings_may_be_an_array():
    rates = slot_rate_kg_per_s_m(np.array([0.0, 0.01, 0.04]), 1000.0)
    assert rates.shape == (3,) and rates[0] == 0.0
    assert rates[2] == pytest.approx(8.0 * rates[1])


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("bulk_density", {"bulk_density_kg_per_m3": 0.0}), ("grain_size", {"grain_size_m": -1.0}),
        ("coefficient", {"coefficient": 0.0}), (r"k must be in \[1.0, 2.0\], got 2.5", {"k": 2.5}),
        ("gravity", {"gravity_m_per_s2": float("nan")}), ("opening", {"diameter_m": -0.1}),
    ],
)  # fmt: skip
def test_impossible_openings_are_refused(name, wrong):
    with pytest.raises(ValueError, match=name):
        orifice_rate_kg_per_s(**{"diameter_m": 0.1, "bulk_density_kg_per_m3": 1500.0, **wrong})

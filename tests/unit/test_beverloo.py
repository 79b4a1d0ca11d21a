"""Rate of discharge: hand-computed values, exponents, and the free fall that gives their order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from taichi_silo.analysis.theory.beverloo import ORIFICE, SLOT, orifice_rate_kg_per_s, slot_rate_kg_per_s_m


def test_rates_by_hand():
    # D = 0.0528, d = 0.002: D - 1.4 d = 0.05; 0.05^2.5 = 5.5901699e-4; sqrt(9.81) = 3.1320919
    # W = 0.58 * 1600 * 3.1320919 * 5.5901699e-4 = 2906.58128 * 5.5901699e-4 = 1.6248284 kg/s
    assert orifice_rate_kg_per_s(0.0528, 1600.0, 0.002) == pytest.approx(1.6248284, rel=1e-7)
    # b = 0.0414, d = 0.001: b - 1.4 d = 0.04; 0.04^1.5 = 0.008; W = 1.03 * 1600 * 3.1320919 * 0.008 = 41.293500 kg/s/m
    assert slot_rate_kg_per_s_m(0.0414, 1600.0, 0.001) == pytest.approx(41.2935, rel=1e-6)


@pytest.mark.parametrize(("rate", "power"), [(orifice_rate_kg_per_s, 2.5), (slot_rate_kg_per_s_m, 1.5)])
@given(free=st.floats(0.02, 1.0), ratio=st.floats(1.1, 5.0), grain=st.floats(0.0, 1e-3))
def test_rates_grow_with_the_free_width_to_their_exponents_and_vanish_with_it(rate, power, free, ratio, grain):
    lost = 1.4 * grain
    growth = rate(ratio * free + lost, 1500.0, grain) / rate(free + lost, 1500.0, grain)
    assert growth == pytest.approx(ratio**power, rel=1e-9)
    assert rate(lost, 1500.0, grain) == 0.0
    assert rate(free, 3000.0, 0.0, 4.0 * 9.81) == pytest.approx(4.0 * rate(free, 1500.0))


def test_free_fall_from_an_arch_gives_the_order():
    # R = 1/2, g = 1: v = sqrt(2 sqrt(R^2 - r^2))
    def speed(r):
        return np.sqrt(2.0 * np.sqrt(0.25 - r**2))

    orifice = quad(lambda r: 2.0 * np.pi * r * speed(r), 0.0, 0.5)[0]
    assert orifice == pytest.approx(np.pi / 5.0, rel=1e-7) and pytest.approx(orifice, rel=0.1) == ORIFICE
    # the numbers of the docstring: free fall from an arch, and an orifice's area and hydraulic diameter
    low, high = quad(speed, -0.5, 0.5)[0], 4.0 * np.sqrt(2.0) / np.pi * 0.65
    assert (round(low, 2), round(high, 2)) == (0.87, 1.17)
    assert low < SLOT and high > SLOT

"""What results on finer and finer cells tend to, and a band that holds it."""

import math

import numpy as np
import pytest

from taichi_silo.analysis.extrapolation import limit

CELLS = [0.02, 0.0125, 0.008]


@pytest.mark.parametrize("order", [0.5, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("aim", [0.0, 0.004])
def test_results_of_one_power_of_the_cell_give_their_limit_and_their_order(order, aim):
    values = [5.0 + 3.0 * (h**order - aim**order) for h in CELLS]
    found = limit(CELLS, values, aim)
    assert found.value == pytest.approx(5.0, abs=2e-4 * abs(values[-1] - 5.0) + 1e-9)
    assert found.order == pytest.approx(order, abs=0.01)
    assert found.trust == "asymptotic"
    assert found.error == pytest.approx(3.0 * abs(values[-1] - 5.0), rel=0.02), "three results may agree by chance"


@pytest.mark.parametrize("order", [0.5, 1.0, 1.5, 2.0])
def test_four_results_of_one_power_have_the_small_factor_and_no_less_than_first_order(order):
    sizes = [*CELLS, 0.005]
    values = [5.0 + 3.0 * h**order for h in sizes]
    found, rest = limit(sizes, values), abs(values[-1] - 5.0)
    first_order = abs(values[-1] - values[-2]) * sizes[-1] / (sizes[-2] - sizes[-1])
    assert found.error == pytest.approx(max(1.25 * rest, first_order), rel=0.02)


def test_a_limit_that_moves_with_each_further_result_is_not_believed_beyond_that():
    """Two powers of the cell that cancel: the order looks good, the limits of the first and the last three differ."""
    sizes = 0.02 / 2.0 ** np.arange(4)
    values = [0.3 * (h / 0.02) ** 0.5 - 0.25 * (h / 0.02) ** 2 for h in sizes]
    found, first, last = limit(sizes, values), limit(sizes[:3], values[:3]), limit(sizes[1:], values[1:])
    assert found.error >= max(abs(first.value - found.value), abs(last.value - found.value)) - 1e-12


def test_an_order_beyond_that_of_the_method_is_not_believed():
    found = limit(CELLS, [1.0 + h**4 for h in CELLS])
    assert found.trust == "outside the asymptotic range" and found.order > 3.0
    assert abs(found.value - 1.0) < found.error


def test_results_that_scatter_are_not_extrapolated_but_told_with_three_times_their_range():
    found = limit(CELLS, [1.0, 1.2, 0.9])
    assert (found.value, found.trust, found.order) == (0.9, "scattered", None)
    assert found.error == pytest.approx(0.9)


def test_two_results_are_taken_as_of_first_order_with_the_larger_factor():
    found = limit([2.0, 1.0], [5.0, 4.0])
    assert found.value == pytest.approx(3.0) and found.error == pytest.approx(3.0)
    assert found.trust == "order assumed"


def test_one_result_has_no_error_bar_and_one_at_its_aim_no_error():
    assert math.isnan(limit([1.0], [5.0]).error)
    at_aim = limit([2.0, 1.0], [5.0, 4.0], aim=1.0)
    assert (at_aim.value, at_aim.error, at_aim.trust) == (4.0, 0.0, "exact")


def test_equal_results_are_exact_to_round_off():
    assert limit(CELLS, [1.0, 1.0, 1.0]).error == 0.0


@pytest.mark.parametrize("sizes", [[1.0, 2.0], [1.0, 1.0], [], [1.0, -1.0]])
def test_sizes_that_do_not_fall_to_the_aim_are_refused(sizes):
    with pytest.raises(ValueError, match="must fall"):
        limit(sizes, [1.0] * len(sizes))


def test_the_band_holds_the_limit_in_ninety_five_of_a_hundred_noisy_series():
    """Two powers of the cell and noise, of any sign and size."""
    chance = np.random.default_rng(1)
    held = 0
    for _ in range(400):
        count = int(chance.integers(3, 5))
        h = 0.02 / 1.6 ** np.arange(count)
        first, second = chance.normal(size=2)
        order, noise = chance.choice([1.0, 1.5, 2.0]), 10.0 ** chance.uniform(-5.0, -1.0)
        f = 1.0 + first * (h / 0.02) ** order + 0.3 * second * (h / 0.02) ** (order + 1.0)
        f += noise * chance.normal(size=count)
        found = limit(h, f)
        held += abs(found.value - 1.0) <= found.error
    assert held >= 380

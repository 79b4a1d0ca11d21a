"""The stability map, small: each failure, and its cure beside it."""

import math

import numpy as np
import pytest

from taichi_silo.mpm.filters import FILTERS
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.laws.stress_point import StressPoint
from taichi_silo.mpm.shapes import SHAPES, ConvectedDomain
from validation.stability import crossing, integration, limits, order, precision, ratcheting, rotation, walls
from validation.stability.emptying import empty
from validation.stability.stretching import NEEDED, stretch_at_fracture

pytestmark = [pytest.mark.mechanics, pytest.mark.usefixtures("afresh")]

LANES = False  # many kernels, each compiled once; see conftest.py


class TestCellCrossing:
    """A column is compressed through several cells: sigma = -(weight above), exactly."""

    def test_hat_functions_err_by_more_than_a_fifth(self):
        error, _ = crossing.column_stress_error(SHAPES["linear"](0.25))
        assert 0.2 < error < 0.5

    @pytest.mark.parametrize("name", ["ugimp", *(pytest.param(n, marks=pytest.mark.long) for n in ("cpgimp", "cpdi"))])
    def test_gimp_and_its_kin_stay_below_two_per_cent(self, name):
        error, cells = crossing.column_stress_error(SHAPES[name](0.25))
        assert cells > 1.8
        assert error < 0.02

    @pytest.mark.long
    @pytest.mark.parametrize(
        ("name", "filtering", "low", "high"),
        [
            ("cpdi", None, 0.0, 0.004),  # five times better than fixed domains
            ("bspline", None, 0.02, 0.06),  # ignores the four points of a cell
            ("ugimp", "smoothing", 0.3, np.inf),  # lets the column creep
        ],
    )
    def test_errors_of_the_others(self, name, filtering, low, high):
        error, cells = crossing.column_stress_error(SHAPES[name](0.25), filtering=FILTERS[filtering or "none"])
        assert low < error < high
        assert filtering is None or cells > 10.0


class TestStretching:
    @pytest.mark.long
    def test_fixed_domains_and_rectangles_tear_and_convected_ones_hold(self):
        assert stretch_at_fracture(SHAPES["ugimp"](0.25)) < 4.5
        assert stretch_at_fracture(SHAPES["cpdi"](0.25)) >= NEEDED[False]
        assert stretch_at_fracture(SHAPES["cpgimp"](0.25), diagonal=True) < NEEDED[True]
        assert stretch_at_fracture(SHAPES["cpdi"](0.25), diagonal=True) >= NEEDED[True]


class TestShearAndRotation:
    @pytest.mark.long
    def test_domains_without_guard_spoil_a_vortex_and_the_guard_cures_it_and_pays_with_volume(self):
        """Domains that are put back to squares no longer tile the sand; fixed ones lose less."""
        assert rotation.vortex_error(ConvectedDomain(0.25, guarded=False), 2.0, 200)[0] > 0.5
        error, volume = rotation.vortex_error(ConvectedDomain(0.25), 2.0, 200)
        assert error < 0.06 and volume > 0.1
        assert rotation.vortex_error(SHAPES["ugimp"](0.25), 2.0, 200)[1] < 0.1

    def test_a_stress_turns_with_its_body_only_by_an_objective_rate(self):
        assert rotation.rotation_error(SHAPES["ugimp"](0.25), 200) < 0.02
        assert rotation.rotation_error_without_objective_rate() > 1.0

    @pytest.mark.long
    def test_a_right_angle_squeezes_the_rectangles_of_cpgimp_to_nothing(self):
        assert rotation.domain_at_a_right_angle(SHAPES["cpgimp"](0.25), 200) < 1e-3
        assert rotation.domain_at_a_right_angle(SHAPES["cpdi"](0.25), 200) > 0.9


class TestStressIntegration:
    law = GudehusBauer()

    def test_eulers_rule_leaves_the_admissible_set_and_the_law_does_not(self):
        states, D = integration.random_states()
        for size in (1e-3, 1e-2, 0.1):
            euler = integration.after("euler", self.law, states, size * D)
            ours = integration.after("law", self.law, states, size * D)
            assert integration.inadmissible(euler).sum() > 5
            assert not integration.inadmissible(ours).any()

    def test_a_strain_that_is_none_ends_instead_of_hanging(self):
        point = StressPoint(self.law, (-1e3, -1e3, -1e3, 0.0), 0.6)
        assert not np.isfinite(point.trial([np.nan, 0.0, 0.0, 0.0])[:4]).all()
        assert len(point.trial([1e200, -1e200, 0.0, 0.0])) == 9


class TestLimitsOfTheLaw:
    @pytest.mark.parametrize("words", limits.EDGES)
    def test_no_path_beyond_an_edge_leaves_a_bad_state(self, words):
        p, e, direction = limits.EDGES[words]
        assert limits.bad_states(p, e, direction) == 0

    def test_without_guards_and_sub_steps_most_of_them_do(self):
        bad = [limits.bad_states(p, e, direction, "euler") for p, e, direction in limits.EDGES.values()]
        assert sum(count > 0 for count in bad) >= 4

    @pytest.mark.long
    def test_sand_that_falls_and_lands_is_all_there_and_weighs_what_it_did(self):
        found = limits.drop()
        assert found["bad"] == 0
        assert found["floor"] == pytest.approx(1.0, abs=0.01)
        assert found["void_low"] > 0.55
        assert found["void_high"] <= 1.30 * (1 + 1e-9)


class TestRatcheting:
    @pytest.mark.long
    def test_noise_without_control_raises_n_by_a_third_and_the_drag_cures_it(self):
        found = {name: ratcheting.history(*ratcheting.METHODS[name]) for name in ratcheting.QUICK}
        wild, tame = found["no control"], found["drag to the mean (default)"]
        assert wild["steady"] > 1.25 * wild["janssen"]
        assert wild["flow_path"] > 5e-3
        assert tame["steady"] == pytest.approx(1.035 * tame["janssen"], rel=0.02)
        assert tame["flow_path"] < 5e-5
        # shaking is no noise: it changes N whatever the control
        assert tame["shaken"] > 1.2 * tame["filled"]


class TestWalls:
    @pytest.mark.long
    def test_a_very_rough_corner_is_torn_open_without_loss(self):
        found = walls.corner("ugimp")
        assert found["bad"] == 0
        assert found["residual"] < 1e-12
        assert found["peak"] < 1.5

    @pytest.mark.long
    def test_no_point_is_pushed_through_a_wall(self):
        assert walls.pushed("ugimp")["through"] < 0.5

    @pytest.mark.long
    def test_a_slot_of_two_cells_still_carries_janssens_force(self):
        assert walls.slot(2)["normal"] < 0.05

    @pytest.mark.long
    def test_a_silo_that_loses_its_bottom_empties_to_the_last_point(self):
        found = empty(None, height=0.2)
        assert found["left"] == 0.0
        assert found["mass_error"] < 1e-12
        assert found["last"] < 2.0 * math.sqrt(2.0 * 0.24 / 9.81)  # near to free fall

    @pytest.mark.long
    def test_a_silo_with_an_outlet_keeps_its_books(self):
        found = empty(0.08, height=0.1, longest=0.4)
        assert found["mass_error"] < 1e-12
        assert found["bad"] == 0
        assert 0.1 < found["left"] < 0.9
        assert found["void_high"] <= 1.30 * (1 + 1e-9)


@pytest.mark.long
def test_f32_hardly_moves_what_sinks_slowly_and_f64_does():
    """At 0.1 mm/s a step is 1e-8 m; f32 places half a metre away are 3e-8 m apart."""
    rows = {name: precision.measured(name, (0.0005,))[0] for name in ("f64", "f32")}
    assert abs(rows["f32"]["travel"] - rows["f64"]["travel"]) > 3 * 1e-3
    assert rows["f64"]["normal"] > 0.0


class TestOrder:
    @pytest.mark.parametrize("name", ["ugimp", pytest.param("linear", marks=pytest.mark.long)])
    def test_small_motions_converge_with_second_order_whatever_the_shape(self, name):
        assert order.slope({n: order.bar(SHAPES[name](0.25), n, 1e-4) for n in (8, 16)}) > 1.8

    @pytest.mark.long
    def test_large_motions_need_domains_that_move_with_the_sand(self):
        slopes = {
            name: order.slope({n: order.bar(SHAPES[name](0.25), n, 0.1) for n in (8, 32)})
            for name in ("linear", "ugimp", "cpdi")
        }
        assert slopes["linear"] < 0.0
        assert 0.8 < slopes["ugimp"] < 1.5
        assert slopes["cpdi"] > 1.8

    @pytest.mark.long
    def test_a_ring_that_is_sheared_while_it_does_a_quarter_of_a_turn_is_followed(self):
        errors = {n: order.ring(SHAPES["ugimp"](0.25), n) for n in (16, 32)}
        assert errors[32] < 0.1
        assert order.slope(errors) > 1.3

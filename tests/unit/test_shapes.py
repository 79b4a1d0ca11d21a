"""What every shape function must do, whatever its kind."""

import numpy as np
import pytest
import taichi as ti

from taichi_silo.runtime import real
from taichi_silo.shapes import Linear, UniformGimp

EVERY_SHAPE = [Linear(), UniformGimp(0.5), UniformGimp(0.25), UniformGimp(1.0 / 6.0)]
PLACES = np.random.default_rng(1).uniform(3.0, 7.0, 500)


@ti.kernel
def _evaluate(shape: ti.template(), places: ti.types.ndarray(real, 1), table: ti.types.ndarray(real, 3)):
    for p in range(places.shape[0]):
        base, s, g = shape.axis(places[p])
        for k in ti.static(range(shape.NODES)):
            table[p, k, 0], table[p, k, 1], table[p, k, 2] = base + k, s[k], g[k]


def evaluate(shape, places):
    """Node numbers, weights and derivatives, each (points, nodes)."""
    table = np.zeros((len(places), shape.NODES, 3))
    _evaluate(shape, np.ascontiguousarray(places), table)
    return table[:, :, 0], table[:, :, 1], table[:, :, 2]


@pytest.mark.parametrize("shape", EVERY_SHAPE, ids=repr)
class TestEveryShape:
    def test_weights_are_a_partition_of_unity(self, shape):
        _, s, g = evaluate(shape, PLACES)
        assert np.abs(s.sum(axis=1) - 1.0).max() < 1e-14
        assert np.abs(g.sum(axis=1)).max() < 1e-13

    def test_weights_are_never_negative(self, shape):
        assert evaluate(shape, PLACES)[1].min() > -1e-15

    def test_a_linear_field_is_reproduced_with_its_gradient(self, shape):
        node, s, g = evaluate(shape, PLACES)
        field = 2.5 * node - 7.0
        assert np.abs((s * field).sum(axis=1) - (2.5 * PLACES - 7.0)).max() < 1e-12
        assert np.abs((g * field).sum(axis=1) - 2.5).max() < 1e-12

    def test_gradients_are_finite_differences_of_the_weights(self, shape):
        step = 1e-6
        node = np.arange(12)

        def dense(places):
            first, s, _ = evaluate(shape, places)
            full = np.zeros((len(places), len(node)))
            np.put_along_axis(full, first.astype(int), s, axis=1)
            return full

        first, _, g = evaluate(shape, PLACES)
        numeric = (dense(PLACES + step) - dense(PLACES - step)) / (2 * step)
        exact = np.zeros_like(numeric)
        np.put_along_axis(exact, first.astype(int), g, axis=1)
        away = np.abs(PLACES - np.round(PLACES)) > 2 * step  # linear weights have a kink on the node
        assert np.abs(numeric - exact)[away].max() < 1e-5

    def test_weights_of_mirrored_points_are_mirrored(self, shape):
        node, s, _ = evaluate(shape, PLACES)
        mirrored, t, _ = evaluate(shape, 10.0 - PLACES)
        moment = (s * node**2).sum(axis=1)
        assert np.allclose(moment, (t * (10.0 - mirrored) ** 2).sum(axis=1), rtol=1e-12)


def test_gimp_weights_are_hat_functions_averaged_over_the_domain():
    shape = UniformGimp(0.25)
    node, s, _ = evaluate(shape, PLACES[:50])
    offset = (np.arange(4000) + 0.5) / 4000 * 0.5 - 0.25
    for place, nodes, weights in zip(PLACES[:50], node, s, strict=True):
        hats = np.maximum(0.0, 1.0 - np.abs(place + offset[:, None] - nodes[None, :]))
        assert np.abs(hats.mean(axis=0) - weights).max() < 1e-6


def test_gradient_of_linear_shapes_jumps_at_a_node_and_that_of_gimp_does_not():
    def jump(shape):
        around = np.array([5.0 - 1e-9, 5.0 + 1e-9])
        node, _, g = evaluate(shape, around)
        of_node_5 = [g[k][node[k] == 5.0].sum() for k in range(2)]
        return abs(of_node_5[1] - of_node_5[0])

    assert jump(Linear()) > 1.9
    assert jump(UniformGimp(0.5)) < 1e-8


def test_stable_fractions_are_those_derived():
    assert UniformGimp(0.5).stable_fraction == pytest.approx(0.5774, abs=1e-3)
    assert UniformGimp(0.25).stable_fraction == pytest.approx(0.463, abs=1e-3)


def test_a_domain_wider_than_a_cell_is_refused():
    with pytest.raises(ValueError, match="0.7"):
        UniformGimp(0.7)

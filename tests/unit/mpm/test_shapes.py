"""What every shape function must do, whatever its kind."""

import itertools
import math

import numpy as np
import pytest

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.shapes import SHAPES, ContiguousGimp, ConvectedDomain, Linear, QuadraticSpline, UniformGimp

SIDE = 12  # nodes along an axis
SIZES = (0.5, 0.25, 1.0 / 6.0)
EVERY_SHAPE = [kind(half) for kind, half in itertools.product(SHAPES.values(), SIZES)]
PLACES = np.random.default_rng(1).uniform(3.0, 7.0, (300, 2))


@ti.kernel
def _evaluate(shape: ti.template(), places: ti.types.ndarray(), domains: ti.types.ndarray(), out: ti.types.ndarray()):
    for p in range(places.shape[0]):
        domain = (domains[p, 0], domains[p, 1], domains[p, 2], domains[p, 3])
        for patch in ti.static(range(shape.PATCHES)):
            i, sx, gx, j, sy, gy = shape.patch(patch, places[p, 0], places[p, 1], domain)
            for b in ti.static(range(shape.NODES)):
                for a in ti.static(range(shape.NODES)):
                    m, n = ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b
                    out[p, m, n, 0] += sx[a] * sy[b]
                    out[p, m, n, 1] += gx[a] * sy[b]
                    out[p, m, n, 2] += sx[a] * gy[b]


def evaluate(shape, places=PLACES, domain=None):
    """Weights and both derivatives at every node, each (points, nodes along x, nodes along y)."""
    places = np.ascontiguousarray(places, dtype=float)
    size = 2.0 * shape.half_size
    domains = np.tile([size, 0.0, 0.0, size] if domain is None else domain, (len(places), 1))
    out = np.zeros((len(places), SIDE, SIDE, 3))
    _evaluate(shape, places, domains, out)
    return out[..., 0], out[..., 1], out[..., 2]


X, Y = np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij")
SHEARED = (0.6, 0.1, 0.35, 0.5)  # edges of a domain that is no rectangle any more


@pytest.mark.parametrize("shape", EVERY_SHAPE, ids=repr)
class TestEveryShape:
    def test_weights_are_a_partition_of_unity(self, shape):
        s, gx, gy = evaluate(shape)
        assert np.abs(s.sum(axis=(1, 2)) - 1.0).max() < 1e-14
        assert np.abs(gx.sum(axis=(1, 2))).max() < 1e-13
        assert np.abs(gy.sum(axis=(1, 2))).max() < 1e-13

    def test_weights_are_never_negative(self, shape):
        assert evaluate(shape)[0].min() > -1e-15

    def test_a_linear_field_is_reproduced_with_its_gradient(self, shape):
        for domain in (None, SHEARED) if shape.DOMAIN else (None,):
            s, gx, gy = evaluate(shape, domain=domain)
            field = 2.5 * X - 1.5 * Y - 7.0
            exact = 2.5 * PLACES[:, 0] - 1.5 * PLACES[:, 1] - 7.0
            assert np.abs((s * field).sum(axis=(1, 2)) - exact).max() < 1e-12
            assert np.abs((gx * field).sum(axis=(1, 2)) - 2.5).max() < 1e-12
            assert np.abs((gy * field).sum(axis=(1, 2)) + 1.5).max() < 1e-12

    def test_gradients_are_finite_differences_of_the_weights(self, shape):
        if isinstance(shape, ConvectedDomain):
            pytest.skip("its gradients are means over the domain, not derivatives of its weights at the point")
        step = 1e-6
        _, gx, gy = evaluate(shape)
        for axis, slope in ((0, gx), (1, gy)):
            shift = np.eye(2)[axis] * step
            numeric = (evaluate(shape, PLACES + shift)[0] - evaluate(shape, PLACES - shift)[0]) / (2 * step)
            away = (np.abs(PLACES - np.round(PLACES)) > 2 * step).all(axis=1)  # linear weights have a kink on the node
            assert np.abs(numeric - slope)[away].max() < 1e-5

    def test_weights_of_mirrored_points_are_mirrored(self, shape):
        mirrored = evaluate(shape, 11.0 - PLACES)[0][:, ::-1, ::-1]
        assert np.allclose(evaluate(shape)[0], mirrored, atol=1e-13)

    def test_the_stable_fraction_is_that_of_the_worst_place_of_a_lattice(self, shape):
        line = (np.arange(400) + 0.5) / 400 + 5.0
        if isinstance(shape, Linear):  # the lattice where it starts; next to a node there is no bound
            line = 5.0 + np.arange(shape.half_size, 1.0, 2.0 * shape.half_size)
        places = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
        s, gx, gy = evaluate(shape, places)
        total = np.where(s > 0.0, (gx**2 + gy**2) / np.maximum(s, 1e-300), 0.0).sum(axis=(1, 2)).max()
        assert shape.stable_fraction == pytest.approx(2.0 / math.sqrt(total), rel=1e-2)


def test_gimp_weights_are_hat_functions_averaged_over_the_domain():
    offset = (np.arange(200) + 0.5) / 200 - 0.5
    for shape, width in ((UniformGimp(0.25), 0.5), (ContiguousGimp(0.25), 1.7)):
        s, _, _ = evaluate(shape, PLACES[:20], domain=[width, 0.0, 0.0, width])
        for (x, y), weights in zip(PLACES[:20], s, strict=True):
            along = [np.maximum(0.0, 1.0 - np.abs(v + width * offset[:, None] - np.arange(SIDE))) for v in (x, y)]
            exact = along[0].mean(axis=0)[:, None] * along[1].mean(axis=0)[None, :]
            assert np.abs(exact - weights).max() < 1e-4


@pytest.mark.parametrize(
    ("one", "other"), [(ContiguousGimp(0.25), UniformGimp(0.25)), (UniformGimp(0.5), QuadraticSpline())], ids=repr
)
def test_contiguous_domains_start_as_uniform_ones_which_with_one_point_a_cell_are_the_quadratic_spline(one, other):
    for mine, theirs in zip(evaluate(one), evaluate(other), strict=True):
        assert np.abs(mine - theirs).max() < (1e-13 if isinstance(one, ContiguousGimp) else 1e-14)


def test_gradients_of_convected_domains_are_means_over_the_parallelogram():
    """Of a linear interpolation between its corners: exact for bilinear fields inside one cell."""
    place, domain = np.array([[5.5, 5.5]]), [0.3, 0.1, -0.2, 0.4]
    _, gx, gy = evaluate(ConvectedDomain(0.25), place, domain)
    field = X * Y
    assert (gx * field).sum() == pytest.approx(5.5)
    assert (gy * field).sum() == pytest.approx(5.5)


def test_gradient_of_linear_shapes_jumps_at_a_node_and_that_of_the_others_does_not():
    def jump(shape):
        around = np.array([[5.0 - 1e-9, 5.5], [5.0 + 1e-9, 5.5]])
        of_node_5 = evaluate(shape, around)[1][:, 5, :].sum(axis=1)
        return abs(of_node_5[1] - of_node_5[0])

    assert jump(Linear()) > 1.9
    for shape in (UniformGimp(0.5), ContiguousGimp(0.25), ConvectedDomain(0.25), QuadraticSpline()):
        assert jump(shape) < 1e-7


def test_a_domain_wider_than_a_cell_is_refused():
    with pytest.raises(ValueError, match="0.7"):
        UniformGimp(0.7)


@ti.kernel
def _convect(shape: ti.template(), r: ti.types.ndarray(), g: ti.types.ndarray(), out: ti.types.ndarray()):
    for _ in range(1):
        a, b, c, d = shape.convected((r[0], r[1], r[2], r[3]), (g[0], g[1], g[2], g[3]))
        out[0], out[1], out[2], out[3] = a, b, c, d


SQUARE = math.sqrt(0.6)  # side of a square of this area


@pytest.mark.parametrize(
    ("domain", "change", "expected"),
    [
        ((0.5, 0.1, -0.1, 0.6), 0.0, (0.5, 0.1, -0.1, 0.6)),  # a sound one stays as it is
        ((0.5, 0.0, 0.0, 0.5), 0.2, (0.5, 0.0, 0.1, 0.5)),  # simple shear moves the upper edge
        ((4.0, 3.0, -0.3, 0.4), 0.0, (1.6, 1.2, -0.3, 0.4)),  # a long one is shortened to two cells
        ((1.5, 0.0, 1.4, 0.4), 0.0, (SQUARE, 0.0, 0.0, SQUARE)),  # a flat one becomes a square of its area
        ((0.5, 0.0, 0.1, -0.5), 0.0, None),  # a folded one a square
    ],
)
def test_convected_domains_are_guarded(domain, change, expected):
    found, free = np.zeros(4), np.zeros(4)
    given = np.array(domain), np.array([0.0, change, 0.0, 0.0])
    _convect(ConvectedDomain(0.25), *given, found)
    if expected is not None:
        assert found == pytest.approx(expected, rel=1e-12, abs=0.0)
        return
    assert (found[1], found[2]) == (0.0, 0.0) and found[0] == found[3] > 0.0
    _convect(ConvectedDomain(0.25, guarded=False), *given, free)
    assert free[0] * free[3] - free[1] * free[2] < 0.0

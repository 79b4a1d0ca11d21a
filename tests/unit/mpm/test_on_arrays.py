"""A law on arrays is the law of the kernels: one text of the formulas, run by NumPy."""

import numpy as np
import pytest

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws import Elastic, GudehusBauer
from taichi_silo.mpm.laws.on_arrays import law_on_arrays
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.tensors import norm
from taichi_silo.scene.published_sands import published

vec4 = ti.types.vector(4, real)
CONSTANTS = ("critical_friction_angle_deg", "granular_hardness_Pa", "n", "alpha", "beta", "e_i0", "e_c0", "e_d0")
SANDS = {name: {key: sand[key] for key in CONSTANTS} for name, sand in published().items()}
NUMBER = 40


@ti.kernel
def rate_of(law: ti.template(), s: vec4, e: real, d: vec4) -> vec4:
    stress, D = (s[0], s[1], s[2], s[3]), (d[0], d[1], d[2], d[3])
    a, b, c, f = law.rate(stress, stress, law.factors(stress, e), D, norm(D))
    return vec4(a, b, c, f)


@ti.kernel
def pulled_back(law: ti.template(), s: vec4, e: real) -> vec4:
    a, b, c, d = law.admissible((s[0], s[1], s[2], s[3]), e)
    return vec4(a, b, c, d)


def states():
    """Stresses from below the rest stress to 1 MPa and in tension; void ratios from below e_d to above e_i; strains."""
    random = np.random.default_rng(5)
    size = 10.0 ** random.uniform(-0.5, 6.0, NUMBER)
    stress = -size * random.uniform(0.05, 1.0, (4, NUMBER)) * np.array([[1.0], [1.0], [1.0], [0.3]])
    stress[0, ::9] *= -0.1
    return stress, random.uniform(0.4, 1.4, NUMBER), random.normal(size=(4, NUMBER))


@pytest.mark.parametrize("name", ["karlsruhe", "hostun"])
def test_rates_and_guards_are_those_of_the_kernels_to_round_off(name):
    kernels, arrays = GudehusBauer(**SANDS[name]), law_on_arrays(GudehusBauer)(**SANDS[name])
    stress, e, strain = states()
    size = np.sqrt(strain[0] ** 2 + strain[1] ** 2 + strain[2] ** 2 + 2.0 * strain[3] ** 2)
    found = arrays.rate(stress, None, arrays.factors(tuple(stress), e), tuple(strain), size)
    back = np.array([arrays.admissible(tuple(stress[:, [k]]), e[[k]]) for k in range(NUMBER)])
    for k in range(NUMBER):
        one = [vec4(*map(float, stress[:, k])), float(e[k])]
        wanted = np.array(rate_of(kernels, *one, vec4(*map(float, strain[:, k]))))
        assert np.abs(np.array([row[k] for row in found]) - wanted).max() < 1e-11 * np.abs(wanted).max()
        assert back[k].ravel() == pytest.approx(np.array(pulled_back(kernels, *one)), rel=1e-12, abs=1e-12)


def test_factors_taken_over_err_by_the_square_of_what_has_changed():
    """What the second rate of a step takes over of the first: a tenth of the strain, a hundredth of the error.

    So it is away from isotropic stress, where a1 has a kink.
    """
    law = law_on_arrays(GudehusBauer)(**SANDS["karlsruhe"])
    random = np.random.default_rng(2)
    shares = random.uniform([[0.5], [0.9], [0.5], [-0.2]], [[1.0], [1.0], [1.0], [0.2]], (4, 200))
    stress = -(10.0 ** random.uniform(3.0, 5.0, 200)) * shares
    e, strain = random.uniform(0.6, 0.8, 200), random.normal(size=(4, 200))
    strain /= np.sqrt((strain**2).sum(axis=0))

    def missed(size):
        """Of the second rate, over itself."""
        D = tuple(size * strain)
        factors = law.factors(tuple(stress), e)
        first = law.rate(tuple(stress), None, factors, D, norm_of(D))
        later, swelling = tuple(stress + np.array(first)), (1.0 + e) * (D[0] + D[1] + D[2])
        taken_over = law.advanced_factors(factors, first[0] + first[1] + first[2], swelling)
        second = np.array(law.rate(later, None, taken_over, D, norm_of(D)))
        own = np.array(law.rate(later, None, law.factors(later, e + swelling), D, norm_of(D)))
        return np.abs(second - own).max(axis=0) / np.abs(own).max(axis=0)

    large, small = missed(1e-5), missed(1e-6)
    assert np.quantile(large, 0.9) < 1e-3
    assert np.median(small / large) == pytest.approx(0.01, rel=0.1)


def norm_of(D):
    return np.sqrt(D[0] ** 2 + D[1] ** 2 + D[2] ** 2 + 2.0 * D[3] ** 2)


def test_constants_may_be_arrays():
    """Each column is the law with the constants of that column."""
    many = {key: np.array([sand[key] for sand in SANDS.values()]) for key in CONSTANTS}
    stress, e = (-4e3, -9e3, -5e3, 1e3), 0.7
    whole = law_on_arrays(GudehusBauer)(**many)
    together = np.array(whole.factors(stress, e)[:2])
    for k, sand in enumerate(SANDS.values()):
        one = law_on_arrays(GudehusBauer)(**sand)
        assert together[:, k] == pytest.approx(np.array(one.factors(stress, e)[:2]), rel=1e-14)
        assert whole.h_i[k] == pytest.approx(GudehusBauer(**sand).h_i, rel=1e-14)
        assert whole.void_ratio_limits(1e5)[1][k] == pytest.approx(GudehusBauer(**sand).void_ratio_limits(1e5)[1])


def test_another_law_runs_on_arrays_too():
    law, strain = Elastic(young_modulus_Pa=1e7, poisson_ratio=0.3), (1e-3, -2e-3, 0.0, 5e-4)
    stress = (0.0, 0.0, 0.0, 0.0)
    arrays = law_on_arrays(Elastic)(young_modulus_Pa=np.full(2, 1e7), poisson_ratio=0.3)
    found = arrays.rate(stress, None, arrays.factors(stress, 0.6), strain, 0.0)
    wanted = np.array(rate_of(law, vec4(*stress), 0.6, vec4(*strain)))
    assert np.array([np.broadcast_to(row, 2) for row in found])[:, 1] == pytest.approx(wanted, rel=1e-12)


def test_a_constant_that_a_law_does_not_have_is_noticed():
    with pytest.raises(TypeError, match="GudehusBauer has no gamma"):
        law_on_arrays(GudehusBauer)(gamma=1.0)
    with pytest.raises(TypeError, match="young_modulus_Pa"):
        law_on_arrays(Elastic)()

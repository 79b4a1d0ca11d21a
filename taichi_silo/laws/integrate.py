"""Integration of a law over a step, with as many sub-steps as the change of stress asks for."""

import taichi as ti

from taichi_silo.maths import growth
from taichi_silo.tensors import added, norm, spun, trace

EULER_CHANGE = 1e-3  # up to this relative change of stress one Euler step is enough (error below half of it)
SUBSTEP_CHANGE = 2e-2  # largest relative change of stress in one sub-step of Heun's second-order rule
MOST_SUBSTEPS = 1000


@ti.func
def total_rate(law: ti.template(), stress, void_ratio, D, spin, d_bar):
    """Material stress rate [Pa/s]: the law's Jaumann rate plus W T - T W."""
    return added(law.rate(stress, void_ratio, D, d_bar), spun(stress, spin), 1.0)


@ti.func
def substeps(law: ti.template(), stress, void_ratio, D, spin, d_bar, dt):
    """How many sub-steps of Heun's rule a step needs; 0 where one Euler step does."""
    rate = total_rate(law, stress, void_ratio, D, spin, d_bar)
    change = norm(rate) * dt / (norm(stress) + law.rest_stress + 1e-30)
    wanted = ti.min(ti.ceil(change / SUBSTEP_CHANGE), MOST_SUBSTEPS)
    return ti.cast(ti.select(change > EULER_CHANGE, wanted, 0.0), ti.i32), rate


@ti.func
def march(law: ti.template(), stress, void_ratio, D, spin, d_bar, dt, count):
    """The step in `count` sub-steps of Heun's second-order rule."""
    s0, s1, s2, s3 = stress
    e = void_ratio
    part = dt / count
    swell = growth(trace(D) * part)
    for _ in range(count):
        before = total_rate(law, (s0, s1, s2, s3), e, D, spin, d_bar)
        e = (1.0 + e) * swell - 1.0
        tried = law.admissible(added((s0, s1, s2, s3), before, part), e)
        after = total_rate(law, tried, e, D, spin, d_bar)
        s0, s1, s2, s3 = law.admissible(added((s0, s1, s2, s3), added(before, after, 1.0), 0.5 * part), e)
    return s0, s1, s2, s3, e


@ti.func
def update(law: ti.template(), stress, void_ratio, D, spin, d_bar, dt):
    """Stress and void ratio after a step of constant strain rate.

    Parameters
    ----------
    law : a law of `taichi_silo.laws`.
    stress : (xx, yy, zz, xy) [Pa], tension positive.
    void_ratio : e.
    D : strain rate (xx, yy, zz, xy) [1/s].
    spin : W_xy [1/s].
    d_bar : norm of the strain rate for the law's non-linear part [1/s].
    dt : step [s].

    Returns
    -------
    The four stresses and the void ratio.

    """
    count, rate = substeps(law, stress, void_ratio, D, spin, d_bar, dt)
    e = (1.0 + void_ratio) * growth(trace(D) * dt) - 1.0
    s0, s1, s2, s3 = law.admissible(added(stress, rate, dt), e)
    if count > 0:
        s0, s1, s2, s3, e = march(law, stress, void_ratio, D, spin, d_bar, dt, count)
    return s0, s1, s2, s3, e

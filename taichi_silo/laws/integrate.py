"""Integration of a law over a step, in sub-steps whose local error is controlled.

A step that hardly changes the stress is one step of Euler's rule. Any other is divided after Sloan (1987): each
sub-step is done by Euler's rule and by Heun's; their difference is the error of the former, and decides whether the
latter is kept and how long the next sub-step is. Source: S. W. Sloan, Int. J. Numer. Meth. Eng. 24 (1987) 893-911.
"""

import taichi as ti

from taichi_silo.maths import growth
from taichi_silo.tensors import added, norm, spun, trace

EULER_CHANGE = 1e-4  # relative change of stress (or change of h / R) up to which Euler's rule does
LOCAL_ERROR = 5e-6  # of Euler's rule in one sub-step, relative to the stress; Heun's is an order smaller
H_WEIGHT = 0.1  # a change of h by a tenth of R weighs like a change of stress by one hundredth
SMALLEST_PART = 1e-4  # of the step: a sub-step this small is taken as it is


@ti.func
def total_rate(law: ti.template(), stress, h, void_ratio, D, spin, d_bar):
    """Material stress rate [Pa/s]: the law's Jaumann rate plus W T - T W."""
    return added(law.rate(stress, h, void_ratio, D, d_bar), spun(stress, spin), 1.0)


@ti.func
def memory_rate(law: ti.template(), h, D, spin):
    """Material rate of the intergranular strain [1/s]; nothing for a law that does not remember."""
    if ti.static(law.REMEMBERS):
        return added(law.memory_rate(h, D), spun(h, spin), 1.0)
    return h


@ti.func
def remembered(law: ti.template(), h, rate, dt):
    """The intergranular strain after dt at a rate, pulled back to its bound."""
    if ti.static(law.REMEMBERS):
        return law.remembered(added(h, rate, dt))
    return h


@ti.func
def size_of(law: ti.template(), stress):
    """What errors of a stress are relative to [Pa]."""
    return norm(stress) + law.rest_stress + 1e-30


@ti.func
def change_of_memory(law: ti.template(), h_rate, dt):
    """A change of h, in such a measure that it counts like a relative change of stress."""
    if ti.static(law.REMEMBERS):
        return H_WEIGHT * dt / law.radius * norm(h_rate)
    return 0.0


@ti.func
def march(law: ti.template(), stress, h, void_ratio, D, spin, d_bar, dt, rate):
    """The step in sub-steps of Heun's rule with controlled error, from the rate at its beginning."""
    s0, s1, s2, s3 = stress
    h0, h1, h2, h3 = h
    r0, r1, r2, r3 = rate
    e, left, part = void_ratio, 1.0 + 0.0 * dt, 1.0 + 0.0 * dt
    while left > 0.0:
        step = part * dt
        h_rate = memory_rate(law, (h0, h1, h2, h3), D, spin)
        e_after = (1.0 + e) * growth(trace(D) * step) - 1.0
        tried = law.admissible(added((s0, s1, s2, s3), (r0, r1, r2, r3), step), e_after)
        tried_h = remembered(law, (h0, h1, h2, h3), h_rate, step)
        rate_after = total_rate(law, tried, tried_h, e_after, D, spin, d_bar)
        h_rate_after = memory_rate(law, tried_h, D, spin)
        error = ti.max(
            0.5 * step * norm(added(rate_after, (r0, r1, r2, r3), -1.0)) / size_of(law, (s0, s1, s2, s3)),
            change_of_memory(law, added(h_rate_after, h_rate, -1.0), 0.5 * step),
        )
        if not error > LOCAL_ERROR or part <= SMALLEST_PART:  # an error that is no number ends the march as well
            both = added((r0, r1, r2, r3), rate_after, 1.0)
            s0, s1, s2, s3 = law.admissible(added((s0, s1, s2, s3), both, 0.5 * step), e_after)
            h0, h1, h2, h3 = remembered(law, (h0, h1, h2, h3), added(h_rate, h_rate_after, 1.0), 0.5 * step)
            e = e_after
            left = ti.select(left - part > 1e-12, left - part, 0.0)
            if left > 0.0:
                r0, r1, r2, r3 = total_rate(law, (s0, s1, s2, s3), (h0, h1, h2, h3), e, D, spin, d_bar)
        part *= ti.min(ti.max(0.9 * ti.sqrt(LOCAL_ERROR / (error + 1e-30)), 0.1), 4.0)
        part = ti.min(ti.max(part, SMALLEST_PART), left)
    return s0, s1, s2, s3, h0, h1, h2, h3, e


@ti.func
def update(law: ti.template(), stress, h, void_ratio, D, spin, d_bar, dt):
    """Stress, intergranular strain and void ratio after a step of constant strain rate.

    Parameters
    ----------
    law : a law of `taichi_silo.laws`.
    stress : (xx, yy, zz, xy) [Pa], tension positive.
    h : intergranular strain (xx, yy, zz, xy); returned as it is by a law that does not remember.
    void_ratio : e.
    D : strain rate (xx, yy, zz, xy) [1/s].
    spin : W_xy [1/s].
    d_bar : norm of the strain rate for the law's non-linear part [1/s].
    dt : step [s].

    Returns
    -------
    Four stresses, four components of h, the void ratio.

    """
    rate = total_rate(law, stress, h, void_ratio, D, spin, d_bar)
    change = ti.max(dt * norm(rate) / size_of(law, stress), change_of_memory(law, D, dt))
    e = (1.0 + void_ratio) * growth(trace(D) * dt) - 1.0
    # the rate grows with a power of the mean stress: this part of the second-order term costs nothing
    rise = ti.max(ti.min(0.5 * law.degree * dt * trace(rate) / (trace(stress) - 1e-30), 0.1), -0.1)
    s0, s1, s2, s3 = law.admissible(added(stress, rate, dt * (1.0 + rise)), e)
    h0, h1, h2, h3 = remembered(law, h, memory_rate(law, h, D, spin), dt)
    if change > EULER_CHANGE:
        s0, s1, s2, s3, h0, h1, h2, h3, e = march(law, stress, h, void_ratio, D, spin, d_bar, dt, rate)
    return s0, s1, s2, s3, h0, h1, h2, h3, e

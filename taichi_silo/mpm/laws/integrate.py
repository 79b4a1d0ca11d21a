"""Integration of a law over a step, by Heun's rule, in sub-steps whose local error is controlled.

After Sloan (1987) a step is done by Euler's rule and by Heun's; their difference is the error of the former, and
decides whether the latter is kept, or the step divided. At the first try the second rate takes over the factors of
the first (`law.advanced_factors`), so that a step that is not divided computes the exponential, the powers and a1 once.
Source: S. W. Sloan, Int. J. Numer. Meth. Eng. 24 (1987) 893-911.
"""

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.lane_maths import greatest
from taichi_silo.mpm.tensors import added, chosen, inner, spun, trace

LOCAL_ERROR = 5e-5  # of Euler's rule in one sub-step, relative to the stress; Heun's is an order smaller
H_WEIGHT = 0.1  # a change of h by a tenth of R weighs like a change of stress by one hundredth
SMALLEST_PART = 1e-4  # of the step: a sub-step this small is taken as it is


@ti.func
def growth(rate_times_dt):
    """Volume ratio exp(x) of a step of volume strain x, to third order.

    The (1, 1) Pade form: a strain and its reverse cancel exactly, so that an oscillation cannot
    pump the void ratio.
    """
    return (1.0 + 0.5 * rate_times_dt) / (1.0 - 0.5 * rate_times_dt)


@ti.func
def total_rate(law: ti.template(), stress, h, factors, D, spin, d_bar):
    """Material stress rate [Pa/s]: the law's Jaumann rate plus W T - T W."""
    return added(law.rate(stress, h, factors, D, d_bar), spun(stress, spin), 1.0)


@ti.func
def memory_rate(law: ti.template(), h, D, spin):
    """Material rate of the intergranular strain [1/s]; nothing for a law that does not remember."""
    if ti.static(law.REMEMBERS):
        return added(law.memory_rate(h, D), spun(h, spin), 1.0)
    return h


@ti.func
def bounded_memory(law: ti.template(), h, rate, dt):
    """The intergranular strain after dt at a rate, pulled back to its bound."""
    if ti.static(law.REMEMBERS):
        return law.bounded_memory(added(h, rate, dt))
    return h


@ti.func
def euler_error(law: ti.template(), stress, rate, rate_after, h_rate, h_rate_after, dt):
    """Square of the error of Euler's rule, half the difference of the rates at both ends, and what it is relative to.

    That is the stress [Pa2]; a change of h counts by its own measure.
    """
    difference = added(rate_after, rate, -1.0)
    square, size = 0.25 * dt * dt * inner(difference, difference), inner(stress, stress) + law.rest_stress**2 + 1e-60
    if ti.static(law.REMEMBERS):
        of_h = added(h_rate_after, h_rate, -1.0)
        square = ti.max(square, (0.5 * H_WEIGHT / law.radius) ** 2 * dt * dt * inner(of_h, of_h) * size)
    return square, size


@ti.func
def march(law: ti.template(), stress, h, void_ratio, D, spin, d_bar, dt):
    """The step in sub-steps of Heun's rule with controlled error; lanes that are done wait for the others."""
    s0, s1, s2, s3 = stress
    h0, h1, h2, h3 = h
    e, left, part = void_ratio, 1.0 + 0.0 * d_bar, 1.0 + 0.0 * d_bar
    while greatest(left) > 0.0:
        now, now_h, step = (s0, s1, s2, s3), (h0, h1, h2, h3), part * dt
        rate = total_rate(law, now, now_h, law.factors(now, e), D, spin, d_bar)
        h_rate = memory_rate(law, now_h, D, spin)
        e_after = (1.0 + e) * growth(trace(D) * step) - 1.0
        tried = law.admissible(added(now, rate, step), e_after)
        tried_h = bounded_memory(law, now_h, h_rate, step)
        rate_after = total_rate(law, tried, tried_h, law.factors(tried, e_after), D, spin, d_bar)
        h_rate_after = memory_rate(law, tried_h, D, spin)
        square, size = euler_error(law, now, rate, rate_after, h_rate, h_rate_after, step)
        error = ti.sqrt(square / size)
        # an error that is no number ends the march as well
        good = ti.select(error > LOCAL_ERROR, ti.select(part > SMALLEST_PART, 0.0 * left, left), left) > 0.0
        heun = law.admissible(added(now, added(rate, rate_after, 1.0), 0.5 * step), e_after)
        s0, s1, s2, s3 = chosen(good, heun, now)
        h0, h1, h2, h3 = chosen(good, bounded_memory(law, now_h, added(h_rate, h_rate_after, 1.0), 0.5 * step), now_h)
        e = ti.select(good, e_after, e)
        remains = ti.select(left - part > 1e-12, left - part, 0.0 * left)
        left = ti.select(good, remains, left)
        part = part * ti.min(ti.max(0.9 * ti.sqrt(LOCAL_ERROR / (error + 1e-30)), 0.1), 4.0)
        part = ti.min(ti.max(part, SMALLEST_PART), left)
    return s0, s1, s2, s3, h0, h1, h2, h3, e


@ti.func
def update(law: ti.template(), stress, h, void_ratio, D, spin, d_bar, dt):
    """As `update_from`, with the law's factors at the beginning."""
    return update_from(law.factors(stress, void_ratio), law, stress, h, void_ratio, D, spin, d_bar, dt)


@ti.func
def update_from(factors, law: ti.template(), stress, h, void_ratio, D, spin, d_bar, dt):
    """Stress, intergranular strain and void ratio after a step of constant strain rate.

    Parameters
    ----------
    factors : `law.factors` of stress and void ratio at the beginning.
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
    rate, h_rate = total_rate(law, stress, h, factors, D, spin, d_bar), memory_rate(law, h, D, spin)
    e = (1.0 + void_ratio) * growth(trace(D) * dt) - 1.0
    later = law.advanced_factors(factors, dt * trace(rate), e - void_ratio)
    tried, tried_h = added(stress, rate, dt), bounded_memory(law, h, h_rate, dt)
    rate_after = total_rate(law, tried, tried_h, later, D, spin, d_bar)
    h_rate_after = memory_rate(law, tried_h, D, spin)
    s0, s1, s2, s3 = law.admissible(added(stress, added(rate, rate_after, 1.0), 0.5 * dt), e)
    h0, h1, h2, h3 = bounded_memory(law, h, added(h_rate, h_rate_after, 1.0), 0.5 * dt)
    square, size = euler_error(law, stress, rate, rate_after, h_rate, h_rate_after, dt)
    excess = square - LOCAL_ERROR**2 * size
    if greatest(excess) > 0.0:
        m0, m1, m2, m3, n0, n1, n2, n3, e_marched = march(law, stress, h, void_ratio, D, spin, d_bar, dt)
        large = excess > 0.0
        s0, s1, s2, s3 = chosen(large, (m0, m1, m2, m3), (s0, s1, s2, s3))
        h0, h1, h2, h3 = chosen(large, (n0, n1, n2, n3), (h0, h1, h2, h3))
        e = ti.select(large, e_marched, e)
    return s0, s1, s2, s3, h0, h1, h2, h3, e

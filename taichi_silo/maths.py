"""Elementary functions, each for a scalar and for a vector of lanes alike.

Formulas of a point (laws, shapes) use + - * /, min, max, sqrt, select and these functions only, and never branch at
run time, so that one source serves a GPU thread, a stress point and a group of particles. Branches belong to the loops.
"""

import taichi as ti


@ti.func
def power(base, exponent: ti.template()):
    """base**exponent for base >= 0 and an exponent known at compile time."""
    result = base
    if ti.static(exponent == 0.5):
        result = ti.sqrt(base)
    elif ti.static(exponent != 1.0):
        result = base**exponent
    return result


@ti.func
def exp_minus(x):
    """exp(-x)."""
    return ti.exp(-x)


@ti.func
def growth(rate_times_dt):
    """Volume ratio exp(x) of a step of volume strain x, to third order.

    The (1, 1) Pade form: a strain and its reverse cancel exactly, so that an oscillation cannot
    pump the void ratio.
    """
    return (1.0 + 0.5 * rate_times_dt) / (1.0 - 0.5 * rate_times_dt)

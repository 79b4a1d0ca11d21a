"""Elementary functions, each of a number or of a vector of eight.

Formulas of a point (laws, shapes) use + - * /, min, max, sqrt, select and these functions only, and never branch at
run time, so that one source serves a GPU thread, a stress point and a group of particles. Branches belong to the loops,
which ask for the `greatest` lane.

Of a vector, a power and an exponential are polynomials, because the processor's vector unit has neither, and so they
are of a number on Vulkan, whose SPIR-V has neither in f64: within 1e-14 of the library's. There a base above
`most` counts as that, and one below 1e-18 as 0.
"""

import functools
import math
from collections.abc import Callable

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.vectors import eight, is_eight

ROOT2 = math.sqrt(2.0)
UPPER = 2.0**0.25  # a base is brought to 2**-1/4 ... 2**1/4 by powers of two and a root of two
DOWN, UP = (32, 16, 8, 4, 2, 1), (8, 4, 2, 1)  # exponents of those powers
SQUARINGS, MORE_SQUARINGS = 4, 6  # of exp(x / 16) and, of a number, exp(x / 64), or of exp(-x)
LARGEST = 0.5  # exponent there, at most: x counts as at most 8 and, of a number, 32


Series = tuple[tuple[float, ...], float]  # coefficients, middle


@functools.cache
def series(function: Callable[[np.ndarray], np.ndarray], lowest: float, highest: float, degree: int) -> Series:
    """Coefficients of a polynomial in (x - middle), and the middle: Chebyshev interpolation in long double."""
    kind = np.longdouble
    low, high = kind(lowest), kind(highest)
    angles = (np.arange(4 * degree).astype(kind) + kind(0.5)) * (kind(4) * np.arctan(kind(1))) / kind(4 * degree)
    nodes = np.cos(angles)
    values = function(0.5 * (low + high) + 0.5 * (high - low) * nodes)
    powers = [np.array([1], kind), np.array([0, 1], kind)]  # Chebyshev polynomials by their coefficients
    found = np.zeros(degree + 1, kind)
    for k in range(degree + 1):
        if k > 1:
            following = np.zeros(k + 1, kind)
            following[1:] = 2 * powers[-1]
            following[: k - 1] -= powers[-2]
            powers.append(following)
        share = (kind(2) - (k == 0)) * (np.cos(k * angles) * values).sum() / len(nodes)
        found[: k + 1] += share * powers[k]
    scale = kind(2) / (high - low)
    return tuple(float(found[k] * scale**k) for k in range(degree + 1)), float(0.5 * (low + high))


@functools.cache
def power_series(exponent: float) -> Series:
    """Of x**exponent around 1."""
    return series(lambda x: np.power(x, np.longdouble(exponent)), 1.0 / UPPER, UPPER, 13)


@functools.cache
def exponential_series(sign: float) -> Series:
    """Of exp(sign x) between 0 and 1/2."""
    return series(lambda x: np.exp(sign * x), 0.0, LARGEST, 11)


@ti.func
def polynomial(c: ti.template(), x):
    """Sum of c_k x^k in pairs of pairs, so that the terms do not wait for each other."""
    x2 = x * x
    x4 = x2 * x2
    low = (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2
    middle = (c[4] + c[5] * x) + (c[6] + c[7] * x) * x2
    high = (c[8] + c[9] * x) + (c[10] + c[11] * x) * x2
    if ti.static(len(c) > 12):
        high = high + (c[12] + c[13] * x) * x4
    return (low + middle * x4) + high * (x4 * x4)


@ti.func
def polynomial_power(base, exponent: ti.template(), most: ti.template()):
    """base**exponent by peeling off powers of two."""
    rest, factor = smaller(base, most), alike(1.0, base)
    for k in ti.static([k for k in UP if most > UPPER * 2.0 ** (k - 1)]):
        above = rest > UPPER * 2.0 ** (k - 1)
        rest = ti.select(above, rest * 2.0**-k, rest)
        factor = ti.select(above, factor * 2.0 ** (k * exponent), factor)
    for k in ti.static(DOWN):
        below = rest < UPPER * 2.0**-k
        rest = ti.select(below, rest * 2.0**k, rest)
        factor = ti.select(below, factor * 2.0 ** (-k * exponent), factor)
    below = rest < 1.0 / UPPER
    rest = ti.select(below, rest * ROOT2, rest)
    factor = ti.select(below, factor * 2.0 ** (-0.5 * exponent), factor)
    c, middle = ti.static(power_series(exponent))
    return ti.select(base > 1e-18, factor * polynomial(c, rest - middle), alike(0.0, base))


def by_polynomials(value: object) -> bool:
    """Whether the device has no power and no exponential of a value (asked while a kernel is compiled)."""
    return is_eight(value) or runtime.lacks_functions()


@ti.func
def polynomial_exponential(x, sign: ti.template(), squarings: ti.template()):
    """exp(sign x) for x >= 0 by squaring exp(sign x / 2**squarings)."""
    c, middle = ti.static(exponential_series(sign))
    result = polynomial(c, smaller(x, ti.static(LARGEST * 2.0**squarings)) * 0.5**squarings - middle)
    for _ in ti.static(range(squarings)):
        result = result * result
    return result


@ti.func
def power(base, exponent: ti.template(), most: ti.template() = 32768.0):
    """base**exponent for a base from 0 to `most` and an exponent known at compile time."""
    result = base
    if ti.static(exponent == 0.5):
        result = ti.sqrt(base)
    elif ti.static(exponent != 1.0 and by_polynomials(base)):
        result = polynomial_power(base, exponent, most)
    elif ti.static(exponent != 1.0):
        result = base**exponent
    return result


@ti.func
def exp_minus(x, most: ti.template() = LARGEST * 2.0**SQUARINGS):
    """exp(-x) for x >= 0; of a vector, x counts as at most 8, or 32 if `most` asks for that."""
    result = x
    if ti.static(is_eight(x)):
        squarings = ti.static(SQUARINGS if most <= LARGEST * 2.0**SQUARINGS else MORE_SQUARINGS)
        result = polynomial_exponential(x, -1.0, squarings)
    elif ti.static(by_polynomials(x)):
        result = polynomial_exponential(x, -1.0, MORE_SQUARINGS)
    else:
        result = ti.exp(0.0 - x)
    return result


@ti.func
def exp_plus(x):
    """exp(x) for x >= 0."""
    result = x
    if ti.static(is_eight(x)):
        result = polynomial_exponential(x, 1.0, SQUARINGS)
    elif ti.static(by_polynomials(x)):
        result = polynomial_exponential(x, 1.0, MORE_SQUARINGS)
    else:
        result = ti.exp(x)
    return result


@ti.func
def alike(number, x):
    """A constant, as a vector if x is one."""
    if ti.static(is_eight(x)):
        return eight(number)
    return ti.cast(number, real)


@ti.func
def total(x):
    """The sum of the lanes."""
    return ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))


@ti.func
def larger(x, limit):
    """The larger of x and a limit, which counts if x is no number: one instruction, where ti.max takes three."""
    return ti.select(x > limit, x, limit)


@ti.func
def smaller(x, limit):
    """The smaller of x and a limit, which counts if x is no number."""
    return ti.select(x < limit, x, limit)


@ti.func
def greatest(x):
    """The greatest of the lanes; of a scalar, itself."""
    if ti.static(is_eight(x)):
        y = ti.max(x, eight(x[4], x[5], x[6], x[7], x[0], x[1], x[2], x[3]))
        z = ti.max(y, eight(y[2], y[3], y[0], y[1], y[6], y[7], y[4], y[5]))
        return ti.max(z[0], z[1])
    return x

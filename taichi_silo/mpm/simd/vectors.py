"""Eight numbers that stay one vector of the processor."""

import contextlib
from collections.abc import Iterator

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real

LANES = 8
eight = ti.types.vector(LANES, real)
arrays_of_eight = ti.types.ndarray(eight, 1)


def is_eight(value: object) -> bool:
    """Whether a value in a kernel is a vector of the processor, not a number (asked while the kernel is compiled)."""
    return isinstance(value, ti.lang.expr.Expr) and value.is_tensor()


@contextlib.contextmanager
def compiling_simd() -> Iterator[None]:
    """Kernels that are called here for the first time keep vectors of eight as vectors of the processor.

    That is a switch inside Taichi 1.7 and its fork, which end the whole process where they meet an operation that they
    do not know (unary minus, abs, cast, exp, log of a vector): `selftest` tries it first.

    Taichi's own search for equal expressions is left out: for a step it takes four seconds, growing as the square of
    the statements, and LLVM finds the same.
    """
    configuration = ti.lang.impl.current_cfg()
    level = configuration.opt_level
    configuration.real_matrix_scalarize, configuration.opt_level = False, 0
    try:
        yield
    finally:
        configuration.real_matrix_scalarize, configuration.opt_level = True, level


@ti.func
def transposed(a0, a1, a2, a3, a4, a5, a6, a7):
    """Columns of the eight rows a0 ... a7, in three rounds of exchanges between two vectors."""
    b0, b1 = _pairs(a0, a1)
    b2, b3 = _pairs(a2, a3)
    b4, b5 = _pairs(a4, a5)
    b6, b7 = _pairs(a6, a7)
    c0, c2 = _quarters(b0, b2)
    c1, c3 = _quarters(b1, b3)
    c4, c6 = _quarters(b4, b6)
    c5, c7 = _quarters(b5, b7)
    d0, d4 = _halves(c0, c4)
    d1, d5 = _halves(c1, c5)
    d2, d6 = _halves(c2, c6)
    d3, d7 = _halves(c3, c7)
    return d0, d1, d2, d3, d4, d5, d6, d7


@ti.func
def _pairs(a, b):
    """Even places of two vectors in turns, and odd ones."""
    return (
        eight(a[0], b[0], a[2], b[2], a[4], b[4], a[6], b[6]), eight(a[1], b[1], a[3], b[3], a[5], b[5], a[7], b[7])
    )  # fmt: skip


@ti.func
def _quarters(a, b):
    """First and third, second and fourth quarters."""
    return (
        eight(a[0], a[1], b[0], b[1], a[4], a[5], b[4], b[5]), eight(a[2], a[3], b[2], b[3], a[6], a[7], b[6], b[7])
    )  # fmt: skip


@ti.func
def _halves(a, b):
    """First and second halves."""
    return (
        eight(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]), eight(a[4], a[5], a[6], a[7], b[4], b[5], b[6], b[7])
    )  # fmt: skip

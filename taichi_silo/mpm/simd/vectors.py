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
    """
    configuration = ti.lang.impl.current_cfg()
    configuration.real_matrix_scalarize = False
    try:
        yield
    finally:
        configuration.real_matrix_scalarize = True

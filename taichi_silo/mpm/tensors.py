"""Algebra of plane symmetric tensors, kept as tuples (xx, yy, zz, xy).

The out-of-plane component zz is part of every stress and strain rate (plane strain only sets D_zz = 0), and xy
stands twice in every product, as it does in the 3x3 matrix. The members may be scalars or lanes (which know no
unary minus: write 0.0 - a).
Sign convention of the whole solver: tension positive.
"""

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.lane_maths import alike, larger


@ti.func
def trace(a):
    """A_ii."""
    return a[0] + a[1] + a[2]


@ti.func
def pressure_of(a):
    """Mean stress p = -tr A / 3, positive in compression."""
    return trace(a) * (-1.0 / 3.0)


@ti.func
def inner(a, b):
    """A : B = A_ij B_ij."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * a[3] * b[3]


@ti.func
def norm(a):
    """||A|| = sqrt(A : A)."""
    return ti.sqrt(inner(a, a))


@ti.func
def scaled(a, factor):
    """Factor * A."""
    return (a[0] * factor, a[1] * factor, a[2] * factor, a[3] * factor)


@ti.func
def added(a, b, factor):
    """A + factor * B."""
    return (a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2], a[3] + factor * b[3])


@ti.func
def chosen(condition, a, b):
    """A where the condition holds, else B."""
    return (
        ti.select(condition, a[0], b[0]),
        ti.select(condition, a[1], b[1]),
        ti.select(condition, a[2], b[2]),
        ti.select(condition, a[3], b[3]),
    )


@ti.func
def shifted(a, pressure):
    """A + pressure * I: with pressure = p = -tr A / 3 the deviator of a stress A."""
    return (a[0] + pressure, a[1] + pressure, a[2] + pressure, a[3])


@ti.func
def trace_of_cube(a):
    """Tr(A A A)."""
    return a[0] ** 3 + a[1] ** 3 + a[2] ** 3 + 3.0 * a[3] * a[3] * (a[0] + a[1])


@ti.func
def largest_principal(a):
    """Largest principal value of A, the out-of-plane one included."""
    centre = 0.5 * (a[0] + a[1])
    half = 0.5 * (a[0] - a[1])
    return larger(centre + ti.sqrt(half * half + a[3] * a[3]), a[2])


@ti.func
def spun(a, spin):
    """W A - A W for the plane spin W_xy = spin = (L_xy - L_yx) / 2: what Jaumann's rate leaves out."""
    turn = 2.0 * spin * a[3]
    return (turn, 0.0 - turn, alike(0.0, turn), spin * (a[1] - a[0]))

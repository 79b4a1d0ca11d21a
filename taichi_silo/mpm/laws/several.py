"""Several laws in one body, such as sands in layers: each point says by its field `sand` which of them is its own."""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws import integrate
from taichi_silo.mpm.simd.lane_maths import alike, greatest, smaller
from taichi_silo.mpm.tensors import chosen


@frozen
class Several:
    """Laws of one kind, for grains of one density; `sand` of a point is the number of its own (0, 1, ...).

    What Python asks for is that of the first law, or on the safe side of all.
    """

    laws: tuple

    @property
    def grain_density(self) -> float:
        """Of all grains [kg/m3]."""
        return self.laws[0].grain_density

    @property
    def rest_stress(self) -> float:
        """The greatest [Pa]."""
        return max(one.rest_stress for one in self.laws)

    @property
    def degree(self) -> float:
        """The greatest: of the law that stiffens most with the stress."""
        return max(one.degree for one in self.laws)

    @property
    def radius(self) -> float:
        """Bound of the intergranular strain of all."""
        return self.laws[0].radius

    @property
    def REMEMBERS(self) -> bool:
        """Whether points carry intergranular strain."""
        return self.laws[0].REMEMBERS

    def rest_pressure_ratio(self, void_ratio: float) -> float:
        """K0 of the first."""
        return self.laws[0].rest_pressure_ratio(void_ratio)


def laws_of(law: object) -> tuple:
    """The laws of a body."""
    return law.laws if isinstance(law, Several) else (law,)


def are_several(law: object) -> bool:
    """Whether points have laws of their own."""
    return isinstance(law, Several)


# --- what the law of point p says: the only one, or its own ---------------------------------------------------------


@ti.func
def share(points: ti.template(), p, n: ti.template()):
    """1 where the law of point p is that of number n, 0 elsewhere."""
    apart = points.read("sand", p) - float(n)
    return ti.select(apart * apart < 0.25, alike(1.0, apart), alike(0.0, apart))


@ti.func
def factors(law: ti.template(), points: ti.template(), p, stress, void_ratio):
    """As `law.factors`; of several laws none, as each is computed only where points have it."""
    if ti.static(not are_several(law)):
        return law.factors(stress, void_ratio)
    return (void_ratio,)


@ti.func
def update_from(
    factors, law: ti.template(), points: ti.template(), p, stress, h, void_ratio, D, spin, d_bar, dt
):  # fmt: skip
    """As `integrate.update_from`. Of eight points that have one law the others are not computed."""
    if ti.static(not are_several(law)):
        return integrate.update_from(factors, law, stress, h, void_ratio, D, spin, d_bar, dt)
    s0, s1, s2, s3 = stress
    h0, h1, h2, h3 = h
    e = void_ratio
    for n, one in ti.static(enumerate(laws_of(law))):
        mine = share(points, p, n)
        if greatest(mine) > 0.0:
            a0, a1, a2, a3, b0, b1, b2, b3, e_after = integrate.update(one, stress, h, void_ratio, D, spin, d_bar, dt)
            own = mine > 0.0
            s0, s1, s2, s3 = chosen(own, (a0, a1, a2, a3), (s0, s1, s2, s3))
            h0, h1, h2, h3 = chosen(own, (b0, b1, b2, b3), (h0, h1, h2, h3))
            e = ti.select(own, e_after, e)
    return s0, s1, s2, s3, h0, h1, h2, h3, e


@ti.func
def admissible(law: ti.template(), points: ti.template(), p, stress, void_ratio):
    """As `law.admissible`."""
    if ti.static(not are_several(law)):
        return law.admissible(stress, void_ratio)
    s0, s1, s2, s3 = stress
    for n, one in ti.static(enumerate(laws_of(law))):
        s0, s1, s2, s3 = chosen(share(points, p, n) > 0.0, one.admissible(stress, void_ratio), (s0, s1, s2, s3))
    return s0, s1, s2, s3


@ti.func
def stiffness(law: ti.template(), points: ti.template(), p, stress, void_ratio):
    """As `law.stiffness` [Pa]."""
    if ti.static(not are_several(law)):
        return law.stiffness(stress, void_ratio)
    found = 0.0 * void_ratio
    for n, one in ti.static(enumerate(laws_of(law))):
        found = ti.select(share(points, p, n) > 0.0, one.stiffness(stress, void_ratio), found)
    return found


@ti.func
def loosest(law: ti.template(), points: ti.template(), p, void_ratio):
    """The void ratio, at most that of `law.loosest`."""
    found = void_ratio
    for n, one in ti.static(enumerate(laws_of(law))):
        if ti.static(are_several(law)):
            found = ti.select(share(points, p, n) > 0.0, smaller(void_ratio, one.loosest), found)
        else:
            found = smaller(void_ratio, one.loosest)
    return found


@ti.func
def room(law: ti.template(), points: ti.template(), p, stress, void_ratio):
    """As `law.room`; 1 for laws without it."""
    found = 0.0 * void_ratio + 1.0
    for n, one in ti.static(enumerate(laws_of(law))):
        if ti.static(hasattr(one, "room")):
            left = one.room(stress, void_ratio)
            if ti.static(are_several(law)):
                found = ti.select(share(points, p, n) > 0.0, left, found)
            else:
                found = left
    return found

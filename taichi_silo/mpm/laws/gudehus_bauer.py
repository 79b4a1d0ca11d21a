"""Hypoplastic sand after Gudehus and Bauer (1996): the law of the paper's appendix.

    T_obj = f_s [ a1^2 D + T^ tr(T^ D) + f_d a1 (T^ + T^*) ||D|| ],   T^ = T / tr T,   T^* = T^ - I / 3

with compression negative and p = -tr T / 3 > 0. Written from G. Gudehus, Soils Found. 36 (1996) 1-12 and
E. Bauer, Soils Found. 36 (1996) 13-26, with h_i and the sign of cos 3 theta derived anew (docs: see README).
"""

import math

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.lane_maths import alike, exp_plus, greatest, larger, power, smaller
from taichi_silo.mpm.tensors import added, chosen, inner, largest_principal, pressure_of, scaled, shifted, trace_of_cube

SQRT6 = math.sqrt(6.0)


ROOMY = 0.4  # density factor f_d from which sand is far from as dense as it can be


@frozen
class GudehusBauer:
    """Karlsruhe sand of the paper unless told otherwise.

    The law is calibrated for 1 to 1000 kPa. Below `rest_stress` the grains count as separated: the stress is put to
    that small isotropic pressure, from which the sand loads again once it is compacted.
    """

    critical_friction_angle_deg: float = 30.0
    granular_hardness_Pa: float = 190e6
    n: float = 0.5
    alpha: float = 0.3
    beta: float = 1.0
    e_i0: float = 1.30
    e_c0: float = 0.82
    e_d0: float = 0.51
    grain_density: float = 2650.0
    rest_stress: float = 1.0

    REMEMBERS = False

    @property
    def loosest(self) -> float:
        """Limit of the void ratio without stress."""
        return self.e_i0

    @property
    def degree(self) -> float:
        """Of the rate as a homogeneous function of the stress, in the limit of small stress."""
        return 1.0 - self.n

    @property
    def c1(self) -> float:
        """Shape of the critical surface in triaxial compression."""
        s = math.sin(math.radians(self.critical_friction_angle_deg))
        return math.sqrt(3.0 / 8.0) * (3.0 - s) / s

    @property
    def c2(self) -> float:
        """Shape of the critical surface away from triaxial compression."""
        s = math.sin(math.radians(self.critical_friction_angle_deg))
        return 3.0 / 8.0 * (3.0 + s) / s

    @property
    def h_i(self) -> float:
        """Makes isotropic compression from e_i follow e_i0 exp[-(3p/h_s)^n] exactly."""
        ratio = (self.e_i0 - self.e_d0) / (self.e_c0 - self.e_d0)
        return 1.0 / self.c1**2 + 1.0 / 3.0 - ratio**self.alpha / (self.c1 * math.sqrt(3.0))

    def void_ratio_limits(self, pressure_Pa: float) -> tuple[float, float, float]:
        """(e_d, e_c, e_i) at mean stress p: densest, critical and loosest void ratio (Python scope)."""
        shrink = math.exp(-((3.0 * pressure_Pa / self.granular_hardness_Pa) ** self.n))
        return self.e_d0 * shrink, self.e_c0 * shrink, self.e_i0 * shrink

    @ti.func
    def density(self, stress, void_ratio):
        """How dense the sand is at its pressure: p [Pa], x = (3p/h_s)^n, exp(x), e exp(x), (e - e_d) / (e_c - e_d).

        The void ratio counts as at most e_i, so that e exp(x), which it would be without pressure, is at most e_i0.
        """
        pressure = pressure_of(stress)
        pressure = larger(pressure, self.rest_stress)
        crowding = power(pressure * (3.0 / self.granular_hardness_Pa), self.n)
        spread = exp_plus(crowding)
        e = smaller(void_ratio * spread, self.e_i0)
        above = larger(e - self.e_d0, 0.0) * (1.0 / (self.e_c0 - self.e_d0))
        return pressure, crowding, spread, e, above

    @ti.func
    def factors(self, stress, void_ratio):
        """What the rate is made of at a stress and a void ratio, and its tangents there.

        Barotropy f_s [Pa], pyknotropy f_d, 1 / tr T [1/Pa]; the derivatives of ln f_s by ln p and by -e, of f_d by e
        and by ln p; then what `a1_and_tangent` gives. Divisions cost more than all the rest: three share one.
        """
        pressure, crowding, spread, e, above = self.density(stress, void_ratio)
        per_pressure, some = 1.0 / pressure, larger(above, 1e-6)
        by_some = e * some
        share = 1.0 / (crowding * by_some)
        per_crowding, per_e, per_above = share * by_some, share * (crowding * some), share * (crowding * e)
        f_d = power(above, self.alpha, (self.e_i0 - self.e_d0) / (self.e_c0 - self.e_d0))
        # h_s/n (3p/h_s)^(1-n) = 3p / (n (3p/h_s)^n);  (1 + e_i) / e_i = 1 + 1 / e_i
        f_s = (3.0 / (self.n * self.h_i)) * pressure * per_crowding * power(self.e_i0 * per_e, self.beta)
        f_s = f_s * (1.0 + spread * (1.0 / self.e_i0))
        fading = self.n * crowding  # -d ln e_d, e_c, e_i / d ln p
        stiffening = self.degree - fading * (self.beta - 1.0 / (1.0 + self.e_i0))  # d ln f_s / d ln p
        softening = self.beta * per_e * spread  # -d ln f_s / d e
        loosening = (self.alpha / (self.e_c0 - self.e_d0)) * f_d * per_above
        per_trace = per_pressure * (-1.0 / 3.0)
        T = scaled(stress, per_trace)
        a1, g0, g1, g2, g3 = self.a1_and_tangent(shifted(T, pressure_of(T)))
        return (
            f_s, f_d, per_trace, stiffening, softening, loosening * spread, loosening * e * fading,
            a1, g0, g1, g2, g3,
        )  # fmt: skip

    @ti.func
    def advanced_factors(self, factors, growth_of_trace, swelling):
        """The factors after small changes of tr T [Pa] and of the void ratio."""
        f_s, f_d, per_trace, stiffening, softening, loosening, crowding, a1, g0, g1, g2, g3 = factors
        rise = growth_of_trace * per_trace
        rise = larger(smaller(rise, 0.1), -0.1)
        stiffer = f_s * (1.0 + stiffening * rise - softening * swelling)
        looser = larger(f_d + (loosening * swelling + crowding * rise), 0.0)
        square = rise * rise
        return (
            stiffer, looser, per_trace * ((1.0 - rise) * (1.0 + square * (1.0 + square))),
            stiffening, softening, loosening, crowding, a1, g0, g1, g2, g3,
        )  # fmt: skip

    @ti.func
    def a1_and_tangent(self, deviator):
        """a1 of a normalised deviator T^*, and the four components of G.

        The tangent of 1/a1 = c1 + c2 ||T^*|| (1 + cos 3 theta) is c1 + G : T^*. With r = ||T^*||, less its isotropic
        part, G = c2 [(1/r + 2 sqrt(6) tr T^*^3 / r^4) T^* - 3 sqrt(6) T^*^2 / r^2].
        """
        s0, s1, s2, s3 = deviator
        square = inner(deviator, deviator) + 1e-24
        size, per_square = ti.sqrt(square), 1.0 / square
        shape = SQRT6 * trace_of_cube(deviator) * per_square
        # ||T^*|| (1 + cos 3 theta), with cos 3 theta between -1 and 1
        round = smaller(larger(size - shape, 0.0), 2.0 * size)
        along, across = self.c2 * (size + 2.0 * shape) * per_square, (3.0 * SQRT6 * self.c2) * per_square
        per_a1, turn = self.c1 + self.c2 * round, s3 * s3
        slope = (
            along * s0 - across * (s0 * s0 + turn), along * s1 - across * (s1 * s1 + turn),
            along * s2 - across * (s2 * s2), s3 * (along - across * (s0 + s1)),
        )  # fmt: skip
        return 1.0 / per_a1, slope[0], slope[1], slope[2], slope[3]

    @ti.func
    def operators(self, stress, factors):
        """What the rate is made of: f_s a1^2, f_s [Pa], T^ and N = f_s f_d a1 (T^ + T^*) [Pa].

        The linear operator is L : X = f_s (a1^2 X + T^ (T^ : X)).
        """
        f_s, f_d, per_trace, _, _, _, _, a1, g0, g1, g2, g3 = factors
        relative = scaled(stress, per_trace)
        deviator = shifted(relative, pressure_of(relative))
        a1 = a1 * (2.0 - a1 * (self.c1 + inner((g0, g1, g2, g3), deviator)))  # 1 over the tangent, by Newton's rule
        return f_s * a1 * a1, f_s, relative, scaled(added(relative, deviator, 1.0), f_s * f_d * a1)

    @ti.func
    def rate(self, stress, h, factors, D, d_bar):
        """Jaumann stress rate [Pa/s]: L : D + N d_bar."""
        isotropic, f_s, relative, N = self.operators(stress, factors)
        return added(added(scaled(D, isotropic), relative, f_s * inner(relative, D)), N, d_bar)

    @ti.func
    def admissible(self, stress, void_ratio):
        """No tension in any direction, and separated grains (p below rest stress, or e above e_i0) at rest stress."""
        s0, s1, s2, s3 = stress
        pressure = pressure_of(stress)
        separated = larger(self.rest_stress - pressure, void_ratio - self.e_i0)
        # compression in all directions: xx < 0, zz < 0 and xx yy > xy^2
        if greatest(larger(larger(s0, s2), larger(s3 * s3 - s0 * s1, separated))) > 0.0:
            pull = largest_principal(stress)
            # the deviator shrinks until the largest principal stress is zero
            fraction = ti.select(pull > 0.0, pressure / (pressure + ti.max(pull, 1e-30)), 1.0)
            zero = 0.0 * pressure
            drawn = shifted(scaled(shifted(stress, pressure), fraction), 0.0 - pressure)
            resting = shifted((zero, zero, zero, zero), zero - self.rest_stress)
            s0, s1, s2, s3 = chosen(separated > 0.0, resting, drawn)
        return s0, s1, s2, s3

    @ti.func
    def room(self, stress, void_ratio):
        """How far sand is from being as dense as it can be under its pressure: f_d / ROOMY, at most 1."""
        _, _, _, _, above = self.density(stress, void_ratio)
        limit = ROOMY ** (1.0 / self.alpha)
        found = alike(1.0, above)
        if greatest(limit - above) > 0.0:
            found = power(smaller(above * (1.0 / limit), 1.0), self.alpha, 1.0)
        return found

    @ti.func
    def stiffness(self, stress, void_ratio):
        """Upper bound of the modulus of a plane wave [Pa].

        For D = sym(n m) the traction rate is at most f_s (a1^2 + t^2 + f_d a1 (2 t - 1/3)), t the largest
        principal value of T^; in an isotropic state this is the unloading modulus exactly.
        """
        linear, nonlinear = self.moduli(stress, void_ratio)
        return linear + nonlinear

    @ti.func
    def moduli(self, stress, void_ratio):
        """The two parts of `stiffness` [Pa]: of L and of N."""
        f_s, f_d, per_trace, _, _, _, _, a1, _, _, _, _ = self.factors(stress, void_ratio)
        relative = scaled(stress, per_trace)
        largest = ti.min(largest_principal(relative), 1.0)
        return f_s * (a1 * a1 + largest * largest), f_s * f_d * a1 * (2.0 * largest - 1.0 / 3.0)

    def rest_pressure_ratio(self, void_ratio: float, stress_Pa: float = 3e3) -> float:
        """K0 = sigma_h / sigma_v that one-dimensional compression tends to at this void ratio (Python scope).

        The proportional path of hypoplasticity: T_obj parallel to T under uniaxial compression; found by bisection on
        the direction of the rate.
        """

        def drift(k0: float) -> float:
            vertical, side = -stress_Pa, -k0 * stress_Pa
            tr = vertical + 2.0 * side
            t_v, t_h = vertical / tr, side / tr
            s_v, s_h = t_v - 1.0 / 3.0, t_h - 1.0 / 3.0
            size = math.sqrt(s_v**2 + 2.0 * s_h**2)
            cos_3theta = 0.0 if size == 0.0 else -SQRT6 * (s_v**3 + 2.0 * s_h**3) / size**3
            a1 = 1.0 / (self.c1 + self.c2 * size * (1.0 + cos_3theta))
            e_d, e_c, _ = self.void_ratio_limits(-tr / 3.0)
            f_d = (max(void_ratio - e_d, 0.0) / (e_c - e_d)) ** self.alpha
            rate_v = -(a1**2) - t_v * t_v + f_d * a1 * (t_v + s_v)
            rate_h = -t_h * t_v + f_d * a1 * (t_h + s_h)
            return rate_h / rate_v - k0

        low, high = 1e-3, 1.0
        for _ in range(100):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if drift(middle) > 0.0 else (low, middle)
        return 0.5 * (low + high)

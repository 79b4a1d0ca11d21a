"""Intergranular strain (Niemunis and Herle 1997) around a hypoplastic skeleton.

A sand that is turned back is stiff at first: the tensor h, of size at most R, remembers the direction of the last
strain. With rho = |h| / R, h^ = h / |h| and the skeleton's operators L and N,

    T_obj = [rho^chi m_T + (1 - rho^chi) m_R] L : D + rho^chi (1 - m_T) (L : h^) (h^ : D) + rho^chi N (h^ : D)
    h_obj = D - h^ (h^ : D) rho^beta_r                                                          while h^ : D > 0,

    T_obj = [rho^chi m_T + (1 - rho^chi) m_R] L : D + rho^chi (m_R - m_T) (L : h^) (h^ : D)
    h_obj = D                                                                                    otherwise.

With rho = 1 and D along h this is the skeleton itself; without h, or on reversal, it is m_R L : D.
Source: A. Niemunis, I. Herle, Mech. Cohes.-Frict. Mater. 2 (1997) 279-299.
"""

from dataclasses import field

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws.gudehus_bauer import GudehusBauer
from taichi_silo.mpm.simd.lane_maths import power
from taichi_silo.mpm.tensors import added, inner, norm, scaled


@frozen
class Intergranular:
    """A skeleton with memory; the defaults are the set that Niemunis and Herle give for Hochstetten sand.

    Parameters
    ----------
    skeleton : a law with `operators` and `moduli`.
    radius : R, the strain over which the sand forgets [-].
    m_R, m_T : factors of stiffness on reversal and on a turn by a right angle.
    beta_r, chi : exponents of the growth of h and of the return of stiffness.

    """

    skeleton: GudehusBauer = field(default_factory=GudehusBauer)
    radius: float = 1e-4
    m_R: float = 5.0
    m_T: float = 2.0
    beta_r: float = 0.5
    chi: float = 6.0

    REMEMBERS = True

    def __post_init__(self) -> None:
        for name, value, least in (("R", self.radius, 0.0), ("beta_r", self.beta_r, 0.0), ("chi", self.chi, 0.0)):
            if not value > least:
                raise ValueError(f"{name} of the intergranular strain is {value}; it must be above {least:g}")
        if not 1.0 <= self.m_T <= self.m_R:
            raise ValueError(f"m_T and m_R are {self.m_T} and {self.m_R}; 1 <= m_T <= m_R must hold")

    @property
    def grain_density(self) -> float:
        """Of the skeleton [kg/m3]."""
        return self.skeleton.grain_density

    @property
    def loosest(self) -> float:
        """Of the skeleton."""
        return self.skeleton.loosest

    @property
    def rest_stress(self) -> float:
        """Of the skeleton [Pa]."""
        return self.skeleton.rest_stress

    @property
    def degree(self) -> float:
        """Of the skeleton."""
        return self.skeleton.degree

    def rest_pressure_ratio(self, void_ratio: float) -> float:
        """Of the skeleton: compression that goes on leaves nothing of what was before it."""
        return self.skeleton.rest_pressure_ratio(void_ratio)

    def void_ratio_limits(self, pressure_Pa: float) -> tuple[float, float, float]:
        """(e_d, e_c, e_i) of the skeleton at mean stress p."""
        return self.skeleton.void_ratio_limits(pressure_Pa)

    @ti.func
    def direction(self, h):
        """(rho, h^): how much of R is used, and in which direction."""
        size = norm(h)
        return ti.min(size / self.radius, 1.0), scaled(h, 1.0 / (size + 1e-30))

    @ti.func
    def factors(self, stress, void_ratio):
        """Of the skeleton."""
        return self.skeleton.factors(stress, void_ratio)

    @ti.func
    def advanced_factors(self, factors, growth_of_trace, swelling):
        """As the skeleton says."""
        return self.skeleton.advanced_factors(factors, growth_of_trace, swelling)

    @ti.func
    def rate(self, stress, h, factors, D, d_bar):
        """Jaumann stress rate [Pa/s]; a non-local d_bar enters N in the proportion d_bar / ||D||."""
        isotropic, f_s, relative, N = self.skeleton.operators(stress, factors)
        rho, along_h = self.direction(h)
        mobilised = power(rho, self.chi)
        along = inner(along_h, D)
        forward, backward = ti.max(along, 0.0), ti.min(along, 0.0)
        # everything linear acts on one strain rate: L : (a D + b h^)
        a = mobilised * self.m_T + (1.0 - mobilised) * self.m_R
        b = mobilised * ((1.0 - self.m_T) * forward + (self.m_R - self.m_T) * backward)
        X = added(scaled(D, a), along_h, b)
        linear = added(scaled(X, isotropic), relative, f_s * inner(relative, X))
        return added(linear, N, mobilised * forward * d_bar / (norm(D) + 1e-300))

    @ti.func
    def memory_rate(self, h, D):
        """Jaumann rate of h [1/s]."""
        rho, along_h = self.direction(h)
        return added(D, along_h, 0.0 - ti.max(inner(along_h, D), 0.0) * power(rho, self.beta_r))

    @ti.func
    def bounded_memory(self, h):
        """The tensor h, pulled back to |h| <= R."""
        return scaled(h, ti.min(1.0, self.radius / (norm(h) + 1e-30)))

    @ti.func
    def admissible(self, stress, void_ratio):
        """As the skeleton says."""
        return self.skeleton.admissible(stress, void_ratio)

    @ti.func
    def room(self, stress, void_ratio):
        """That of the skeleton."""
        return self.skeleton.room(stress, void_ratio)

    @ti.func
    def stiffness(self, stress, void_ratio):
        """Upper bound of the modulus of a plane wave [Pa]: on reversal m_R times that of L.

        The terms along h raise it, by up to 1.07 for the usual constants and 1.19 for m_R = m_T = 1.5: found
        numerically.
        """
        linear, nonlinear = self.skeleton.moduli(stress, void_ratio)
        return ti.max(1.2 * self.m_R * linear, linear + nonlinear)

"""Isotropic linear elasticity in rate form: the yardstick of the solver's own tests."""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.tensors import added, shifted, trace


@frozen
class Elastic:
    """Hooke's law for the Jaumann rate: lambda tr(D) I + 2 G D."""

    young_modulus_Pa: float
    poisson_ratio: float = 0.0
    grain_density: float = 2650.0
    rest_stress: float = 0.0

    loosest: float = 1e30

    REMEMBERS = FORGETS = False
    degree = 0.0

    @property
    def lame(self) -> float:
        """Lame's first constant [Pa]."""
        nu = self.poisson_ratio
        return self.young_modulus_Pa * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))

    @property
    def shear_modulus(self) -> float:
        """Shear modulus [Pa]."""
        return 0.5 * self.young_modulus_Pa / (1.0 + self.poisson_ratio)

    def rest_pressure_ratio(self, void_ratio: float) -> float:
        """K0 = nu / (1 - nu) of one-dimensional compression."""
        return self.poisson_ratio / (1.0 - self.poisson_ratio)

    @ti.func
    def factors(self, stress, void_ratio):
        """None."""
        return (0.0 * void_ratio,)

    @ti.func
    def advanced_factors(self, factors, growth_of_trace, swelling):
        """The same."""
        return factors

    @ti.func
    def rate(self, stress, h, factors, D, d_bar):
        """Jaumann stress rate [Pa/s]."""
        zero = 0.0 * d_bar
        spherical = shifted((zero, zero, zero, zero), self.lame * trace(D))
        return added(spherical, D, 2.0 * self.shear_modulus)

    @ti.func
    def admissible(self, stress, void_ratio):
        """Every stress is."""
        return stress

    @ti.func
    def stiffness(self, stress, void_ratio):
        """Constrained modulus [Pa]."""
        return 0.0 * void_ratio + self.lame + 2.0 * self.shear_modulus

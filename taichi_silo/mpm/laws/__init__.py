"""Constitutive laws.

The contract of a law, a frozen dataclass (so that equal laws share one compiled kernel):

`factors(stress, void_ratio)`
    what changes slowly with the state and is dear to compute: exponentials, powers.
`advanced_factors(factors, growth_of_trace, swelling)`
    those after small changes of tr T [Pa] and of the void ratio, without computing them anew.
`rate(stress, h, factors, D, d_bar)`
    Jaumann stress rate [Pa/s] of a stress (xx, yy, zz, xy) [Pa, tension positive] under the strain rate D [1/s];
    `d_bar` is the norm of the strain rate that a non-local law averages, ||D|| for a local one.
`admissible(stress, void_ratio)`
    the stress pulled back to what the material can carry.
`stiffness(stress, void_ratio)`
    an upper bound of the modulus of a plane wave [Pa]: sets the time step.
`rest_stress`
    the isotropic pressure [Pa] that unloaded material starts from (0 if it may be free of stress).
`degree`
    degree of the rate as a homogeneous function of the stress (0 where it does not depend on it).
`rest_pressure_ratio(void_ratio)`
    K0, horizontal over vertical stress, that one-dimensional compression tends to (Python scope).
`grain_density`
    [kg/m3].
`loosest`
    the greatest void ratio that a point is given; sand that separates further keeps it.
`room(stress, void_ratio)`
    from 0, as dense as it can be, to 1: the share of its work that the patch filter does (ti.func); 1, if absent.
`REMEMBERS`
    whether the points carry a tensor h of past strain for it. If so, also `radius` (the bound of |h|),
    `memory_rate(h, D)`, its Jaumann rate, and `bounded_memory(h)`, h pulled back to its bound.
`FORGETS`
    whether sheared sand loses the memory of its stress, so that the patch filter is of use; yes, if absent.

`integrate.update` drives any of them over a step; `on_arrays.law_on_arrays` runs the same text on NumPy arrays. A new
law is one file with these members.
"""

from taichi_silo.mpm.laws.elastic import Elastic
from taichi_silo.mpm.laws.gudehus_bauer import GudehusBauer
from taichi_silo.mpm.laws.intergranular import Intergranular

__all__ = ["Elastic", "GudehusBauer", "Intergranular"]

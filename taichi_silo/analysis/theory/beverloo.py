"""Rate at which grains leave an orifice or a slot by gravity.

An orifice of diameter D:   W = C rho sqrt(g) (D - k d)^(5/2)      [kg/s],                  C = 0.58
A slot of width b:          W = C_s rho sqrt(g) (b - k d)^(3/2)    [kg/s per metre of slot], C_s = 1.03

rho is the bulk density, d the size of the grains; none passes an opening of k d, k = 1.4. The rate does not depend on
the depth of the fill, which holds when the fill is deeper and wider than a few openings and the opening spans some six
grains.

C is measured, and lies between 0.55 and 0.65 with the kind of grains. A slot has fewer measurements: grains that fall
freely from a half circle over it give C_s = 0.87; an opening that counts by its area and hydraulic diameter alone gives
C_s = (4 sqrt(2) / pi) C, 0.99 to 1.17; the value commonly quoted is 1.03. A slot in plane strain has no walls at its
ends, and so no k d there.

Source: W. A. Beverloo, H. A. Leniger, J. van de Velde, Chem. Eng. Sci. 15 (1961) 260-269 for the orifice; the source of
1.03 is not confirmed.
"""

import math

ORIFICE, SLOT = 0.58, 1.03  # C, C_s
EMPTY = 1.4  # k


def orifice_rate_kg_per_s(
    diameter_m: float, bulk_density_kg_per_m3: float, grain_size_m: float = 0.0, gravity_m_per_s2: float = 9.81
) -> float:
    """Rate W = C rho sqrt(g) (D - k d)^(5/2) through a round orifice; 0 when D is not above k d."""
    free = max(diameter_m - EMPTY * grain_size_m, 0.0)
    return ORIFICE * bulk_density_kg_per_m3 * math.sqrt(gravity_m_per_s2) * free**2.5


def slot_rate_kg_per_s_m(
    width_m: float, bulk_density_kg_per_m3: float, grain_size_m: float = 0.0, gravity_m_per_s2: float = 9.81
) -> float:
    """Rate W = C_s rho sqrt(g) (b - k d)^(3/2) per metre of a slot; 0 when b is not above k d."""
    free = max(width_m - EMPTY * grain_size_m, 0.0)
    return SLOT * bulk_density_kg_per_m3 * math.sqrt(gravity_m_per_s2) * free**1.5

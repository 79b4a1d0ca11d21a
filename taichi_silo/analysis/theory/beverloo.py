"""Rate at which grains leave an orifice or a slot by gravity.

An orifice of diameter D:   W = C rho sqrt(g) (D - k d)^(5/2)      [kg/s]
A slot of width b:          W = C_s rho sqrt(g) (b - k d)^(3/2)    [kg/s per metre of slot]

rho is the bulk density, d the size of the grains; none passes an opening of k d. The rate does not depend on the depth
of the fill, which holds when the fill is deeper and wider than a few openings and the opening spans some six grains.

The order of C follows from free fall: let the grains rest on a half circle (or half sphere) that spans the opening, and
fall freely from there. They cross the opening at a distance r from its middle with v = sqrt(2 g sqrt(R^2 - r^2)), so

    orifice: W / rho = int_0^R 2 pi r v dr = (pi / 5) sqrt(g) D^(5/2),                   pi / 5 = 0.628
    slot:    W / rho = int_-R^R v dr = B(1/2, 5/4) / 2 sqrt(g) b^(3/2),   B(1/2, 5/4) / 2 = 0.874

C = 0.58 is measured, and 0.55 to 0.65 with the kind of grains. A slot has fewer measurements. When an opening counts by
its area A and its hydraulic diameter D_h (four areas over the perimeter; D of an orifice, 2 b of a slot) alone, so that
W = c rho A sqrt(g D_h), then C_s = (4 sqrt(2) / pi) C = 1.80 C: 1.04 for C = 0.58, and 0.99 to 1.17. The value commonly
quoted for a slot is 1.03, the default here; 0.87, of the free fall, to 1.17 is its range. A slot in plane strain, whose
ends have no walls, needs no k d at its ends.

Source: W. A. Beverloo, H. A. Leniger, J. van de Velde, Chem. Eng. Sci. 15 (1961) 260-269 for the orifice; the slot is
derived here, and the source of 1.03 is not confirmed.
"""

import numpy as np

ORIFICE, ORIFICE_RANGE = 0.58, (0.55, 0.65)  # C
SLOT, SLOT_RANGE = 1.03, (0.87, 1.17)  # C_s
EMPTY, EMPTY_RANGE = 1.4, (1.0, 2.0)  # k
FREE_FALL_ORIFICE, FREE_FALL_SLOT = np.pi / 5.0, 0.8740191847640399  # B(1/2, 5/4) / 2


def _rate(opening, density, grain, coefficient, k, gravity, power):
    for name, value in (
        ("bulk_density_kg_per_m3", density),
        ("coefficient", coefficient),
        ("gravity_m_per_s2", gravity),
    ):
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name} must be positive and finite, got {value}")
    if not 0.0 <= grain < np.inf:
        raise ValueError(f"grain_size_m must be 0 or more, got {grain}")
    if not EMPTY_RANGE[0] <= k <= EMPTY_RANGE[1]:
        raise ValueError(f"k must be in [{EMPTY_RANGE[0]}, {EMPTY_RANGE[1]}], got {k}")
    opening = np.asarray(opening, dtype=float)
    if not np.all((opening >= 0.0) & (opening < np.inf)):
        raise ValueError(f"the opening must be 0 or more, got {opening}")
    rate = coefficient * density * np.sqrt(gravity) * np.maximum(opening - k * grain, 0.0) ** power
    return rate if rate.ndim else float(rate)


def orifice_rate_kg_per_s(
    diameter_m, bulk_density_kg_per_m3, grain_size_m=0.0, coefficient=ORIFICE, k=EMPTY, gravity_m_per_s2=9.81
):
    """Rate W = C rho sqrt(g) (D - k d)^(5/2) through a round orifice (number or array); 0 when D is not above k d."""
    return _rate(diameter_m, bulk_density_kg_per_m3, grain_size_m, coefficient, k, gravity_m_per_s2, 2.5)


def slot_rate_kg_per_s_m(
    width_m, bulk_density_kg_per_m3, grain_size_m=0.0, coefficient=SLOT, k=EMPTY, gravity_m_per_s2=9.81
):
    """Rate W = C_s rho sqrt(g) (b - k d)^(3/2) per metre of a slot (number or array); 0 when b is not above k d."""
    return _rate(width_m, bulk_density_kg_per_m3, grain_size_m, coefficient, k, gravity_m_per_s2, 1.5)


def orifice_bounds_kg_per_s(diameter_m, bulk_density_kg_per_m3, grain_size_m=0.0, gravity_m_per_s2=9.81):
    """Least and largest rate through an orifice over the ranges of C and k."""
    return tuple(
        orifice_rate_kg_per_s(diameter_m, bulk_density_kg_per_m3, grain_size_m, c, k, gravity_m_per_s2)
        for c, k in zip(ORIFICE_RANGE, reversed(EMPTY_RANGE), strict=True)
    )


def slot_bounds_kg_per_s_m(width_m, bulk_density_kg_per_m3, grain_size_m=0.0, gravity_m_per_s2=9.81):
    """Least and largest rate per metre of a slot over the ranges of C_s and k."""
    return tuple(
        slot_rate_kg_per_s_m(width_m, bulk_density_kg_per_m3, grain_size_m, c, k, gravity_m_per_s2)
        for c, k in zip(SLOT_RANGE, reversed(EMPTY_RANGE), strict=True)
    )

"""Units at the ends of names: a value whose name ends in another unit than a known one, under the known name."""

from collections.abc import Iterable

FACTORS = {  # ending of a known name: endings of the same quantity, with their factors to it
    "m": {"mm": 1e-3, "cm": 1e-2, "dm": 0.1, "um": 1e-6, "ft": 0.3048, "in": 0.0254},
    "Pa": {"kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "kN_per_m2": 1e3, "kN_m2": 1e3, "MN_per_m2": 1e6, "MN_m2": 1e6,
           "bar": 1e5, "psi": 6894.757293168},
    "kg_per_m3": {"kg_m3": 1.0, "g_per_cm3": 1e3, "g_cm3": 1e3, "t_per_m3": 1e3, "t_m3": 1e3},
    "N_per_m3": {"N_m3": 1.0, "kN_per_m3": 1e3, "kN_m3": 1e3},
    "m_per_s": {"m_s": 1.0, "mm_per_s": 1e-3, "mm_s": 1e-3, "cm_per_s": 1e-2, "cm_s": 1e-2, "mm_per_min": 1e-3 / 60.0},
    "m_per_s2": {"m_s2": 1.0},
    "s": {"ms": 1e-3, "min": 60.0, "h": 3600.0},
    "deg": {"rad": 57.29577951308232, "degrees": 1.0, "grad": 1.0},
}  # fmt: skip


def in_known_unit(name: str, value: object, known: Iterable[str]) -> str:
    """NAME = VALUE in the unit of the known name that a name is but for its unit; empty if it is none.

    >>> in_known_unit("width_mm", 200, ["height_m", "width_m"])
    'width_m = 0.2'
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    for one in known:
        for ending, others in FACTORS.items():
            for other, factor in others.items() if one.endswith(f"_{ending}") else ():
                if name.casefold() == f"{one.removesuffix(ending)}{other}".casefold():
                    return f"{one} = {factor * value:.12g}"
    return ""

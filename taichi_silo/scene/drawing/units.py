"""The unit of a drawing: as given, or as its header says, by the table of ezdxf."""

from typing import Any

from taichi_silo.errors import BadInput
from taichi_silo.scene.drawing.dxf_file import UNIT
from taichi_silo.utils.messages import near, shown

FOOT_M, SURVEY_FOOT_M = 0.3048, 1200.0 / 3937.0
EXACT = {  # of codes that the library rounds or leaves out [m]
    1: FOOT_M / 12, 2: FOOT_M, 3: 5280 * FOOT_M, 8: FOOT_M / 12e6, 9: FOOT_M / 12e3, 10: 3 * FOOT_M,
    21: SURVEY_FOOT_M, 22: SURVEY_FOOT_M / 12, 23: 3 * SURVEY_FOOT_M, 24: 5280 * SURVEY_FOOT_M,
}  # fmt: skip
SURVEY = {21: "survey-ft", 22: "survey-in", 23: "survey-yd", 24: "survey-mi"}
COMMON = ("mm", "cm", "m", "in", "ft")  # named first, where one must be given
INCH = 1  # of $INSUNITS
OFFERED_M = (1e-3, 1.0)  # from the smallest to the largest unit that is named where one is asked for
WIDTHS_M = (0.01, 100.0)  # of silos that are built, models included
HEIGHTS_M = (0.01, 200.0)


def units() -> dict[str, float]:
    """Metres in each unit, by the name that is given on the command line."""
    from ezdxf import units as known

    found = {}
    for code, factor in enumerate(known.METER_FACTOR):
        metres = EXACT.get(code) or (1.0 / factor if factor else None)
        name = SURVEY.get(code) or (known.decode(code) if metres else None)
        if name and metres:
            found[_plain(name)] = metres
    return {name: found[name] for name in COMMON} | found


def offered() -> list[str]:
    """Names of the units in which silos are drawn, of all that a header can name."""
    smallest, largest = OFFERED_M
    return [name for name, metres in units().items() if smallest <= metres <= largest]


def of_name(unit: str) -> str:
    """The unit of a name or word: "mm", "MM" and "millimeters" are the same.

    Raises BadInput if there is none.
    """
    from ezdxf.enums import InsertUnits

    words = {one.name.lower(): name for one in InsertUnits if (name := of_code(one.value))}
    words |= {"inch": "in", "foot": "ft", "millimetres": "mm", "centimetres": "cm", "metres": "m", "decimetres": "dm"}
    words |= {name.lower(): name for name in units()}
    word = _plain(unit.strip().lower())
    if word in words:
        return words[word]
    meant = near(word, [one for one, name in words.items() if name in offered()])
    raise BadInput(
        f"unit is {shown(unit)}; it must be one of {', '.join(offered())}{f'; did you mean {meant}?' if meant else ''}"
    )


def of_code(code: Any) -> str | None:
    """The unit of a header's $INSUNITS; None if it names none."""
    from ezdxf import units as known

    try:
        name = SURVEY.get(int(code)) or known.decode(int(code))
    except (IndexError, TypeError, ValueError):
        return None
    return _plain(name) if name and _plain(name) in units() else None


def _plain(name: str) -> str:
    """A unit's name as any keyboard has it."""
    return name.replace("µ", "u").replace("Å", "angstrom")


def of_drawing(header: Any, given: str | None, extent: tuple[float, float]) -> tuple[str, str]:
    """Unit of a drawing, and how it is known.

    Raises BadInput if it is neither given nor said.

    Parameters
    ----------
    header : of the drawing.
    given : name of a unit, if one is.
    extent : width and height of its lines, in its unit.

    """
    if given is not None:
        return of_name(given), "as given"
    found = of_code(header.get(UNIT))
    if found is None:
        metres, wide, high = units(), *extent
        sizes = "; ".join(f"{name}: {metres[name] * wide:.3g} m x {metres[name] * high:.3g} m" for name in COMMON)
        raise BadInput(
            f"unit is not given and the drawing says none; give --unit {', '.join(COMMON)} (its lines span {sizes}), "
            f"or another one: {', '.join(offered()[len(COMMON) :])}"
        )
    return found, "as the drawing says"


def plausible(width_m: float, height_m: float) -> bool:
    """Whether a silo may be as large."""
    return WIDTHS_M[0] <= width_m <= WIDTHS_M[1] and HEIGHTS_M[0] <= height_m <= HEIGHTS_M[1]


def possible(extent_m: float) -> bool:
    """Whether a drawing of a silo, with all that stands beside it, may be as large."""
    return HEIGHTS_M[0] <= extent_m <= 5.0 * HEIGHTS_M[1]


def too_large_or_small(unit: str, width_m: float, height_m: float) -> str:
    """What is said of lines that span more, or less, than a silo and all that may stand beside it."""
    others = _others(_sizes(unit, width_m, height_m))
    words = f"lines that span {width_m:.4g} m x {height_m:.4g} m are implausible{others}"
    large = max(width_m, height_m) > HEIGHTS_M[1]
    return f"{words}; delete what lies far from the silo, or leave it out with --layer" if large else words


def _sizes(unit: str, width_m: float, height_m: float) -> dict[str, tuple[float, float]]:
    """Width and height [m] if the unit were another one."""
    metres = units()
    return {name: (metres[name] / metres[unit] * width_m, metres[name] / metres[unit] * height_m) for name in COMMON}


def _others(sizes: dict[str, tuple[float, float]]) -> str:
    """Units that make a plausible silo, as the end of a sentence."""
    return "".join(f"; --unit {name} makes {wide:.3g} m x {high:.3g} m" for name, (wide, high) in sizes.items()
                   if plausible(wide, high))  # fmt: skip


def doubts(header: Any, unit: str, width_m: float, height_m: float) -> str:
    """A sentence on a unit that a drawing may not mean, with what another one would make of it; empty if none is."""
    sizes = _sizes(unit, width_m, height_m)
    if plausible(width_m, height_m):
        if header.get(UNIT) != INCH or unit != "in":
            return ""
        return (
            "The drawing says inches, which many programs write unasked: in millimetres (--unit mm) it would be "
            f"{sizes['mm'][0]:.4g} m x {sizes['mm'][1]:.4g} m"
        )
    return f"a silo {width_m:.4g} m wide and {height_m:.4g} m high is implausible{_others(sizes)}"

"""Laws and contacts of users: what they must have, checked when they are registered, and where they are kept."""

import functools
import math
from collections.abc import Mapping
from types import FunctionType
from typing import Any

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.mpm.formula_rules import CONSTANT, NUMBER, TUPLE, Formula
from taichi_silo.mpm.frozen import HIDDEN
from taichi_silo.mpm.language import of_kernels
from taichi_silo.mpm.laws.on_arrays import law_on_arrays

LAWS: dict[str, type] = {}  # by the names that `sand.law` may have
CONTACTS: dict[str, type] = {}  # by the names that `walls.kind` may have

STATE = {"stress": TUPLE, "void_ratio": NUMBER}
OF_A_LAW = {  # formula: kinds of its parameters, and of its result
    "factors": (STATE, TUPLE),
    "advanced_factors": ({"factors": TUPLE, "growth_of_trace": NUMBER, "swelling": NUMBER}, TUPLE),
    "rate": ({"stress": TUPLE, "h": TUPLE, "factors": TUPLE, "D": TUPLE, "d_bar": NUMBER}, TUPLE),
    "admissible": (STATE, TUPLE),
    "stiffness": (STATE, NUMBER),
}
OF_A_MEMORY = {"memory_rate": ({"h": TUPLE, "D": TUPLE}, TUPLE), "bounded_memory": ({"h": TUPLE}, TUPLE)}
OF_A_CONTACT = {"touch": ({"relative": TUPLE, "normal": TUPLE}, TUPLE)}
WITH_FRICTION = {"slow": ({"relative": TUPLE, "normal": TUPLE, "along": NUMBER, "friction": NUMBER}, TUPLE)}
NUMBERS_OF_A_LAW = ("grain_density", "rest_stress", "degree", "loosest", "REMEMBERS")
PRESSURES_Pa, FRICTION, VOID_RATIOS = (1e2, 1e4, 1e5), (0.0, 0.25, 0.5), (0.6, 0.8)  # states that are tried
DIRECTIONS = 24  # of waves
CLOSE = 1e-6  # of two numbers that must be one


def check_law(law: type) -> None:
    """Check the members and the formulas of a law.

    Raises
    ------
    BadInput
        with the first that is missing, or breaks a rule.

    """
    _frozen(law)
    lacking = [name for name in (*NUMBERS_OF_A_LAW, "rest_pressure_ratio") if not _has(law, name)]
    if lacking:
        raise BadInput(f"{law.__name__} has no {lacking[0]}; a law must have {', '.join(NUMBERS_OF_A_LAW)}, "
                       "rest_pressure_ratio and its formulas")  # fmt: skip
    if "grain_density" not in getattr(law, HIDDEN):
        raise BadInput(f"{law.__name__}.grain_density is no constant; it must be one, which the sand gives")
    remembers = getattr(law, "REMEMBERS", False)
    if remembers and not _has(law, "radius"):
        raise BadInput(f"{law.__name__} has no radius; a law that remembers must have it, the bound of h")
    _formulas(law, OF_A_LAW | (OF_A_MEMORY if remembers else {}))
    if all(getattr(law, name, None) is not None for name in getattr(law, HIDDEN)):
        check_values(law, {})


def check_contact(contact: type) -> None:
    """Check the members and the formulas of a contact.

    Raises
    ------
    BadInput
        with the first that is missing, or breaks a rule.

    """
    _frozen(contact)
    _formulas(contact, OF_A_CONTACT | (WITH_FRICTION if _has(contact, "coefficient") else {}))


def made(kind: type, constants: Mapping[str, float], table: str, **given: float) -> Any:
    """A law or a contact with constants of a scene's table, and with `given` ones.

    Raises
    ------
    BadInput
        if a constant is unknown or missing, or the values are not possible.

    """
    known = [name for name in getattr(kind, HIDDEN) if name not in given]
    for name in constants:
        if name not in known:
            right = f"it has {', '.join(known)}" if known else "it has none"
            raise BadInput(f"{table}.{name} is no constant of {kind.__name__}; {right}")
    for name in known:
        if name not in constants and not hasattr(kind, name):
            raise BadInput(f"{table}.{name} is not given; {kind.__name__} needs it")
    try:
        return kind(**constants, **given)
    except (ArithmeticError, ValueError) as error:
        raise BadInput(f"{table}: {error}") from error


@functools.lru_cache(maxsize=64)
def check_constants(law: type, constants: tuple[tuple[str, float], ...]) -> None:
    """Check what the formulas of a law give with constants; see `check_values`."""
    check_values(law, dict(constants))


def check_values(law: type, constants: Mapping[str, float]) -> None:
    """Check what the formulas of a law give, over the states of usual sand.

    Raises
    ------
    BadInput
        if a stress rate is no number or depends on how the axes lie, or `stiffness` is no upper bound.

    """
    name, own = law.__name__, law_on_arrays(law)(**constants)
    ratio = float(law(**constants).rest_pressure_ratio(VOID_RATIOS[0]))
    if not 0.0 <= ratio <= 10.0:
        raise BadInput(f"{name}.rest_pressure_ratio is {ratio:g}; it must be K0, between 0 and 10")
    stress, e = _states()
    stress = own.admissible(stress, e)
    bound = np.asarray(own.stiffness(stress, e))
    if not (np.isfinite(bound).all() and (bound >= 0.0).all()):
        raise BadInput(f"{name}.stiffness is {bound.ravel()[0]:g} Pa; it must be a number from 0 on")
    for angle in np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        n = math.cos(angle), math.sin(angle)
        for m in ((n[0], n[1]), (-n[1], n[0])):
            D = tuple(component + 0.0 * e for component in _sym(n, m))
            rate = _rate(own, stress, e, D)
            if len(rate) != 4 or not all(np.isfinite(part).all() for part in rate):
                raise BadInput(f"{name}.rate gives no number for a usual stress; it must be four of them")
            turned = _rate(own, _quarter(stress), e, _quarter(D))
            size = 1e-300 + np.max(np.abs(rate), axis=0)
            if (np.abs(np.subtract(_quarter(rate), turned)) > CLOSE * size).any():
                raise BadInput(
                    f"{name}.rate is another one where the axes x and y are turned; it must not hang on them"
                )
            traction = np.hypot(rate[0] * n[0] + rate[3] * n[1], rate[3] * n[0] + rate[1] * n[1])
            if (traction > bound * (1.0 + CLOSE) + 1e-300).any():
                worst = int(np.argmax(traction / np.maximum(bound, 1e-300)))
                raise BadInput(
                    f"{name}.stiffness is {bound.ravel()[worst]:.4g} Pa where a plane wave meets "
                    f"{traction.ravel()[worst]:.4g} Pa; it must be an upper bound, as it sets the time step"
                )


def _frozen(kind: type) -> None:
    if HIDDEN not in vars(kind):
        raise BadInput(
            f"{kind.__name__} is no frozen dataclass; it must have @frozen of taichi_silo.mpm.frozen above it"
        )
    for name, field in getattr(kind, HIDDEN).items():
        if field.type not in (float, int, "float", "int"):
            raise BadInput(f"{kind.__name__}.{name} is of type {field.type}; constants must be float or int")


def _formulas(kind: type, wanted: Mapping[str, tuple[dict[str, str], str]]) -> None:
    for name, (kinds, result) in wanted.items():
        function: Any = getattr(kind, name, None)
        if not (of_kernels(function) or isinstance(function, FunctionType)):
            raise BadInput(f"{kind.__name__} has no formula {name}; it must have {', '.join(wanted)}")
        found = Formula(function, f"{kind.__name__}.{name}", kind).kind(kinds)
        if found in (TUPLE, NUMBER, CONSTANT) and (found == TUPLE) != (result == TUPLE):
            right = "a tuple" if result == TUPLE else "a number"
            raise BadInput(f"{kind.__name__}.{name} returns a {found}; it must return {right}")


def _has(kind: type, name: str) -> bool:
    return hasattr(kind, name) or name in getattr(kind, HIDDEN)


def _states() -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Stresses (xx, yy, zz, xy) and void ratios of usual sand, each of all states."""
    p, share, turn, e = np.meshgrid(PRESSURES_Pa, FRICTION, (0.0, 0.7, 2.0), VOID_RATIOS)
    half = p * share
    xx, yy = -p + half * np.cos(2.0 * turn), -p - half * np.cos(2.0 * turn)
    return tuple(part.ravel() for part in (xx, yy, -p + 0.2 * half, half * np.sin(2.0 * turn))), e.ravel()


def _rate(law: Any, stress: Any, e: np.ndarray, D: Any) -> tuple[np.ndarray, ...]:
    nothing = 0.0 * e
    size = np.sqrt(D[0] ** 2 + D[1] ** 2 + D[2] ** 2 + 2.0 * D[3] ** 2)
    rate = law.rate(stress, (nothing,) * 4, law.factors(stress, e), D, size)
    return tuple(part + nothing for part in rate)


def _sym(n: tuple[float, float], m: tuple[float, float]) -> tuple[float, float, float, float]:
    return n[0] * m[0], n[1] * m[1], 0.0, 0.5 * (n[0] * m[1] + n[1] * m[0])


def _quarter(a: Any) -> tuple:
    """A tensor in axes that are turned by a right angle."""
    return a[1], a[0], a[2], -a[3]

"""Numbers as people read them."""

import math

NONE = "–"
RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
LARGE_M = 1.0  # from which lengths are read in m


def number(value: float | None, digits: int = 3) -> str:
    """A number with so many significant digits, as a power of ten where it is very large or small; – for none.

    >>> number(1234.5), number(0.54), number(1.3e-9, 2), number(None)
    ('1,230', '0.540', '1.3·10⁻⁹', '–')
    """
    if value is None or not math.isfinite(value):
        return NONE
    if value == 0.0:
        return "0"
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    size = int(power)
    if not -5 < size < 7:
        return _true_minus(f"{mantissa}·10") + f"{size}".translate(RAISED)
    return _true_minus(f"{round(value, digits - 1 - size):,.{max(digits - 1 - size, 0)}f}")


def plain(value: float | None, digits: int = 4) -> str:
    """A number as it was given: so many digits at most, and no zeros at its end.

    >>> plain(20.0), plain(0.0015), plain(1e-9)
    ('20', '0.0015', '10⁻⁹')
    """
    if value is None or not math.isfinite(value):
        return NONE
    words = f"{value:.{digits}g}"
    if "e" not in words:
        return _true_minus(words)
    mantissa, power = words.split("e")
    ten = "10" + f"{int(power)}".translate(RAISED)
    return ten if mantissa == "1" else _true_minus(f"{mantissa}·{ten}")


def count(value: float | None) -> str:
    """A whole number, with a comma before each three digits."""
    return NONE if value is None or not math.isfinite(value) else f"{value:,.0f}"


def per_cent(share: float | None, signed: bool = False) -> str:
    """A share in per cent; with its sign if it is a difference."""
    if share is None or not math.isfinite(share):
        return NONE
    words = number(100.0 * share, 2 if abs(share) < 0.995 else 3)
    return f"{'+' if signed and share > 0.0 else ''}{words} %"


def mm(length_m: float | None, digits: int = 4) -> str:
    """A length in mm, or from 1 m on in m."""
    if length_m is None or not math.isfinite(length_m):
        return NONE
    unit, per_m = length_unit(abs(length_m))
    return f"{plain(per_m * length_m, digits)} {unit}"


def length_unit(largest_m: float) -> tuple[str, float]:
    """Unit in which lengths up to this are read, and how many of it make a metre."""
    return ("m", 1.0) if largest_m >= LARGE_M * (1.0 - 5e-4) else ("mm", 1e3)


def height_words(height_m: float, per_m: float) -> str:
    """A height in a table, to the mm, or in m to the cm."""
    return f"{per_m * height_m:.{0 if per_m > 1.0 else 2}f}"


def kN(force_N: float | None) -> str:
    """A force in kN, without its unit."""
    return number(None if force_N is None else 1e-3 * force_N)


def kPa(stress_Pa: float | None) -> str:
    """A stress in kPa, without its unit."""
    return kN(stress_Pa)


def sentence(words: str) -> str:
    """These words as a sentence: with a capital letter and a full stop."""
    words = words.strip()
    return words[:1].upper() + words[1:] + ("" if words.endswith((".", "!", "?")) else ".")


def _true_minus(words: str) -> str:
    return words.replace("-", "−")

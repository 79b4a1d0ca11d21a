"""Numbers as people read them."""

import math

NONE = "–"
RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
LARGE_M = 10.0  # from which lengths are read in m


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
    """A length in mm; of large silos in m."""
    if length_m is None or not math.isfinite(length_m):
        return NONE
    large = abs(length_m) >= LARGE_M
    return f"{plain(length_m if large else 1e3 * length_m, digits)} {'m' if large else 'mm'}"


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

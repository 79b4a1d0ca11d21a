"""Numbers as they are written in other countries: with a comma for the point."""

import re
from typing import Any

COMMA = re.compile(r"[+-]?\d+,\d+")
GIVEN = re.compile(rf"=\s*({COMMA.pattern})(?=\s|[}}#]|$)")  # in a line of TOML, and no list


def with_point(given: Any) -> str:
    """The number that is written with a comma, with a point; empty if that is not what is wrong.

    >>> with_point("0,2"), with_point("2")
    ('0.2', '')
    """
    return given.replace(",", ".") if isinstance(given, str) and COMMA.fullmatch(given.strip()) else ""


def with_comma(line: str) -> str:
    """The first number with a comma that a line of TOML gives; empty if there is none.

    >>> with_comma("outlet = { width_m = 0,08 }"), with_comma("at_m = [0,2]")
    ('0,08', '')
    """
    found = GIVEN.search(line)
    return found[1] if found else ""

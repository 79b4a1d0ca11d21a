"""Values and texts of users as parts of a sentence: on one line, printable and short, whatever they are."""

import datetime
import difflib
import math
import numbers
from collections.abc import Iterable
from pathlib import PurePath

LONGEST = 399  # letters of a sentence
VALUE, ENTRIES, DEEP = 60, 4, 3  # letters of a value; entries of a list or table, and lists in lists, that are shown
LONGEST_MATCHED = 80  # letters of a word for which a similar one is looked for
DIGITS = 20  # of a whole number that is shown as it is


def shown(value, most: int = VALUE) -> str:
    """A value as a sentence shows it, at most so many letters long."""
    text = _text(value, DEEP, most)
    return text if len(text) <= most else f"{text[: most - 3]}..."


def sentence(text: str, most: int = LONGEST) -> str:
    """A text on one line, without signs that cannot be printed; a long one without its middle."""
    text = str(text)
    if len(text) > 10 * most:
        text = f"{text[: 5 * most]}...{text[-5 * most :]}"
    text = " ".join(_printable(text).split())
    half = (most - 5) // 2
    return text if len(text) <= most else f"{text[:half]} ... {text[-half:]}"


def counted(count: int, what: str) -> str:
    """A number and its noun, with an s unless it is one."""
    return f"{count:,} {what}{'' if count == 1 else 's'}"


def near(word, known: Iterable[str], cutoff: float = 0.6) -> str | None:
    """The known word that is most like a word; None if none is."""
    if not isinstance(word, str) or len(word) > LONGEST_MATCHED:
        return None
    return next(iter(difflib.get_close_matches(word, list(known), 1, cutoff)), None)


def _printable(text: str) -> str:
    return "".join(sign if sign.isprintable() else " " if sign.isspace() else "?" for sign in text)


def _text(value, deep: int, most: int = VALUE) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str | PurePath):
        return _printable(str(value)[: most + 1]) or "empty"
    if isinstance(value, int) and abs(value) >= 10**DIGITS:
        return f"{'-' if value < 0 else ''}1e{int(math.log10(2) * value.bit_length())} or so"
    if isinstance(value, dict):
        if not deep:
            return "{...}"
        pairs = [f"'{_text(key, 0)}': {_text(one, deep - 1)}" for key, one in list(value.items())[:ENTRIES]]
        return f"{{{', '.join([*pairs, *(['...'] if len(value) > ENTRIES else [])])}}}"
    if isinstance(value, list | tuple):
        if not deep:
            return "[...]"
        entries = [_text(one, deep - 1) for one in value[:ENTRIES]]
        return f"[{', '.join([*entries, *(['...'] if len(value) > ENTRIES else [])])}]"
    if value is None or isinstance(value, numbers.Number | datetime.date | datetime.time):
        return str(value)
    return f"of type {type(value).__name__}"

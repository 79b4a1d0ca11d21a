"""Reading files of unknown origin: bounded in time and memory, and no code in them is run."""

import contextlib
import errno
import io
import json
import os
import re
import stat
import tomllib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from taichi_silo.errors import BadInput
from taichi_silo.utils.messages import shown
from taichi_silo.utils.number_words import with_comma, with_point

if TYPE_CHECKING:
    import pandas as pd

MB = 1_000_000
LARGEST_TABLES = MB  # bytes of a TOML file; one with every value is of some thousand
LARGEST_SUMMARY = 20 * MB
LARGEST_CURVES = 500 * MB  # rows of months
DEEPEST = 40  # parts of a dotted name, and tables in tables
LONGEST_HEAD = 20_000  # bytes of the first line of a table
KINDS = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device",
         stat.S_IFBLK: "a device"}  # fmt: skip
MISFITS = (ArithmeticError, AssertionError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
AT_LINE = re.compile(r"at line (\d+)")
QUOTED = re.compile(r"\"[^\"\n]*\"|'[^'\n]*'")


def place(given, name: str = "file") -> Path:
    """A path as a user typed it, checked to be one that a file system can have; ~ is the user's folder.

    Raises BadInput if it is no path.
    """
    try:
        path = Path(given).expanduser()
        os.lstat(path)
    except (TypeError, ValueError, RuntimeError) as error:
        raise BadInput(f"{name} is {shown(given)}; it must be the path of a file or folder") from error
    except OSError as error:
        if error.errno in (errno.ENAMETOOLONG, errno.ELOOP, errno.EACCES):
            raise BadInput(f"{name} is {shown(given)}; there can be none: {error.strerror}") from error
    return path


def content(file, what: str, most: int) -> bytes:
    """The bytes of a file, which should be `what` ("a scene") for the sentence that refuses it.

    Raises BadInput if it is not there, is no file (but a folder, a pipe, a device), or has more than `most` bytes.
    """
    file = place(file)
    try:
        found = os.stat(file)
        if not stat.S_ISREG(found.st_mode):
            kind = KINDS.get(stat.S_IFMT(found.st_mode), "no file")
            raise BadInput(f"{file} cannot be read as {what}: it is {kind}")
        if found.st_size > most:
            raise BadInput(f"{file} has {found.st_size} bytes; {what} has at most {most}")
        with open(file, "rb") as stream:
            return stream.read(most)
    except OSError as error:
        raise BadInput(f"{file} cannot be read as {what}: {error.strerror or error}") from error


def toml(file, what: str, most: int = LARGEST_TABLES) -> dict:
    """The tables of a TOML file.

    Raises BadInput if there is none, or what is there is no TOML.
    """
    data = content(file, what, most)
    try:
        return parsed(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise BadInput(f"{file} cannot be read as {what}: it must be text, in UTF-8") from error
    except ValueError as error:
        raise BadInput(f"{file} cannot be read as {what}: {error}") from error


def parsed(text: str) -> dict:
    """The tables of a TOML text.

    Raises ValueError if it is none, or nested too deep.
    """
    for line in text.splitlines():
        name = QUOTED.sub("q", line).partition("=")[0]
        if name.count(".") > DEEPEST and "," not in name:
            raise ValueError(f"a name has {name.count('.') + 1} parts, at most {DEEPEST} make sense")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        at = AT_LINE.search(str(error))
        line = text.splitlines()[int(at[1]) - 1] if at else ""
        if at and (given := with_comma(line)):
            raise ValueError(f"line {at[1]} has {given}; write {with_point(given)}, with a point") from error
        raise
    except RecursionError as error:
        raise ValueError("it is nested too deep") from error
    except ValueError as error:  # Python's own limit of digits
        raise ValueError("a number has too many digits") from error


def tables(file) -> dict:
    """The object of a JSON file.

    Raises BadInput if there is none, or what is there is none.
    """
    data = content(file, "JSON", LARGEST_SUMMARY)
    try:
        return dict(json.loads(data.decode("utf-8-sig")))
    except (TypeError, ValueError, RecursionError) as error:
        raise BadInput(f"{file} cannot be read as JSON: it is damaged") from error


def frame(file) -> "pd.DataFrame":
    """The table of a CSV file, its whole rows only; empty and without columns if it has no content.

    Raises BadInput if it is not there, or no table.
    """
    import pandas as pd  # it takes half a second, and most files are no tables

    data = content(file, "a table", LARGEST_CURVES)
    if len(data[:LONGEST_HEAD].split(b"\n", 1)[0]) >= LONGEST_HEAD:
        raise BadInput(f"{file} cannot be read as a table: its first line is longer than {LONGEST_HEAD} bytes")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of rows that are too long, which are left out
            return pd.read_csv(io.BytesIO(data), on_bad_lines="skip", encoding="utf-8", index_col=False)
    except pd.errors.EmptyDataError:
        return pd.DataFrame()
    except (ValueError, OverflowError, RecursionError) as error:  # a parser's own errors are ValueErrors
        raise BadInput(f"{file} cannot be read as a table: it is damaged, or none") from error


@contextlib.contextmanager
def sense(words: str) -> Iterator[None]:
    """Turn any error that a value of a wrong kind causes in this block into BadInput with this sentence.

    Raises BadInput with that sentence.
    """
    try:
        yield
    except BadInput:
        raise
    except MISFITS as error:
        raise BadInput(words) from error


def as_left(folder):
    """Turn any error in this block, which reads the files of a run, into BadInput: they are not what a run leaves."""
    return sense(f"folder is {folder}; it must be that of a run, and its files are not as a run leaves them")

"""The table of the stored solids of EN 1991-4."""

import tomllib
from functools import lru_cache
from pathlib import Path

NOTES = ("title", "read_in")  # beside the values


@lru_cache
def published() -> dict[str, dict]:
    """Every solid of table E.1: its values, `title`, and `read_in`, where the row was read."""
    return tomllib.loads(Path(__file__).with_name("solids.toml").read_text(encoding="utf-8"))


def key_of(name: str) -> str:
    """The name of a solid as the table has it, from one with capitals or spaces."""
    return name.strip().lower().replace(" ", "-").replace("_", "-")

"""The table of the named sands."""

import tomllib
from pathlib import Path


def published() -> dict[str, dict]:
    """Every named sand: its constants, `title`, `source`, and `read_in`, where the numbers were read."""
    return tomllib.loads(Path(__file__).with_name("sands.toml").read_text(encoding="utf-8"))

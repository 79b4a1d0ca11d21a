"""Named sands, and files with one's own."""

import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.scene.sand import Sand
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import one_sentence

LONGEST = 100  # letters of a name
NOTES = ("title", "source", "read_in")


def published() -> dict[str, dict]:
    """Every named sand: its constants, `title`, `source`, and `read_in`, where the numbers were read."""
    return tomllib.loads(Path(__file__).with_name("sands.toml").read_text(encoding="utf-8"))


def sand(name_or_file: str, void_ratio: float, **more: Any) -> Sand:
    """A named sand, or that of a TOML file with the same keys, at a void ratio.

    Raises BadInput if there is no such sand or file, a constant is missing or unknown, or the set is impossible.
    """
    known = published()
    key = shown(name_or_file, LONGEST).strip().lower()
    if key in known:
        constants = {k: v for k, v in known[key].items() if k not in NOTES}
        return _checked({"name": key, **constants}, void_ratio, more)
    file = bounded_reading.place(name_or_file, "sand")
    if file.suffix.lower() != ".toml":
        meant = near(key, known)
        hint = f"; did you mean {meant}?" if meant else ""
        raise BadInput(f"sand is {shown(name_or_file)}; it must be a TOML file or one of {', '.join(known)}{hint}")
    constants = bounded_reading.toml(file, "a sand")
    needed = [name for name in next(iter(known.values())) if name not in NOTES]
    missing = [name for name in needed if name not in constants]
    if missing:
        raise BadInput(f"sand file {file} lacks {', '.join(missing)}")
    unknown = [name for name in constants if name not in (*needed, *NOTES, "name")]
    if unknown:
        raise BadInput(f"sand file {file} holds {shown(unknown[0])}; a sand has {', '.join(needed)}")
    constants = {k: v for k, v in constants.items() if k not in NOTES}
    try:
        return _checked({"name": file.stem, **constants}, void_ratio, more)
    except ValidationError as error:
        raise BadInput(f"sand file {file}: {one_sentence(error)}") from error


def _checked(constants: dict, void_ratio: float, more: dict) -> Sand:
    return Sand.model_validate({**constants, "void_ratio": void_ratio, **more})

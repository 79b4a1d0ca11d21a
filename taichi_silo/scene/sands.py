"""Named sands, and files with one's own."""

from typing import Any

from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.scene import published_solids
from taichi_silo.scene.published_sands import published
from taichi_silo.scene.sand import Sand
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import one_sentence

LONGEST = 100  # letters of a name
NOTES = ("title", "source", "read_in")


def constants(table: dict[str, Any]) -> dict[str, Any]:
    """The constants of a sand's table, without the notes on where they come from."""
    return {name: value for name, value in table.items() if name not in NOTES}


def only_theory(name: str) -> str:
    """What is to be said of a stored solid of EN 1991-4 that is named as a sand; empty for every other name."""
    key = published_solids.key_of(name)
    if key not in published_solids.published():
        return ""
    return (
        f"; {key} is a solid of EN 1991-4, whose constants of the law are not known: only theory applies, "
        f"eurocode.solid = {key} in `taichi-silo eurocode`"
    )


def sand(name_or_file: str, void_ratio: float, **more: Any) -> Sand:
    """A named sand, or that of a TOML file with the same keys, at a void ratio.

    Raises BadInput if there is no such sand or file, a constant is missing or unknown, or the set is impossible.
    """
    known = published()
    key = shown(name_or_file, LONGEST).strip().lower()
    if key in known:
        return Sand.model_validate({"name": key, **constants(known[key]), "void_ratio": void_ratio, **more})
    file = bounded_reading.place(name_or_file, "sand")
    if file.suffix.lower() != ".toml":
        meant = near(key, known)
        hint = f"; did you mean {meant}?" if meant else only_theory(key)
        raise BadInput(f"sand is {shown(name_or_file)}; it must be a TOML file or one of {', '.join(known)}{hint}")
    given, needed = constants(bounded_reading.toml(file, "a sand")), constants(next(iter(known.values())))
    missing = [name for name in needed if name not in given]
    if missing:
        raise BadInput(f"sand file {file} lacks {', '.join(missing)}")
    unknown = [name for name in given if name not in (*needed, "name")]
    if unknown:
        raise BadInput(f"sand file {file} holds {shown(unknown[0])}; a sand has {', '.join(needed)}")
    try:
        return Sand.model_validate({"name": file.stem, **given, "void_ratio": void_ratio, **more})
    except ValidationError as error:
        raise BadInput(f"sand file {file}: {one_sentence(error)}") from error

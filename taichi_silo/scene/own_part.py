"""Names of parts that may be of a user's own."""

from collections.abc import Iterable, Mapping
from typing import Any

from taichi_silo.utils import plugin_files
from taichi_silo.utils.messages import near, shown


def need_name(what: str, given: Any, usual: Iterable[str], registered: Mapping[str, Any], kind: str) -> Any:
    """The name that was given, if it is a usual one or, after installed plugins were looked for, a registered one.

    Raises ValueError if it is not.
    """
    usual = list(usual)
    if given in usual or (isinstance(given, str) and given in registered):
        return given
    plugin_files.installed()
    if isinstance(given, str) and given in registered:
        return given
    known = [*usual, *registered]
    meant = near(given, known)
    hint = f"; did you mean {meant}?" if meant else ""
    quoted = [f"'{name}'" for name in known]
    raise ValueError(
        f"{what} is {shown(given)}; it must be {', '.join(quoted[:-1])} or {quoted[-1]}, or {kind} that a plugin "
        f"registers{hint}"
    )

"""Why a package is there: asked for by this project, or by one that is."""

import importlib.metadata
from collections import defaultdict

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from checks.lock import declared


def origins() -> dict[str, list[str]]:
    """By name of a package, what asks for it here: parts of this project ("core" and its extras), then packages."""
    found, seen = defaultdict(list), set()
    left = [(name, part, wanted.extras) for part, many in declared().items() for name, wanted in many.items()]
    while left:
        name, why, extras = left.pop(0)
        if why not in found[name]:
            found[name].append(why)
        for extra in ("", *extras):
            if (name, extra) not in seen:
                seen.add((name, extra))
                left += [(canonicalize_name(one.name), name, one.extras) for one in _wanted(name, extra)]
    return dict(found)


def _wanted(name: str, extra: str) -> list[Requirement]:
    """What an installed package asks for on this machine, if it is had with one of its extras."""
    try:
        asked = [Requirement(one) for one in importlib.metadata.requires(name) or ()]
    except importlib.metadata.PackageNotFoundError:
        return []
    return [one for one in asked if one.marker is None or one.marker.evaluate({"extra": extra})]

"""The lock file and what pyproject.toml asks for."""

import tomllib
from pathlib import Path
from typing import NamedTuple

from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements.lock"


class Pin(NamedTuple):
    """One package of a lock.

    Attributes
    ----------
    name : normalised.
    version : the only one that may be installed.
    marker : on which machines and Pythons it is; None: on all.
    hashes : of the files that may be installed.

    """

    name: str
    version: Version
    marker: Marker | None
    hashes: tuple[str, ...]

    @property
    def here(self) -> bool:
        """Whether this machine and this Python need it."""
        return self.marker is None or self.marker.evaluate()


def read(text: str) -> dict[str, Pin]:
    """The pins of a lock file by their names.

    Raises
    ------
    ValueError
        if a line is no pin to one version.

    """
    pins = {}
    for line in text.replace("\\\n", " ").splitlines():
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        wanted, *hashes = line.split("--hash=")
        found = Requirement(wanted)
        versions = [one.version for one in found.specifier if one.operator == "=="]
        if len(versions) != 1 or len(found.specifier) != 1 or found.url:
            raise ValueError(f"the lock has {wanted.strip()!r}; each of its lines must pin one version")
        name = canonicalize_name(found.name)
        pins[name] = Pin(name, Version(versions[0]), found.marker, tuple(one.strip() for one in hashes))
    return pins


def declared() -> dict[str, dict[str, Requirement]]:
    """What pyproject.toml asks for, by its parts ("core" and the extras) and the names of packages."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    parts = {"core": project["dependencies"]} | project["optional-dependencies"]
    found = {part: [Requirement(one) for one in wanted] for part, wanted in parts.items()}
    return {
        part: {canonicalize_name(one.name): one for one in wanted if canonicalize_name(one.name) != project["name"]}
        for part, wanted in found.items()
    }

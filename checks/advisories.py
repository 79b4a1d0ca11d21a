"""Which locked versions have known weaknesses: from the list beside this file, and from pip-audit where it is."""

import json
import shutil
import subprocess
import tomllib
from collections.abc import Mapping
from datetime import date
from pathlib import Path
from typing import NamedTuple

from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name
from packaging.version import Version

from checks.lock import LOCK, ROOT

LIST = Path(__file__).with_name("advisories.toml")
PATIENCE_S = 300.0  # with a program that asks the network


class Weakness(NamedTuple):
    """Something known against a version.

    Attributes
    ----------
    package, version : that have it.
    id : by which databases know it.
    what : in words.
    accepted : why it may stay; empty: it may not.

    """

    package: str
    version: str
    id: str
    what: str
    accepted: str = ""


def made() -> date:
    """The day of the list."""
    return tomllib.loads(LIST.read_text(encoding="utf-8"))["made"]


def carried(versions: Mapping[str, Version]) -> list[Weakness]:
    """What the list has against versions, which are by the names of their packages."""
    known = tomllib.loads(LIST.read_text(encoding="utf-8"))
    del known["made"]
    return [
        Weakness(name, str(versions[name]), one["id"], one["what"], _accepted(one, versions[name]))
        for name, many in known.items() if name in versions
        for one in many
        if any(versions[name] in SpecifierSet(affected, prereleases=True) for affected in one["affected"])
    ]  # fmt: skip


def _accepted(advisory: dict, version: Version) -> str:
    """Why it may stay, if it may."""
    word = advisory.get("unused")
    if word and any(word in file.read_text(encoding="utf-8") for file in (ROOT / "taichi_silo").rglob("*.py")):
        return ""
    reasons = advisory.get("accepted", {})
    return next((why for affected, why in reasons.items() if version in SpecifierSet(affected)), "")


def asked(lock: Path = LOCK) -> list[Weakness] | str:
    """What pip-audit finds, if it is installed and has its answer; otherwise why there is none."""
    program = shutil.which("pip-audit")
    if program is None:
        return "pip-audit is not installed"
    command = [program, "--requirement", str(lock), "--disable-pip", "--format", "json", "--progress-spinner", "off"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)
        found = json.loads(done.stdout)["dependencies"]
        return [
            Weakness(canonicalize_name(one["name"]), one["version"], it["id"], _first_sentence(it["description"]))
            for one in found
            for it in one.get("vulns", ())
        ]
    except subprocess.TimeoutExpired:
        return f"pip-audit had no answer within {PATIENCE_S:.0f} s"
    except (OSError, ValueError, KeyError, TypeError):
        return "pip-audit had no answer that can be read; is the network there?"


def _first_sentence(text: str) -> str:
    """Of a description, without its full stop."""
    return " ".join(text.split()).split(". ")[0].rstrip(".")

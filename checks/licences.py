"""The licence of an installed package, and whether it may be used here."""

import importlib.metadata
import re
import tomllib
from pathlib import Path

_KNOWN = tomllib.loads(Path(__file__).with_name("licences.toml").read_text(encoding="utf-8"))
ALLOWED: dict[str, str] = _KNOWN["allowed"]
NAMES: dict[str, str] = _KNOWN["names"]
WITHIN: dict[str, str] = _KNOWN["within"]
CLASSIFIER = "License :: OSI Approved :: "


def licence(package: str) -> str:
    """An expression of SPDX names; empty if the package does not say it, or says what is not known here.

    Raises
    ------
    importlib.metadata.PackageNotFoundError
        if the package is not installed.

    """
    said = importlib.metadata.metadata(package)
    if expression := said.get("License-Expression"):
        return expression
    lines = said.get("License", "").strip().splitlines()[:1]
    named = [one.removeprefix(CLASSIFIER) for one in said.get_all("Classifier") or () if one.startswith(CLASSIFIER)]
    known = (NAMES.get(one, one) for one in (*lines, *named))
    return next((one for one in known if one in ALLOWED), "")


def may_be_used(expression: str) -> bool:
    """Whether an expression of SPDX names leaves a way that is allowed; within brackets, all of them must be."""
    if "(" in expression:
        expression = re.sub(r"[()]", " ", expression).replace(" OR ", " AND ")
    return any(all(name.strip() in ALLOWED for name in way.split(" AND ")) for way in expression.split(" OR "))

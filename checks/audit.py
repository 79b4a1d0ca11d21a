"""What this project is built on, package by package: `make audit`.

For everything that requirements.lock names: version, day of release, licence, who asks for it, and what is known
against it. The licences are those that the installed packages state; weaknesses come from the list in
advisories.toml and, where pip-audit is installed and the network is there, from the databases that it asks. Ends with
exit code 1 and a sentence for each thing that must not be.
"""

import argparse
import importlib.metadata
import sys
from collections.abc import Mapping
from datetime import date
from pathlib import Path
from typing import NamedTuple

from packaging.version import Version

from checks import advisories, licences, lock, origin, released

HEADS = ("package", "version", "released", "licence", "asked for by", "known against it")


class Row(NamedTuple):
    """One package of the table, in words."""

    package: str
    version: str
    released: str
    licence: str
    by: str
    against: str


def rows(pins: Mapping[str, lock.Pin], weaknesses: list[advisories.Weakness]) -> list[Row]:
    """The table."""
    asked_by, days = origin.origins(), released.read()
    found = []
    for name, pin in sorted(pins.items()):
        day = days.get((name, str(pin.version)))
        by = asked_by.get(name, [])
        against = [f"{one.id}{' (accepted)' if one.accepted else ''}" for one in weaknesses if one.package == name]
        found.append(Row(
            name, str(pin.version), str(day or "–"), _licence(name) or ("unknown" if pin.here else "–"),
            ", ".join(by[:3]) + (" …" if len(by) > 3 else "") or ("nobody" if pin.here else "other machines"),
            ", ".join(against) or "–",
        ))  # fmt: skip
    return found


def findings(pins: Mapping[str, lock.Pin], weaknesses: list[advisories.Weakness]) -> list[str]:
    """A sentence for each thing that must not be."""
    asked_by = origin.origins()
    found = [
        f"{one.package} {one.version} {one.what} ({one.id}); lock a version without it: "
        f"`make lock RENEW='--upgrade-package {one.package}'`"
        for one in weaknesses
        if not one.accepted
    ]
    for name, pin in sorted(pins.items()):
        if not pin.here:
            continue
        if not _installed(name):
            found.append(f"{name} is locked but not installed, so that its licence cannot be read: `make setup`")
            continue
        licence = _licence(name)
        if not licence:
            found.append(f"{name} does not state its licence, or in words that checks/licences.toml does not know")
        elif not licences.may_be_used(licence):
            found.append(f"{name} has the licence {licence}, which checks/licences.toml does not allow")
        if name not in asked_by:
            found.append(f"{name} is locked, but nobody asks for it: `make lock`")
    for part, wanted in lock.declared().items():
        for name, one in wanted.items():
            if name not in pins:
                found.append(f"pyproject.toml asks for {name} ({part}), which is not locked: `make lock`")
            elif not one.specifier.contains(pins[name].version, prereleases=True):
                found.append(
                    f"{name} is locked at {pins[name].version}, but pyproject.toml asks for {one.specifier} ({part}): "
                    "`make lock`"
                )
    return found


def audit(text: str, online: bool = True) -> tuple[list[str], list[str]]:
    """Lines of the report on a lock, and its findings."""
    pins = lock.read(text)
    weaknesses = advisories.carried({name: pin.version for name, pin in pins.items()})
    told = f"the list of {advisories.made()} in checks/advisories.toml"
    if online:
        more = advisories.asked()
        if isinstance(more, str):
            told += f" alone ({more})"
        else:
            listed = {(one.package, one.id) for one in weaknesses}
            weaknesses += [one for one in more if (one.package, one.id) not in listed]
            told += " and pip-audit"
    lines = table([HEADS, *rows(pins, weaknesses)])
    direct = {name for wanted in lock.declared().values() for name in wanted} & set(pins)
    core = set(lock.declared()["core"])
    known = released.read()
    days = [known[key] for key in ((name, str(pin.version)) for name, pin in pins.items()) if key in known]
    lines += [
        "",
        f"{len(pins)} packages: {len(direct)} that this project asks for ({len(core)} of them wherever it is "
        f"installed), {len(pins) - len(direct)} that those ask for.",
        f"Released between {min(days)} and {max(days)}; "
        f"{sum((date.today() - day).days > 3 * 365 for day in days)} are older than three years.",
        f"Weaknesses from {told}.",
        *(f"Accepted: {one.package} {one.version} {one.what} ({one.id}): {one.accepted}."
          for one in weaknesses if one.accepted),
        *(f"Within {name}: {what}." for name, what in licences.WITHIN.items() if name in pins),
    ]  # fmt: skip
    if beside := sorted(_everything() - set(pins) - {"taichi-silo"}):
        lines.append(f"Installed here, but not locked, and not looked at: {', '.join(beside)}.")
    return lines, findings(pins, weaknesses)


def table(rows: list[tuple[str, ...]]) -> list[str]:
    """Rows with their columns below each other."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def _licence(name: str) -> str:
    """Of an installed package; empty if it is not there or does not say."""
    return licences.licence(name) if _installed(name) else ""


def _installed(name: str) -> Version | None:
    """The version that is here."""
    try:
        return Version(importlib.metadata.version(name))
    except importlib.metadata.PackageNotFoundError:
        return None


def _everything() -> set[str]:
    """Names of all packages that are here."""
    return {lock.canonicalize_name(one.metadata["Name"]) for one in importlib.metadata.distributions()}


def main() -> int:
    """Print the table, and what must not be."""
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--lock", type=Path, default=lock.LOCK, help="file to look at")
    flags.add_argument("--offline", action="store_true", help="ask nobody")
    chosen = flags.parse_args()
    lines, found = audit(chosen.lock.read_text(encoding="utf-8"), online=not chosen.offline)
    print("\n".join(lines))
    for sentence in found:
        print(f"error: {sentence}", file=sys.stderr)
    if not found:
        print("Nothing that must not be.")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

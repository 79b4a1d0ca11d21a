"""The audit finds what must not be, and finds none of it in the lock of this project."""

import importlib.metadata
import json
import os
import ssl
import sys
from email.message import Message

import pytest
from packaging.version import Version

from checks import advisories, audit, licences, lock

TEXT = lock.LOCK.read_text(encoding="utf-8")


def with_pin(name: str, version: str) -> str:
    """The lock with another version of a package."""
    pin = lock.read(TEXT)[name]
    return TEXT.replace(f"{name}=={pin.version}", f"{name}=={version}")


def test_nothing_that_is_locked_is_known_to_be_weak():
    pins = lock.read(TEXT)
    found = advisories.carried({name: pin.version for name, pin in pins.items()})
    assert not [one for one in found if not one.accepted]


def test_the_lock_passes_the_audit():
    lines, found = audit.audit(TEXT, online=False)
    assert not [one for one in found if "not installed" not in one], "an environment of another lock may lack some"
    pins = lock.read(TEXT)
    assert all(any(line.startswith(f"{name} ") for line in lines) for name in pins)
    assert any(line.startswith(f"{len(pins)} packages: ") for line in lines)


@pytest.mark.parametrize(
    ("name", "version", "known"),
    [
        ("pillow", "9.0", "CVE-2022-22817"), ("jinja2", "2.10", "CVE-2019-10906"),
        ("certifi", "2026.7.22", "GHSA-6q48-6c7w-9gw2"), ("urllib3", "2.0.6", "CVE-2023-45803"),
        ("pip", "23.2.1", "CVE-2023-5752"), ("dask", "2026.7.0", ""),
    ],
)  # fmt: skip
def test_a_pin_that_is_known_to_be_weak_is_found(name, version, known):
    _, found = audit.audit(with_pin(name, version), online=False)
    mine = [one for one in found if one.startswith(f"{name} {version} ")]
    if known:
        assert any(known in one and f"--upgrade-package {name}" in one for one in mine), found
    else:
        assert not mine, "it is accepted"


def test_what_is_accepted_for_not_being_used_is_not_once_it_is(monkeypatch, tmp_path):
    weak = {"dask": Version("2026.8.0")}
    assert all(one.accepted for one in advisories.carried(weak))
    (tmp_path / "taichi_silo").mkdir()
    (tmp_path / "taichi_silo" / "new.py").write_text("x = dask.array.from_npy_stack('here')\n")
    monkeypatch.setattr(advisories, "ROOT", tmp_path)
    assert not any(one.accepted for one in advisories.carried(weak))


def test_no_root_certificate_of_the_accepted_list_is_of_emsign():
    """That is why its advisory is accepted."""
    certifi = pytest.importorskip("certifi")
    roots = ssl.create_default_context(cafile=certifi.where()).get_ca_certs()
    assert len(roots) > 50
    if importlib.metadata.version("certifi") != str(lock.read(TEXT)["certifi"].version):
        pytest.skip("another version than the locked one is installed")
    assert not [one for one in roots if "emsign" in str(one).lower()]


def test_a_lock_that_is_not_that_of_the_project_is_found():
    _, found = audit.audit(TEXT.replace("h5py==", "h5pi=="), online=False)
    assert any(one.startswith("pyproject.toml asks for h5py (core), which is not locked") for one in found)
    assert any(one.startswith("h5pi is locked but not installed") for one in found)
    _, found = audit.audit(with_pin("numpy", "1.25.2"), online=False)
    assert any(one.startswith("numpy is locked at 1.25.2, but pyproject.toml asks for ") for one in found)


@pytest.mark.parametrize(
    ("fields", "means"),
    [
        ({"License-Expression": "MIT AND PSF-2.0"}, "MIT AND PSF-2.0"), ({"License": "BSD 3-Clause"}, "BSD-3-Clause"),
        ({"License": "Copyright (c) me", "Classifier": "License :: OSI Approved :: MIT License"}, "MIT"),
        ({"License": "The licence of my own"}, ""), ({}, ""),
    ],
)  # fmt: skip
def test_a_licence_is_read_wherever_a_package_states_it(fields, means, monkeypatch):
    said = Message()
    for name, value in fields.items():
        said[name] = value
    monkeypatch.setattr(importlib.metadata, "metadata", lambda package: said)
    assert licences.licence("any") == means


def test_licences_that_bind_this_project_are_refused():
    assert licences.may_be_used("Apache-2.0 OR GPL-3.0-only") and licences.may_be_used("MIT AND Zlib")
    for bound in ("GPL-3.0-only", "AGPL-3.0-only", "MIT AND GPL-3.0-only", "MIT AND (MIT OR GPL-3.0-only)", ""):
        assert not licences.may_be_used(bound)


def test_a_licence_that_is_not_allowed_is_a_finding(monkeypatch):
    monkeypatch.setattr(licences, "licence", lambda name: {"numpy": "GPL-3.0-only", "scipy": ""}.get(name, "MIT"))
    _, found = audit.audit(TEXT, online=False)
    assert any(one.startswith("numpy has the licence GPL-3.0-only") for one in found)
    assert any(one.startswith("scipy does not state its licence") for one in found)


def test_it_says_on_what_it_rests_and_ends_with_1_where_something_is_found(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(advisories, "asked", lambda: "nobody answers")
    weak = tmp_path / "weak.lock"
    weak.write_text(with_pin("pillow", "9.0"), encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["audit", "--lock", str(weak)])
    assert audit.main() == 1
    told = capsys.readouterr()
    assert "checks/advisories.toml alone (nobody answers)" in told.out
    assert "error: pillow 9.0 ImageMath.eval runs any expression (CVE-2022-22817); lock a version" in told.err


@pytest.mark.skipif(os.name == "nt", reason="the stand-in for pip-audit is a script")
def test_what_pip_audit_finds_is_added_and_its_silence_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert advisories.asked() == "pip-audit is not installed"
    program = tmp_path / "pip-audit"
    answer = {"dependencies": [
        {"name": "Pillow", "version": "13.0.0", "vulns": [{"id": "PYSEC-1", "description": "It is bad. Very."}]},
        {"name": "numpy", "version": "2.4.6", "vulns": []},
    ]}  # fmt: skip
    program.write_text(f"#!{sys.executable}\nprint({json.dumps(answer)!r})\n")
    program.chmod(0o755)
    assert advisories.asked() == [advisories.Weakness("pillow", "13.0.0", "PYSEC-1", "It is bad")]
    _, found = audit.audit(TEXT)
    assert any(one.startswith("pillow 13.0.0 It is bad (PYSEC-1)") for one in found)
    program.write_text(f"#!{sys.executable}\nraise SystemExit('no network')\n")
    assert "no answer that can be read" in advisories.asked()

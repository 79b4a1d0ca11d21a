"""What is installed is what requirements.lock says, and that is what pyproject.toml asks for."""

import importlib.metadata
import re
import sys
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.version import Version

from checks import lock, released

TEXT = lock.LOCK.read_text(encoding="utf-8")
PINS = lock.read(TEXT)
MACHINES = [("linux", "Linux", "posix"), ("darwin", "Darwin", "posix"), ("win32", "Windows", "nt")]


def test_everything_that_is_asked_for_is_locked_within_its_range():
    for part, wanted in lock.declared().items():
        for name, one in wanted.items():
            assert name in PINS, f"{name} of {part}"
            assert one.specifier.contains(PINS[name].version), f"{name} {PINS[name].version} of {part}"


def test_every_file_has_to_have_a_known_hash():
    assert len(PINS) > 80
    for pin in PINS.values():
        assert pin.hashes, pin.name
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", one) for one in pin.hashes), pin.name


def test_it_names_no_place_to_load_from():
    assert not re.search(r"://|@|--(extra-)?index-url|--find-links|--trusted-host", TEXT)


@pytest.mark.parametrize("system", MACHINES, ids=lambda system: system[1])
@pytest.mark.parametrize("python", ["3.11.5", "3.12.0", "3.13.0"])
def test_what_this_project_asks_for_is_locked_for_every_system_and_python(python, system):
    there = dict(zip(("sys_platform", "platform_system", "os_name"), system, strict=True))
    there |= {"python_full_version": python, "python_version": python.rpartition(".")[0]}
    environment = {str(name): str(value) for name, value in default_environment().items()} | there
    for wanted in lock.declared().values():
        for name in wanted:
            assert PINS[name].marker is None or PINS[name].marker.evaluate(environment), name


def test_the_days_of_release_are_those_of_the_lock():
    assert set(released.read()) <= {(name, str(pin.version)) for name, pin in PINS.items()}
    assert len(released.read()) > 0.9 * len(PINS), "`make lock` writes them"


def test_what_is_installed_is_what_is_locked():
    made = Path(sys.prefix) / ".ready"
    if not made.exists() or made.read_text(encoding="utf-8") != TEXT:
        pytest.skip("this environment was not made from this lock; `make setup` makes one that is")
    found = importlib.metadata.distributions()
    here = {lock.canonicalize_name(one.metadata["Name"]): Version(one.version) for one in found}
    here.pop("taichi-silo")
    assert here == {name: pin.version for name, pin in PINS.items() if pin.here}


def test_a_line_that_leaves_the_version_open_is_noticed():
    for line in ("numpy>=2", "numpy", "numpy==2.0,<3", "numpy @ file:///numpy.whl"):
        with pytest.raises(ValueError, match="must pin one version"):
            lock.read(line)
    assert lock.read("a-b==1.0 ; python_version < '3' \\\n    --hash=sha256:00\n")["a-b"].here is False

"""What the package imports, what pyproject.toml asks for, what is locked and what is installed are the same."""

import ast
import importlib.metadata
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "taichi_silo"
NAMES = {"PIL": "pillow", "tomli_w": "tomli-w", "dask_jobqueue": "dask-jobqueue"}
BROUGHT = {  # by what is built on them
    "imageio_ffmpeg": "imageio", "dask": "distributed", "pydantic_core": "pydantic", "markupsafe": "jinja2",
}  # fmt: skip
OPTIONAL = ("cluster", "drawings")  # parts that a user may leave out
MACHINES = [
    ("linux", "Linux", "posix", "x86_64"), ("linux", "Linux", "posix", "aarch64"),
    ("darwin", "Darwin", "posix", "arm64"), ("win32", "Windows", "nt", "AMD64"),
]  # fmt: skip
LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")


def by_name(lines) -> dict[str, Requirement]:
    found = map(Requirement, lines)
    return {canonicalize_name(one.name): one for one in found if one.name != "taichi-silo"}


TABLES = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT, BUILD = TABLES["project"], TABLES["tool"]["hatch"]["build"]["targets"]
CORE = by_name(PROJECT["dependencies"])
EXTRAS = {part: by_name(lines) for part, lines in PROJECT["optional-dependencies"].items()}
ASKED = [(name, one) for part in (CORE, *EXTRAS.values()) for name, one in part.items()]
LINES = [line for line in LOCK.replace("\\\n", " ").splitlines() if line and not line.startswith("#")]
PINS: dict[str, list[Requirement]] = {}  # by name; one for each part of the environments in which its version differs
for line in LINES:
    pinned = Requirement(line.split("--hash=")[0])
    PINS.setdefault(canonicalize_name(pinned.name), []).append(pinned)


def holds(one: Requirement, environment: dict[str, str] | None = None) -> bool:
    """Whether a requirement is one in an environment; in this one if none is given."""
    return one.marker is None or one.marker.evaluate(environment)


# --- what is imported -------------------------------------------------------------------------------------------------


def imports(file: Path, at_once: bool = False) -> set[str]:
    """Dotted names that a file imports; `at_once`: when it is imported itself, not first when a function is called."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)] if at_once else []
    later = {inner for node in functions for inner in ast.walk(node)}
    found = set()
    for node in set(ast.walk(tree)) - later:
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module, *(f"{node.module}.{name.name}" for name in node.names)}
    return found


def packages(names: set[str]) -> set[str]:
    """Packages of other people that bring modules with these names."""
    tops = {name.split(".")[0] for name in names} - sys.stdlib_module_names - {"taichi_silo"}
    brought = {BROUGHT.get(name, name) for name in tops}
    return {NAMES.get(name, name) for name in brought}


def test_everything_imported_is_asked_for_and_everything_asked_for_is_imported():
    files = [*PACKAGE.rglob("*.py"), *(ROOT / file for file in BUILD["wheel"]["force-include"])]
    assert packages(set().union(*map(imports, files))) == set(CORE).union(*(EXTRAS[part] for part in OPTIONAL))


def test_the_program_starts_without_what_a_user_may_leave_out():
    optional = {name for part in OPTIONAL for name in EXTRAS[part]}
    assert not [file for file in PACKAGE.rglob("*.py") if packages(imports(file, at_once=True)) & optional]


# --- what is locked ---------------------------------------------------------------------------------------------------


def test_everything_that_is_asked_for_is_locked_at_a_version_within_its_range():
    assert len(PINS) > 80
    for name, pins in PINS.items():
        for pin in pins:
            assert [one.operator for one in pin.specifier] == ["=="] and not pin.url, name
    for name, one in ASKED:
        for pin in PINS[name]:
            (exact,) = pin.specifier
            assert one.specifier.contains(exact.version), f"{name} {exact.version}; `make lock`"


def test_every_file_has_a_known_hash_and_none_a_place_to_load_it_from():
    for line in LINES:
        hashes = [one.strip() for one in line.split("--hash=")[1:]]
        assert hashes and all(re.fullmatch(r"sha256:[0-9a-f]{64}", one) for one in hashes), line[:60]
    assert not re.search(r"://|@|--(extra-)?index-url|--find-links|--trusted-host", LOCK)


@pytest.mark.parametrize("system", MACHINES, ids=lambda system: f"{system[1]}-{system[3]}")
@pytest.mark.parametrize("python", ["3.11.5", "3.12.0", "3.13.0", "3.14.0"])
def test_what_this_project_asks_for_is_locked_once_for_every_system_and_python(python, system):
    there = dict(zip(("sys_platform", "platform_system", "os_name", "platform_machine"), system, strict=True))
    there |= {"python_full_version": python, "python_version": python.rpartition(".")[0]}
    environment = {str(name): str(value) for name, value in default_environment().items()} | there
    for name, one in ASKED:
        if holds(one, environment):
            assert [holds(pin, environment) for pin in PINS[name]].count(True) == 1, name
    assert [name for name in ("taichi", "quadrants") if holds(CORE[name], environment)] == [
        "quadrants" if python >= "3.14" or system[3] == "aarch64" else "taichi"
    ]


# --- what is installed ------------------------------------------------------------------------------------------------


def test_what_is_installed_is_what_is_locked():
    made = Path(sys.prefix) / ".ready"
    if not made.exists() or made.read_text(encoding="utf-8") != LOCK:
        pytest.skip("this environment was not made from this lock; `make setup` makes one that is")
    here = {canonicalize_name(one.metadata["Name"]): one.version for one in importlib.metadata.distributions()}
    here.pop("taichi-silo")
    pins = {name: pin for name, several in PINS.items() for pin in several if holds(pin)}
    assert here.keys() == pins.keys()
    assert all(pins[name].specifier.contains(version) for name, version in here.items())


@pytest.mark.parametrize(("only", "code"), [((), 0), (("--allow-only", "MIT"), 1)])
def test_no_licence_of_what_is_installed_binds_this_project(only, code):
    """pyproject.toml says which licences may be used; with fewer of them it would be noticed."""
    done = subprocess.run([sys.executable, "-m", "piplicenses", *only], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == code, done.stderr

"""The wheel holds what the program needs where no checkout is."""

import os
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    from hatchling.build import build_wheel

    target, before = tmp_path_factory.mktemp("wheel"), Path.cwd()
    os.chdir(ROOT)
    try:
        name = build_wheel(str(target))
    finally:
        os.chdir(before)
    with zipfile.ZipFile(target / name) as content:
        yield content


def test_it_holds_every_module_and_every_scenario(wheel):
    there = set(wheel.namelist())
    for file in (ROOT / "taichi_silo").rglob("*"):
        if file.suffix in (".py", ".toml", ".j2", ".css", ".js") and "__pycache__" not in file.parts:
            assert file.relative_to(ROOT).as_posix() in there
    for file in (ROOT / "scenarios").glob("*.py"):
        assert f"taichi_silo/scenarios/{file.name}" in there
    assert "taichi_silo/py.typed" in there


def test_it_holds_nothing_else(wheel):
    kinds = {Path(name).suffix for name in wheel.namelist()}
    assert kinds <= {".py", ".toml", ".typed", ".j2", ".css", ".js", ".txt", "", ".svg"}, kinds
    assert not [name for name in wheel.namelist() if name.startswith(("tests", "outputs", "benchmarks", "checks"))]


def test_it_brings_the_command_and_light_dependencies(wheel):
    (entry,) = [name for name in wheel.namelist() if name.endswith("entry_points.txt")]
    assert "taichi-silo = taichi_silo.cli.app:main" in wheel.read(entry).decode()
    (about,) = [name for name in wheel.namelist() if name.endswith("METADATA")]
    needed = [line for line in wheel.read(about).decode().splitlines() if line.startswith("Requires-Dist")]
    core = [line for line in needed if "extra ==" not in line]
    assert len(core) < 20
    for heavy in ("distributed", "mkdocs", "vtk", "playwright", "jupyter", "torch"):
        assert not any(heavy in line for line in core)

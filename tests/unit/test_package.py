"""The wheel holds what the program needs where no checkout is; the sdist, what its own tests need."""

import tarfile
import zipfile
from pathlib import Path

import pytest
from hatchling import build

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    target = tmp_path_factory.mktemp("wheel")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        name = build.build_wheel(str(target))
    with zipfile.ZipFile(target / name) as content:
        yield content


def test_it_holds_every_module_and_every_scenario(wheel):
    there = set(wheel.namelist())
    for file in (ROOT / "taichi_silo").rglob("*"):
        if file.suffix in (".py", ".toml", ".j2", ".css", ".js") and "__pycache__" not in file.parts:
            assert file.relative_to(ROOT).as_posix() in there
    for file in (ROOT / "scenarios").glob("*.py"):  # but those that start a study of this project
        studies = "from validation" in file.read_text(encoding="utf-8")
        assert (f"taichi_silo/scenarios/{file.name}" in there) != studies
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


def test_the_sdist_holds_what_its_tests_need(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    with tarfile.open(tmp_path / build.build_sdist(str(tmp_path))) as content:
        there = {name.partition("/")[2] for name in content.getnames()}
    assert there.issuperset(["Makefile", "requirements.lock", "mkdocs.yml", "LICENSE"])
    assert there.issuperset(["outputs/gallery/chart.csv", "docs/data/trust.csv"])
    for folder in ("tests", "validation", "benchmarks", "scenarios", "docs"):
        for file in (ROOT / folder).rglob("*.*"):
            if file.is_file() and "__pycache__" not in file.parts:
                assert file.relative_to(ROOT).as_posix() in there
    assert not [name for name in there if name.startswith((".venv", "build", "site"))]

"""Python in the pages runs, against a small silo; and the names in the pages exist."""

import os
import re
import shutil
from pathlib import Path

import pytest
from written import DOCS, blocks

import taichi_silo
from taichi_silo import api
from taichi_silo.runs import snapshot
from taichi_silo.runs.observers import Observer
from taichi_silo.scene.scene import Flow, Machine, Mesh, Method, Scene, Walls
from taichi_silo.scene.silo import Silo

OWN = {"how-to/mpm.md", "how-to/own-parts.md"}  # pages with tests of their own
PAGES = sorted({block.page for block in blocks("python")} - OWN)
RESULTS = re.compile(r'Result\("([^"]+)"\)')
PATHS = re.compile(r"`((?:\w+/)*\w+\.py)`((?:,? `\w+`)*)")
SMALL = Scene(
    silo=Silo(width_m=0.2, height_m=0.2),
    walls=Walls(kind="smooth", friction_angle_deg=19.0), grid=Mesh(cell_size_m=0.05),
    flow=Flow(speed_m_per_s=0.02, displacement_m=0.001), method=Method(filling_time_s=0.05, longest_settling_s=0.02),
    machine=Machine(threads=1, lanes=False),
)  # fmt: skip
TOML = (
    "[silo]\nwidth_m = 0.2\nheight_m = 0.2\n[walls]\nkind = 'smooth'\nfriction_angle_deg = 19\n"
    "[grid]\ncell_size_m = 0.05\n"
    "[flow]\nspeed_m_per_s = 0.02\ndisplacement_m = 0.001\n[method]\nfilling_time_s = 0.05\nlongest_settling_s = 0.02\n"
    "[machine]\nthreads = 1\nlanes = false\n"
)


class Keep(Observer):
    """Keeps what an observer sees."""

    def begin(self, simulation):
        self.simulation, self.records = simulation, []

    def observe(self, record):
        self.records.append(record)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A small run, and what its observers saw."""
    os.environ.setdefault("MPLBACKEND", "Agg")
    keep = Keep()
    found = api.run(SMALL, tmp_path_factory.mktemp("small") / "run", film=False, progress=False, extra=(keep,))
    return found, keep


@pytest.mark.parametrize("page", PAGES)
def test_python_of_a_page_runs(page, small, tmp_path, monkeypatch):
    result, keep = small
    texts = [block.text for block in blocks("python") if block.page == page]
    monkeypatch.chdir(tmp_path)
    Path("silo.toml").write_text(TOML, encoding="utf-8")
    for folder in {name for text in texts for name in RESULTS.findall(text)}:
        shutil.copytree(result.folder, folder)

    def run(scene, folder=None, *, overwrite=False, film=True, progress=True, extra=()):
        assert isinstance(scene, Scene)
        for observer in extra:
            observer.begin(keep.simulation)
            for record in keep.records:
                observer.observe(record)
            observer.end()
        return result

    monkeypatch.setattr(taichi_silo, "run", run)
    known = {"__name__": "page"}
    for number, text in enumerate(texts):
        exec(compile(text, f"{page}:{number}", "exec"), known)


def test_names_of_the_package_that_stand_in_words_exist():
    unknown = {name for name in re.findall(r"\bts\.(\w+)", pages_text()) if not hasattr(taichi_silo, name)}
    assert not unknown


def pages_text() -> str:
    return "\n".join(page.read_text(encoding="utf-8") for page in DOCS.rglob("*.md"))


def test_every_place_in_the_code_that_the_theory_names_exists():
    package, missing, seen = Path(taichi_silo.__file__).parent, [], 0
    for page in sorted((DOCS / "theory").glob("*.md")):
        for file, names in PATHS.findall(page.read_text(encoding="utf-8")):
            source = next((one for base in (package, package.parent) if (one := base / file).exists()), package / file)
            code = source.read_text(encoding="utf-8") if source.exists() else ""
            for name in re.findall(r"`(\w+)`", names):
                seen += 1
                if not re.search(rf"^\s*(?:def|class) {name}\b|^\s*{name}\b *[:=]", code, re.MULTILINE):
                    missing.append(f"{page.name}: {file} {name}")
            if not source.exists():
                missing.append(f"{page.name}: {file}")
    assert not missing
    assert seen > 80


def test_every_column_that_a_run_leaves_is_explained(small):
    result, _ = small
    page = (DOCS / "reference" / "files.md").read_text(encoding="utf-8")
    known = set(re.findall(r"`([^`]+)`", page))
    columns = {*result.forces.columns, *result.balance.columns, *result.walls.columns, *result.snapshots.columns}
    assert columns - {"P", "T", "N"} <= known  # which Result adds
    stored = snapshot.stored({name: values.astype(float) for name, values in result.state(-1).items()})
    assert set(stored) <= set(re.findall(r"`(\w+)`", page))
    assert set(result.summary) <= known
    certificate = (DOCS / "theory" / "certificate.md").read_text(encoding="utf-8")
    source = (Path(taichi_silo.__file__).parent / "runs" / "certificate.py").read_text(encoding="utf-8")
    lines = set(re.findall(r'"(\w+_\w+)"(?:: |\] =)', source)) | set(result.summary["certificate"])
    assert lines <= set(re.findall(r"`([^`]+)`", certificate))
    assert len(lines) > 12

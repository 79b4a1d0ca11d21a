"""Taichi is started afresh for each module: fields of another module are dead."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

AFFINITY = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
if AFFINITY and (worker := os.environ.get("PYTEST_XDIST_WORKER")):
    # each worker has a core of its own, so that runs take one thread: two would wait for each other's turn in vain;
    # before anything makes a scene, whose default is the number of cores
    os.sched_setaffinity(0, {AFFINITY[int(worker.removeprefix("gw")) % len(AFFINITY)]})

from taichi_silo import api
from taichi_silo.cli import flags, model_silo  # noqa: F401 - they hold scenes made when they are imported
from taichi_silo.mpm import joint_steps, language, own_parts, runtime, solver
from taichi_silo.runs import observers
from taichi_silo.runs.point_fields import FIELDS
from tests import untraced  # noqa: F401 - coverage does not watch the language

HERE = Path(__file__).parent
DATA, LONG = HERE / "data", HERE / "long.txt"


@pytest.fixture
def all_cores():
    """For a test whose point is that threads share a step."""
    if not AFFINITY:
        yield
        return
    own = os.sched_getaffinity(0)
    os.sched_setaffinity(0, AFFINITY)
    yield
    os.sched_setaffinity(0, own)


@pytest.hookimpl(tryfirst=True)  # before those with the mark `long` are left out
def pytest_collection_modifyitems(config, items):
    """Mechanics first: all tests of some folders, and those with the mark. Long ones are listed in long.txt."""
    listed = {line for line in LONG.read_text(encoding="utf-8").splitlines() if not line.startswith("#")}
    known = {name for item in items for name in (item.nodeid, item.nodeid.split("[")[0])}
    if config.args == config.getini("testpaths") and (gone := listed - known):
        raise pytest.UsageError(f"{LONG} lists what is no test: {min(gone)}")
    for item in items:
        if listed & {item.nodeid, item.nodeid.split("[")[0]}:
            item.add_marker("long")
        if item.path.parent.name in ("mechanics", "mpm"):
            item.add_marker("mechanics")
    items.sort(key=lambda item: item.get_closest_marker("mechanics") is None)


def pytest_terminal_summary(terminalreporter):
    """How much of the time went into mechanics, added up over all processes."""
    reports = [one for group in terminalreporter.stats.values() for one in group if hasattr(one, "duration")]
    mechanics = sum(one.duration for one in reports if "mechanics" in one.keywords)
    terminalreporter.write_line(f"mechanics: {mechanics:.0f} of {sum(one.duration for one in reports):.0f} s")


def pytest_addoption(parser):
    parser.addoption("--renew-curves", action="store_true", help="write the stored force curves anew")


def plain(request):
    """Whether a module's sand steps plainly (see `loops`)."""
    return not getattr(request.module, "LANES", "unit" not in request.path.relative_to(HERE).parts)


@pytest.fixture(autouse=True, scope="module")
def taichi(request):
    """Taichi for the module; single formulas are compiled without the optimiser, a quarter of the time."""
    with pytest.MonkeyPatch.context() as patch:
        if plain(request):
            patch.setenv(f"{'TI' if language.NAME == 'taichi' else 'QD'}_ADVANCED_OPTIMIZATION", "0")
        runtime.init()
        yield


@pytest.fixture(autouse=True, scope="module")
def plugins():
    """What the module's tests register is forgotten after it."""
    kept = [(table, dict(table)) for table in (own_parts.LAWS, own_parts.CONTACTS, FIELDS, observers.REGISTERED)]
    yield
    for table, before in kept:
        table.clear()
        table.update(before)


@pytest.fixture
def afresh():
    """Taichi anew before the test: compiled kernels that are kept know fields by their numbers, which start again."""
    runtime.init()


@pytest.fixture(autouse=True, scope="module")
def loops(request):
    """Sand steps eight points at once, as users' does; tests of single formulas, in tests/unit, step plainly.

    For eight points a kernel takes twice as long to compile, and those tests have a kernel each. A module says
    otherwise with LANES = True or False. For the same reason a launch with atomic sums, in which every step is compiled
    anew, has two steps instead of eight.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(joint_steps, "BURST", 2)
        if plain(request):
            patch.setattr(solver, "hindrance", lambda solver: "this test does without")
        yield


@pytest.fixture(scope="module")
def bare():
    """Runs draw no figures, which take longer than small runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(api, "DRAWING", ())
        yield


@pytest.fixture
def renew_curves(request):
    return request.config.getoption("--renew-curves")


@pytest.fixture
def data():
    return DATA


@pytest.fixture
def tried(record_property):
    """A function that counts what a test has tried, for the table of trust: group, what, how many."""
    return lambda group, what, count=1: record_property("tried", [group, what, count])


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The documentation as `make docs` builds it, every warning an error; once for all processes of the tests."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
    place, built = shared / "site", shared / "site.built"
    try:
        (shared / "site.lock").mkdir()
    except FileExistsError:
        until = time.monotonic() + 300.0
        while not built.exists():
            assert time.monotonic() < until, "another process has not built it"
            time.sleep(0.2)
    else:
        command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(place)]
        done = subprocess.run(
            command, cwd=Path(__file__).parents[1], capture_output=True, text=True, env=os.environ | {"NO_COLOR": "1"}
        )
        built.write_text("" if done.returncode == 0 else done.stdout + done.stderr, encoding="utf-8")
    trouble = built.read_text(encoding="utf-8")
    assert not trouble, trouble[-3000:]
    return place


@pytest.fixture(scope="session")
def small_run():
    """A function that leaves the folder of a real run of seconds: 40 points, a film of two seconds if it is wanted."""
    from taichi_silo import Flow, Machine, Mesh, Method, Scene, Silo, run
    from taichi_silo.runs.observers import film_recorder

    def leave(folder, film=False, walls="smooth", silo=None, **parts):
        scene = {
            "silo": silo or Silo(), "walls": model_silo.walls(walls, 0.60), "grid": Mesh(cell_size_m=0.05),
            "flow": Flow(speed_m_per_s=0.02, displacement_m=0.01), "method": Method(filling_time_s=0.2),
            "machine": Machine(threads=1, lanes=False),
        }  # fmt: skip
        with pytest.MonkeyPatch.context() as patch:
            patch.setitem(film_recorder.FRAMES, "filling", 10)
            patch.setitem(film_recorder.FRAMES, "flow", 50)
            return run(Scene(**scene | parts), folder, film=film, progress=False).folder

    return leave

"""Taichi is started afresh for each module: fields of another module are dead."""

import os

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")

import subprocess
import sys
import time
from pathlib import Path

import pytest

from taichi_silo import runtime
from taichi_silo.lanes import Lanes

DATA = Path(__file__).parent / "data"


def pytest_addoption(parser):
    parser.addoption("--renew-curves", action="store_true", help="write the stored force curves anew")


@pytest.fixture(autouse=True, scope="module")
def taichi():
    runtime.init()


@pytest.fixture(autouse=True, scope="module")
def loops(request):
    """Lanes compile five times as long as the plain loop, of which they are proved to be the equal (test_lanes.py).

    Only modules with LANES = True step with them; others would spend most of their time on compilation.
    """
    with pytest.MonkeyPatch.context() as patch:
        if not getattr(request.module, "LANES", False):
            patch.setattr(Lanes, "why_not", staticmethod(lambda solver: "this test does without"))
        yield


@pytest.fixture
def renew_curves(request):
    return request.config.getoption("--renew-curves")


@pytest.fixture
def data():
    return DATA


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The documentation as `make docs` builds it, every warning an error; once for all processes of the tests."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
    place, built = shared / "site", shared / "site.built"
    try:
        (shared / "site.lock").mkdir()
    except FileExistsError:
        while not built.exists():
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

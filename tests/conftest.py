"""Taichi is started afresh for each module: fields of another module are dead."""

import os

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")

from pathlib import Path

import pytest

from taichi_silo import runtime

DATA = Path(__file__).parent / "data"


def pytest_addoption(parser):
    parser.addoption("--renew-curves", action="store_true", help="write the stored force curves anew")


@pytest.fixture(autouse=True, scope="module")
def taichi():
    runtime.init()


@pytest.fixture
def renew_curves(request):
    return request.config.getoption("--renew-curves")


@pytest.fixture
def data():
    return DATA

"""Lanes that cannot be trusted are not used, and never take the process with them."""

import json
import sys

import pytest

from taichi_silo.mpm import simd_selftest, simd_trial, solver
from taichi_silo.scene.scene import Machine, Mesh, Scene
from taichi_silo.simulation import simulation

LANES = True  # see conftest.py

COARSE = Scene(grid=Mesh(cell_size_m=0.1), machine=Machine(threads=1))


@pytest.fixture
def forgetful(monkeypatch, tmp_path):
    """No verdict in memory or on disk."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    simd_selftest.failure.cache_clear()
    yield
    simd_selftest.failure.cache_clear()


def interpreter(tmp_path, script):
    """Something that is run in place of Python."""
    file = tmp_path / "python"
    file.write_text(f"#!/bin/sh\n{script}\n")
    file.chmod(0o755)
    return str(file)


@pytest.mark.parametrize(
    ("script", "why"),
    [("kill -6 $$", "ended with code -6"), ("echo lanes differ; exit 1", "lanes differ"), ("exit 7", "code 7")],
)
def test_a_trial_that_aborts_or_differs_is_a_reason_not_an_end(forgetful, monkeypatch, tmp_path, script, why):
    monkeypatch.setattr(sys, "executable", interpreter(tmp_path, script))
    assert why in simd_selftest.failure()
    assert why in json.loads(simd_selftest.place().read_text())["failure"]


def test_a_verdict_is_kept_until_circumstances_change(forgetful, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "executable", interpreter(tmp_path, "echo once; exit 1"))
    assert simd_selftest.failure() == "once"
    monkeypatch.setattr(sys, "executable", interpreter(tmp_path, "exit 0"))
    simd_selftest.failure.cache_clear()
    assert simd_selftest.failure() == "once"
    monkeypatch.setattr(simd_selftest, "circumstances", lambda: "another processor")
    simd_selftest.failure.cache_clear()
    assert simd_selftest.failure() == ""


def test_a_broken_file_of_verdicts_is_no_verdict(forgetful, monkeypatch, tmp_path):
    simd_selftest.place().parent.mkdir(parents=True)
    simd_selftest.place().write_text("{")
    monkeypatch.setattr(sys, "executable", interpreter(tmp_path, "exit 0"))
    assert simd_selftest.failure() == ""


def test_without_trust_the_plain_loop_runs_and_the_run_says_why(monkeypatch):
    monkeypatch.setattr(solver, "failure", lambda: "the trial ended with code -6")
    silo = simulation.Simulation(COARSE)
    assert silo.solver.lanes is None
    assert any("vector unit is not used: the trial ended with code -6" in warning for warning in silo.warnings)


def test_lanes_can_be_left_out_by_the_scene():
    without = COARSE.model_copy(update={"machine": Machine(threads=1, lanes=False)})
    silo = simulation.Simulation(without)
    assert silo.solver.lanes is None
    assert not any("vector unit" in warning for warning in silo.warnings)


def test_the_trial_passes_here():
    assert simd_trial.compare() == ""

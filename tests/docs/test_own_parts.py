"""The parts of a user's own that the page shows, in the files that it shows, used as it says."""

import json
import math
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from written import DOCS, blocks

import taichi_silo as ts
from taichi_silo.cli import app
from taichi_silo.runs.plugins import load_plugin
from taichi_silo.studies.sweep.runs import Run
from tests.smallest import SMALLEST, smallest

LANES = True  # as users run
PAGE = "how-to/own-parts.md"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The folder of the files of the page."""
    folder = tmp_path_factory.mktemp("own")
    for block in blocks("python", "toml"):
        if block.page == PAGE and block.title:
            (folder / block.title).write_text(block.text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def run(files, tmp_path_factory):
    """The page's run, by the program in a process of its own, where eight points step at once."""
    folder = tmp_path_factory.mktemp("run") / "silo"
    words = ("run", "silo.toml", "--no-film", "--no-figures", "--set", "machine.threads=1", "--plugin", "my_parts.py")
    command = [sys.executable, "-m", "taichi_silo.cli.app", *words, "--output", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=files)
    assert done.returncode == 0, done.stderr[-2000:]
    load_plugin(files / "my_parts.py")
    return ts.Result(folder)


def test_a_law_of_one_s_own_presses_on_smooth_walls_as_janssen_says_with_its_own_k0(run):
    found = run.summary["janssen"]
    assert found["pressure_ratio_K0"] == pytest.approx(0.3 / 0.7)
    assert found["normal_N_per_m_K0_relative_difference"] == pytest.approx(0.011, abs=0.003)
    assert "1.1 %" in (DOCS / PAGE).read_text(encoding="utf-8")
    assert run.filled["P"] + 2.0 * run.filled["T"] == pytest.approx(run.summary["weight_N_per_m"], rel=1e-3)


def test_what_it_computes_is_the_same_for_eight_points_at_once_and_for_one(run, tmp_path):
    plain = ts.run(run.scene, tmp_path / "plain", film=False, figures=False, progress=False).forces
    for name in ("bottom_force_N_per_m", "left_normal_N_per_m"):
        assert plain[name].to_numpy() == pytest.approx(run.forces[name].to_numpy(), rel=1e-6, abs=1e-6)


def test_the_run_notes_the_file_and_a_process_of_a_sweep_loads_it(files, run):
    file = str((files / "my_parts.py").resolve())
    assert file in pd.Series(run.program["plugins"]).to_list()
    line = Run(run.scene, run.folder).to_json()
    assert file in json.loads(line)["plugins"] and Run.from_json(line)[0].scene == run.scene


def test_a_piece_of_it_fails_at_its_friction_angle_as_the_page_says(files):
    (text,) = (one.text for one in blocks("python") if one.page == PAGE and not one.title)
    load_plugin(files / "my_parts.py")
    known = {}
    exec(text.replace('"my_parts.py"', repr(str(files / "my_parts.py"))), known)
    assert known["test"].curve.friction_angle_deg.max() == pytest.approx(30.0, abs=0.005)
    e = known["test"].curve.void_ratio
    assert e.iloc[-1] == pytest.approx(e.iloc[len(e) // 2], abs=1e-6)  # it slides without a change of volume


def test_a_contact_of_one_s_own_carries_what_sinks_with_its_friction_angle(files, tmp_path):
    load_plugin(files / "lapped.py")
    walls = ts.Walls(kind="lapped", constants={"friction_angle_deg": 25.0})
    found = ts.run(smallest(walls=walls), tmp_path / "lapped", film=False, progress=False)
    assert found.residual["T"] / found.residual["N"] == pytest.approx(math.tan(math.radians(25.0)), rel=0.01)
    assert "contact of a plugin, lapped" in ts.report(found).read_text(encoding="utf-8")
    hopper = {"silo": {"outline_m": [[0.05, 0], [0.15, 0], [0.2, 0.2], [0.2, 0.4], [0, 0.4], [0, 0.2]]}}
    with pytest.raises(ValueError, match="walls are lapped; a registered contact acts on vertical walls only"):
        ts.Scene.model_validate({"walls": walls} | hopper)


def test_a_field_of_one_s_own_is_drawn_and_exported(files, run, tmp_path):
    words = ("render", run.folder, "--field", "sinking", "--frame", "2", "--size", "320x180", "--quiet")
    line = app.plugins_first(
        [*map(str, words), "--output", str(tmp_path / "a.png"), f"--plugin={files / 'sinking.py'}"]
    )
    app.make()(line, standalone_mode=False)
    assert (tmp_path / "a.png").stat().st_size > 1000
    ts.export(run, tmp_path / "csv", kind="csv")
    last = sorted((tmp_path / "csv").glob("flow*.csv"))[-1]
    table = pd.read_csv(last)
    assert table.sinking_mm_per_s.to_numpy() == pytest.approx(-1e3 * table.velocity_y_m_per_s, rel=1e-5, abs=1e-9)
    assert np.median(table.sinking_mm_per_s) == pytest.approx(10.0, rel=0.05)


def test_an_observer_of_one_s_own_sees_every_run(files, tmp_path, capsys):
    load_plugin(files / "heaviest.py")
    found = ts.run(SMALLEST, tmp_path / "seen", film=False, figures=False, progress=False)
    (line,) = (one for one in capsys.readouterr().out.splitlines() if one.startswith("largest bottom force"))
    assert float(line.split()[3]) == pytest.approx(found.forces["bottom_force_N_per_m"].max(), abs=1.0)

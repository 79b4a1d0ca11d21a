"""What the commands do, Python does too, on the same runs; and errors are in the words of who asks."""

import numpy as np
import pandas as pd
import pytest

import taichi_silo as ts
from taichi_silo.errors import Way, way
from taichi_silo.studies.sweep.study import Study
from tests import made_up
from tests.smallest import SMALLEST


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    base = tmp_path_factory.mktemp("python")
    return [made_up.leave(base / name, states=12) for name in ("one", "two")]


def test_a_page_is_written_for_a_result_or_its_folder(folders, tmp_path):
    assert ts.report(ts.Result(folders[0])) == folders[0] / "report.html"
    page = ts.report(str(folders[0]), tmp_path / "page.html")
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_runs_are_compared_as_frames_and_written_only_where_told(folders, tmp_path):
    found = ts.compare([ts.Result(one) for one in folders])
    assert isinstance(found, ts.Comparison) and found.files == [] and found.deviations is None
    assert np.abs(found.differences.difference_percent.dropna()).max() == 0.0  # the two are alike
    (tmp_path / "m.csv").write_text("displacement_mm,P_kN_per_m\n1,0.5\n5,0.4\n")
    beside = ts.compare(folders[0], tmp_path / "out", csv=tmp_path / "m.csv", janssen=True)
    assert {file.name for file in beside.files} >= {"deviation.csv", "janssen.csv", "compare_forces.png"}
    assert pd.read_csv(tmp_path / "out" / "deviation.csv").points.iloc[0] == beside.deviations.points.iloc[0] > 0


def test_an_export_is_followed_state_by_state(folders, tmp_path):
    seen = []
    done = ts.export(folders[0], tmp_path / "a.vtkhdf", tracked=lambda steps: (seen.append(k) or k for k in steps))
    assert done.states == 14 and seen == list(range(14)) and done.file.is_file()
    assert ts.export(folders[0], tmp_path / "tables", kind="csv").file.is_dir()


@pytest.mark.parametrize(
    ("ask", "python", "command_line"),
    [
        (lambda runs: ts.run(SMALLEST, runs[0]), "overwrite=True to replace it", "--overwrite to replace it"),
        (lambda runs: ts.compare(runs[0]), "with janssen=True or csv=[...]", "with --janssen or --csv FILE"),
        (lambda runs: ts.export(runs[0], runs[0] / "run.toml"), "or overwrite=True to replace it", "or --overwrite"),
        (lambda runs: ts.render(runs[0], runs[0] / "run.toml.png", frame=1.0), "overwrite=True", "--overwrite"),
        (lambda runs: ts.render(runs[0], "a.mp4", transparent=True), "a .png with frame", "a .png with --frame"),
    ],
)
def test_an_error_speaks_python_in_python_and_flags_on_the_command_line(folders, ask, python, command_line):
    (folders[0] / "run.toml.png").touch()
    with pytest.raises(ts.BadInput) as refused:
        ask(folders)
    assert python in str(refused.value) and "--" not in str(refused.value)
    assert command_line in refused.value.on_command_line and python not in refused.value.on_command_line


def test_a_way_reads_in_both_words():
    assert (str(way("overwrite")), way("overwrite").command_line) == ("overwrite=True", "--overwrite")
    assert way("cell_size", 0.01) == Way("cell_size=0.01", "--cell-size 0.01")
    assert ts.BadInput("no way named").on_command_line == "no way named"


def test_a_sweep_takes_a_scene_its_tables_or_files_and_says_what_varies(tmp_path):
    (tmp_path / "silo.toml").write_text("[silo]\nwidth_m = 0.2\nheight_m = 0.4\n[grid]\ncell_size_m = 0.05\n")
    grid = {"flow.speed_m_per_s": [0.02, 0.04]}
    from taichi_silo.studies.sweep.plan import from_tables
    from taichi_silo.utils.console import Console

    for scene in (SMALLEST, tmp_path / "silo.toml", {"silo.width_m": 0.2, "grid.cell_size_m": 0.05}):
        study = Study(from_tables({"scene": scene, "grid": grid}, tmp_path), tmp_path / "out", Console(quiet=True))
        assert [run.scene.flow.speed_m_per_s for run in study.runs.values()] == [0.02, 0.04]
        assert {run.scene.machine.threads for run in study.runs.values()} == {1}
    assert study.runs["speed-0.02"].scene.silo.width_m == 0.2
    with pytest.raises(ts.BadInput, match="nothing varies; a sweep needs a table grid or latin_hypercube"):
        ts.sweep({"scene": SMALLEST}, tmp_path / "out")


def test_a_sweep_of_smallest_silos_returns_a_frame_with_a_row_for_each(tmp_path, capsys):
    study = ts.sweep(
        {"scene": SMALLEST, "grid": {"flow.speed_m_per_s": [0.02, 0.04]}}, tmp_path / "sweep", jobs=1, progress=False
    )
    assert study.failures == {} and study.table.finished.all() and len(study.table) == 2
    assert (study.table.N_filled_N_per_m > 0.0).all()
    assert ts.Result(study.runs["speed-0.02"].folder).scene.flow.speed_m_per_s == 0.02
    assert capsys.readouterr().out == ""
    again = ts.sweep(
        {"scene": SMALLEST, "grid": {"flow.speed_m_per_s": [0.02, 0.04]}}, tmp_path / "sweep", jobs=1, progress=False
    )
    assert not again.missing  # what is finished is kept

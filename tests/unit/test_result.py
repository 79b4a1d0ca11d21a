"""The Python interface: a scene is run, and what it left comes back as frames and arrays."""

import shutil

import numpy as np
import pytest

import taichi_silo as ts

LOW = 1e-9


@pytest.fixture(scope="module")
def result(tmp_path_factory, bare):
    scene = ts.Scene(
        silo=ts.Silo.polygon([(0.05, 0), (0.15, 0), (0.2, 0.1), (0.2, 0.3), (0, 0.3), (0, 0.1)]),
        sand=ts.named_sand("hostun", 0.7),
        walls=ts.Walls(kind="smooth", friction_angle_deg=19.0), grid=ts.Mesh(cell_size_m=0.05),
        flow=ts.Flow(speed_m_per_s=0.02, displacement_m=0.002), machine=ts.Machine(threads=1, lanes=False),
        method=ts.Method(filling_time_s=0.1, longest_settling_s=0.1),
    )  # fmt: skip
    return ts.run(scene, tmp_path_factory.mktemp("run") / "mine", progress=False)


def test_tables_come_back_as_frames(result):
    assert set(result.forces.stage) == {"filling", "flow"}
    assert len(result.forces) == len(result.balance)
    assert result.flow.displacement_m.iloc[-1] == pytest.approx(0.002)
    assert set(result.walls.state) == {"filling", "maximum", "residual"}
    assert result.summary["finished"] and result.finished


def test_after_filling_is_the_mean_over_the_last_period_of_the_column_at_rest(result):
    rows = result.forces[result.forces.stage == "filling"].tail(result.scene.output.records_per_period)
    summary, last = result.summary, result.residual
    for name, key in (("P", "bottom_N_per_m"), ("T", "shear_N_per_m"), ("N", "normal_N_per_m")):
        assert result.filled[name] == summary["filling"][key] == pytest.approx(rows[name].mean(), rel=1e-12)
        assert last[name] == summary["residual"][key]


def test_states_come_back_as_arrays(result):
    filled, last = result.state("filled"), result.state(-1)
    assert filled["position"].shape == (len(filled["mass"]), 2)
    assert filled["mass"].sum() * 9.81 == pytest.approx(result.forces.weight_N_per_m.iloc[-1], rel=1e-6)
    assert last["velocity"][:, 1].mean() < 0.0
    assert (filled["stress"][:, 1] < LOW).all()
    assert np.isfinite(filled["void_ratio"]).all()


def test_the_scene_comes_back_as_it_was_given(result):
    assert result.scene.silo.outline_m[0] == (0.05, 0.0)
    assert result.scene.sand.name == "hostun"
    assert result.program["precision"] == "f64"


def test_a_notebook_shows_the_film(result):
    (result / "void_ratio.mp4").write_bytes(bytes(2000))
    (result / "figures").mkdir(exist_ok=True)
    (result / "figures" / "forces.png").write_bytes(b"")
    page = result._repr_html_()
    assert "<video controls" in page
    assert "P = " in page
    assert result.film.stat().st_size > 1000
    assert "forces" in result.figures


def test_it_stands_for_its_path(result):
    assert (result / "forces.csv").is_file()
    assert ts.Result(result).folder == result.folder


def test_what_is_damaged_is_refused_or_told_and_what_is_not_there_yet_is_empty(result, tmp_path):
    copy = tmp_path / "copy"
    copy.mkdir()
    shutil.copy(result / "run.toml", copy)
    assert ts.Result(copy).forces.empty and ts.Result(copy).walls.empty and ts.Result(copy).filled is None
    (copy / "forces.csv").write_text("time_s,stage\n0.1,filling\n")
    with pytest.raises(ts.BadInput, match="forces.csv has no column displacement_m"):
        _ = ts.Result(copy).forces
    tolerant = ts.Result(copy, tolerant=True)
    assert tolerant.forces.empty and tolerant.trouble == ("forces.csv is damaged and was left out.",)


def test_a_folder_without_a_run_is_refused(tmp_path, result):
    with pytest.raises(ts.BadInput, match="that of a run"):
        ts.Result(tmp_path)
    with pytest.raises(ts.BadInput, match="filled"):
        result.state("end of time")
    with pytest.raises(ts.BadInput, match="its number"):
        result.state(99)


def test_every_public_name_is_there():
    for name in ts.__all__:
        assert getattr(ts, name).__doc__, name
    with pytest.raises(AttributeError, match="nothing"):
        _ = ts.nothing

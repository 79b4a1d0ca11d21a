"""Exports: what ParaView's own readers find in them is what the snapshots hold."""

import json

import numpy as np
import pandas as pd
import pytest
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from taichi_silo.cli import app
from taichi_silo.errors import BadInput
from taichi_silo.runs import snapshot
from taichi_silo.runs.point_fields import FIELDS
from taichi_silo.runs.result import Result
from taichi_silo.show.export import vtkhdf
from tests import made_up

COLUMNS = (
    "identity x_m y_m void_ratio velocity_x_m_per_s velocity_y_m_per_s stress_xx_Pa stress_yy_Pa stress_zz_Pa "
    "stress_xy_Pa mean_stress_Pa volume_m2_per_m mass_kg_per_m strain_path speed_mm_per_s mobilised_friction_deg layer"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run from which sand leaves, so that states have different numbers of points."""

    def gone(points, part):
        return points["identity"] < 40.0 * part

    return made_up.leave(tmp_path_factory.mktemp("runs") / "silo", states=12, left=gone)


def command(*words):
    return app.make()(list(map(str, words)), standalone_mode=False)


@pytest.fixture(scope="module")
def reader(folder):
    command("export", folder, "--quiet")
    found = vtk.vtkHDFReader()
    found.SetFileName(str(folder / "silo.vtkhdf"))
    found.UpdateInformation()
    return found


def test_the_series_has_all_states_with_their_times(folder, reader):
    times = Result(folder).snapshots["time_s"].tolist()
    found = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert list(found) == times and reader.GetNumberOfSteps() == 14
    stored = sum(file.stat().st_size for file in (folder / "snapshots").glob("*.vtu"))
    assert (folder / "silo.vtkhdf").stat().st_size < stored + 100e3  # what an empty file of such arrays needs


@pytest.mark.parametrize("number", [0, 1, 6, 13])
def test_each_state_of_the_series_is_that_of_its_snapshot(folder, reader, number):
    history = Result(folder)
    points = history.state(number)
    reader.SetStep(number)
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetClassName() == "vtkUnstructuredGrid"
    assert grid.GetNumberOfPoints() == grid.GetNumberOfCells() == len(points["mass"])
    assert {grid.GetCellType(k) for k in (0, grid.GetNumberOfCells() - 1)} == {vtk.VTK_VERTEX}
    assert grid.GetCell(3).GetPointId(0) == 3
    place = vtk_to_numpy(grid.GetPoints().GetData())
    assert (place[:, :2] == points["position"]).all() and (place[:, 2] == 0.0).all()
    arrays = {
        grid.GetPointData().GetArrayName(k): vtk_to_numpy(grid.GetPointData().GetArray(k))
        for k in range(grid.GetPointData().GetNumberOfArrays())
    }
    stored = snapshot.stored(points)
    assert set(arrays) == set(stored) | {"speed_mm_per_s", "mobilised_friction_deg", "layer"}
    assert all((arrays[name] == values).all() for name, values in stored.items())
    friction = FIELDS["mobilised_friction"].values(points, history.start, history.scene)
    assert arrays["mobilised_friction_deg"] == pytest.approx(friction, rel=1e-6)


def test_a_reader_that_asks_for_a_time_gets_the_state_of_that_time(folder, reader):
    reader.UpdateTimeStep(Result(folder).snapshots["time_s"].iloc[9])
    assert reader.GetStep() == 9


def test_the_list_of_snapshots_opens_with_the_xml_reader(folder):
    index = Result(folder).snapshots
    for file in index["file"].iloc[[0, -1]]:
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(folder / "snapshots" / file))
        reader.Update()
        points = snapshot.read(folder / "snapshots" / file)
        assert reader.GetErrorCode() == 0
        velocity = vtk_to_numpy(reader.GetOutput().GetPointData().GetArray("velocity"))
        assert velocity[:, :2] == pytest.approx(points["velocity"], rel=1e-6)


def test_tables_have_units_in_their_names_and_the_digits_of_the_snapshots(folder, tmp_path):
    command("export", folder, "--format", "csv", "--output", tmp_path / "tables", "--quiet")
    index = pd.read_csv(tmp_path / "tables" / "index.csv")
    assert len(list((tmp_path / "tables").iterdir())) == len(index) + 1 == 15
    points = Result(folder).state(13)
    table = pd.read_csv(tmp_path / "tables" / index.file.iloc[13])
    assert list(table.columns) == COLUMNS.split()
    assert (table.identity == points["identity"]).all()
    assert table[["x_m", "y_m"]].to_numpy() == pytest.approx(points["position"], rel=1e-9, abs=1e-12)
    assert table.stress_yy_Pa.to_numpy() == pytest.approx(points["stress"][:, 1], rel=1e-6)
    assert table.speed_mm_per_s.to_numpy() == pytest.approx(1e3 * np.hypot(*points["velocity"].T), rel=1e-6)


def test_the_program_tells_where_and_how_much(folder, tmp_path, capsys):
    command("export", folder, "--output", tmp_path / "a.vtkhdf", "--json")
    told = json.loads(capsys.readouterr().out)
    assert told == {
        "output": str(tmp_path / "a.vtkhdf"), "format": "vtkhdf", "states": 14,
        "bytes": (tmp_path / "a.vtkhdf").stat().st_size,
    }  # fmt: skip


def test_an_export_that_fails_leaves_nothing(folder, tmp_path):
    def fails():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        vtkhdf.write(Result(folder), tmp_path / "a.vtkhdf", fails)
    assert not list(tmp_path.iterdir())


def test_what_is_not_possible_is_refused_in_a_sentence(folder, tmp_path):
    with pytest.raises(BadInput, match="format is xml; it must be one of vtkhdf, csv"):
        command("export", folder, "--format", "xml")
    (tmp_path / "mine.vtkhdf").write_text("mine")
    with pytest.raises(BadInput, match="is there already; give another name, or --overwrite"):
        command("export", folder, "--output", tmp_path / "mine.vtkhdf")
    assert (tmp_path / "mine.vtkhdf").read_text() == "mine"
    command("export", folder, "--output", tmp_path / "mine.vtkhdf", "--overwrite", "--quiet")
    with pytest.raises(BadInput, match="it must be a folder for csv"):
        command("export", folder, "--format", "csv", "--output", tmp_path / "mine.vtkhdf", "--overwrite")

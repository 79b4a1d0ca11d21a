"""Exports: what ParaView's own readers find in them is what the snapshots hold."""

import json

import h5py
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
from taichi_silo.scene.silo import Insert, Outlet, Silo
from taichi_silo.show.export import outline, vtkhdf
from taichi_silo.show.export.whole import export
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
    assert all((arrays[name] == values).all() for name, values in stored.items() if name != "stress_Pa")
    friction = FIELDS["mobilised_friction"].values(points, history.start, history.scene)
    assert arrays["mobilised_friction_deg"] == pytest.approx(np.nan_to_num(friction), rel=1e-6)
    assert all(np.isfinite(values).all() for values in arrays.values())


def test_stress_is_a_symmetric_tensor_whose_trace_and_invariants_are_those_of_the_points(folder, reader):
    reader.SetStep(5)
    reader.Update()
    array = reader.GetOutput().GetPointData().GetArray("stress_Pa")
    assert array.GetNumberOfComponents() == 6  # as ParaView takes a symmetric tensor: XX YY ZZ XY YZ XZ
    xx, yy, zz, xy, yz, xz = vtk_to_numpy(array).T
    given = Result(folder).state(5)["stress"]
    assert np.column_stack([xx, yy, zz, xy]) == pytest.approx(given, rel=1e-6) and not yz.any() and not xz.any()
    shares = vtk.vtkTensorPrincipalInvariants()
    shares.SetInputData(reader.GetOutput())
    shares.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "stress_Pa")
    shares.Update()
    found = shares.GetOutput().GetPointData()
    names = [found.GetArrayName(k) for k in range(found.GetNumberOfArrays())]
    sigma = np.sort([vtk_to_numpy(found.GetArray(name)) for name in names if name.endswith(("1", "2", "3"))], axis=0)
    centre, radius = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    assert sigma == pytest.approx(np.sort([centre + radius, centre - radius, zz], axis=0), rel=1e-4, abs=1e-3)


def test_a_value_that_is_missing_is_0_in_vtk_and_nothing_in_a_table(folder, tmp_path):
    copy = made_up.leave(tmp_path / "free", states=10)
    start = Result(copy).state(0)
    start["stress"] = 0.0 * start["stress"]
    snapshot.write(copy / "snapshots" / "start.vtu", start)
    export(copy)
    export(copy, kind="csv")
    with h5py.File(copy / "silo.vtkhdf") as file:
        arrays = file["VTKHDF/PointData"]
        assert all(np.isfinite(arrays[name]).all() for name in arrays)
        assert not arrays["mobilised_friction_deg"][: len(start["mass"])].any()
        units = {name: arrays[name].attrs["units"] for name in arrays}
    assert units["velocity"] == "m/s" and units["stress_Pa"] == "Pa" and units["void_ratio"] == "1"
    assert units["volume_m2_per_m"] == "m2/m" and units["mass_kg_per_m"] == "kg/m"
    assert units["speed_mm_per_s"] == "mm/s" and units["mobilised_friction_deg"] == "deg"
    assert pd.read_csv(copy / "csv" / "start.csv").mobilised_friction_deg.isna().all()
    assert "nan" not in (copy / "csv" / "start.csv").read_text()


def test_the_walls_are_beside_the_points_and_follow_the_bottom(folder, reader):
    walls = vtk.vtkHDFReader()
    walls.SetFileName(str(folder / "silo_walls.vtkhdf"))
    walls.UpdateInformation()
    index = Result(folder).snapshots
    assert walls.GetNumberOfSteps() == reader.GetNumberOfSteps()
    for number in (0, 13):
        walls.SetStep(number)
        walls.Update()
        grid = walls.GetOutput()
        assert {grid.GetCellType(k) for k in range(grid.GetNumberOfCells())} == {vtk.VTK_LINE}
        place = vtk_to_numpy(grid.GetPoints().GetData())
        wall = vtk_to_numpy(grid.GetCellData().GetArray("wall"))
        (bottom,) = (grid.GetCell(k).GetBounds() for k in np.flatnonzero(wall == outline.FLOOR))
        sunk = index.displacement_m.iloc[number]
        assert bottom == pytest.approx((0.0, 0.2, -sunk, -sunk, 0.0, 0.0))
        assert place[:, 1].max() == pytest.approx(0.5) and place[:, 1].min() == pytest.approx(-sunk)


def test_the_lines_of_a_silo_with_an_outlet_and_an_insert_leave_the_opening_free():
    roof = Insert(kind="roof", width_m=0.08, height_m=0.1, bottom_m=0.2)
    scene = made_up.scene(silo=Silo(outlet=Outlet(width_m=0.08), inserts=(roof,)))
    corners, lines, wall = outline.wall_lines(scene, 0.02)
    floor = corners[lines[wall == outline.FLOOR]]
    assert (
        floor[..., 0].tolist() == [pytest.approx([0.0, 0.06]), pytest.approx([0.14, 0.2])] and not floor[..., 1].any()
    )
    around = corners[lines[wall == outline.FIRST_INSERT]]
    assert (around[:, 1] == np.roll(around[:, 0], -1, axis=0)).all()  # closed


def test_arrays_of_a_snapshot_have_units_and_names_of_components(folder):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(folder / "snapshots" / "filled.vtu"))
    reader.Update()
    data = reader.GetOutput().GetPointData()
    arrays = {data.GetArrayName(k): data.GetArray(k) for k in range(data.GetNumberOfArrays())}
    units = {name: array.GetInformation().Get(vtk.vtkDataArray.UNITS_LABEL()) for name, array in arrays.items()}
    assert units["velocity"] == "m/s" and units["stress_Pa"] == "Pa" and units["strain_path"] == "1"
    assert None not in units.values()
    assert [arrays["stress_Pa"].GetComponentName(k) for k in range(4)] == ["xx", "yy", "zz", "xy"]


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
        "bytes": sum(file.stat().st_size for file in tmp_path.iterdir()),
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
    with pytest.raises(BadInput, match="is there already; give another name, or overwrite=True"):
        command("export", folder, "--output", tmp_path / "mine.vtkhdf")
    assert (tmp_path / "mine.vtkhdf").read_text() == "mine"
    command("export", folder, "--output", tmp_path / "mine.vtkhdf", "--overwrite", "--quiet")
    with pytest.raises(BadInput, match="it must be a folder for csv"):
        command("export", folder, "--format", "csv", "--output", tmp_path / "mine.vtkhdf", "--overwrite")

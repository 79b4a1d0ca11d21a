"""Snapshots: small files that other programs open, evenly over a run, without a change for those who read the named."""

import xml.etree.ElementTree as ElementTree
from types import SimpleNamespace

import meshio
import numpy as np
import pandas as pd
import pytest
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from taichi_silo.errors import BadInput
from taichi_silo.runs import snapshot
from taichi_silo.runs.observers.snapshots import Snapshots
from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import Flow, Mesh, Output, Scene
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.show.figures.void_ratio import chosen_snapshots
from taichi_silo.simulation.clock import Clock
from taichi_silo.utils import vtu
from tests import made_up
from validation.paper.files import CaseRun

NAMED = ["start.vtu", "filled.vtu", "flow_002.000mm.vtu", "flow_005.000mm.vtu", "flow_010.000mm.vtu"]


@pytest.fixture
def points():
    random = np.random.default_rng(1)
    found = made_up.state(made_up.scene(0.005), 0.013)
    return {
        name: values if name == "identity" else values + 1e-3 * values * random.standard_normal(values.shape)
        for name, values in found.items()
    }


class Course:
    """A simulation that only tells where it is."""

    def __init__(self, scene):
        self.scene, self.stage, self.time, self.displacement = scene, "filling", 0.0, 0.0
        self.model, self.clock = SimpleNamespace(filling_time=0.5), Clock(flow_start=0.6)

    def points(self):
        return made_up.state(made_up.scene(), self.displacement)

    @property
    def names_of_points(self):
        return tuple(self.points())

    def pieces(self, name):
        return [self.points()[name]]

    def record(self, time_s, stage, displacement_m=0.0):
        self.time, self.stage, self.displacement = time_s, stage, displacement_m
        self.clock.steps += 1
        return SimpleNamespace(time_s=time_s, stage=stage, displacement_m=displacement_m)


def written(folder, scene, moved, wanted=(0.002, 0.005, 0.010), between=None):
    """The index that is left, with (time since the opening, displacement) as told."""
    course = Course(scene)
    folder.mkdir(exist_ok=True)
    observer = Snapshots(folder, wanted, scene.snapshots if between is None else between)
    observer.begin(course)
    for time in np.linspace(0.01, 0.6, 60):
        observer.observe(course.record(float(time), "filling"))
    observer.filled()
    for since, displacement in moved:
        observer.observe(course.record(0.6 + since, "flow", displacement))
    observer.end()
    return pd.read_csv(folder / "snapshots" / "index.csv")


SINKING = [(0.001 * k, 1.25e-5 * k) for k in range(1, 801)]  # up to 10 mm in steps of 12.5 um


def scene(**output):
    return Scene(grid=Mesh(cell_size_m=0.02), flow=Flow(displacement_m=0.01), output=Output(**output))


def test_a_state_comes_back_with_its_places_exact(points, tmp_path):
    snapshot.write(tmp_path / "a.vtu", points)
    again = snapshot.read(tmp_path / "a.vtu")
    assert set(again) == set(points)
    assert (again["position"] == points["position"]).all()
    assert (again["identity"] == points["identity"]).all()
    for name, values in points.items():
        assert again[name] == pytest.approx(values, rel=1.2e-7, abs=1e-30)
    assert [file.name for file in tmp_path.iterdir()] == ["a.vtu"]


@pytest.mark.parametrize("rows", [1, 700, 4000])
def test_a_state_that_comes_in_pieces_is_the_same_file(points, tmp_path, rows):
    points["stress"][1234] = np.nan  # left out of both
    snapshot.write(tmp_path / "whole.vtu", points)

    def pieces(name):
        return (points[name][first : first + rows] for first in range(0, len(points[name]), rows))

    snapshot.write_pieces(tmp_path / "pieces.vtu", tuple(points), pieces)
    assert (tmp_path / "whole.vtu").read_bytes() == (tmp_path / "pieces.vtu").read_bytes()


@pytest.mark.parametrize("block", [4000, 4096, 10_000])  # bytes; 4000 int32 are four whole blocks of the first
def test_other_readers_understand_arrays_of_many_blocks(points, tmp_path, monkeypatch, block):
    monkeypatch.setattr(vtu, "BLOCK", block)
    snapshot.write(tmp_path / "a.vtu", points)
    again = snapshot.read(tmp_path / "a.vtu")
    assert (again["position"] == points["position"]).all() and (again["identity"] == points["identity"]).all()
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "a.vtu"))
    reader.Update()
    arrays = reader.GetOutput().GetPointData()
    assert (vtk_to_numpy(arrays.GetArray("stress_Pa")) == points["stress"].astype(np.float32)).all()


def test_a_hundred_states_of_the_four_cases_fit_into_forty_megabytes(points, tmp_path):
    snapshot.write(tmp_path / "a.vtu", points)
    assert len(points["mass"]) == 4000
    assert 116 * (tmp_path / "a.vtu").stat().st_size < 40e6


@pytest.mark.parametrize("keep", [slice(None), slice(0, 1), slice(0, 0)], ids=["many", "one", "none"])
def test_readers_of_vtk_find_the_same_points(points, tmp_path, keep):
    points = {name: values[keep] for name, values in points.items()}
    snapshot.write(tmp_path / "a.vtu", points)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "a.vtu"))
    reader.Update()
    grid, count = reader.GetOutput(), len(points["mass"])
    assert grid.GetNumberOfPoints() == grid.GetNumberOfCells() == count
    if count:
        assert (vtk_to_numpy(grid.GetPoints().GetData())[:, :2] == points["position"]).all()
        assert (vtk_to_numpy(grid.GetPointData().GetArray("identity")) == points["identity"]).all()
        stress = vtk_to_numpy(grid.GetPointData().GetArray("stress_Pa"))
        assert stress == pytest.approx(points["stress"], rel=1e-6)
        mesh = meshio.read(tmp_path / "a.vtu")
        assert np.ravel(mesh.point_data["void_ratio"]) == pytest.approx(points["void_ratio"], rel=1e-6)
    assert len(snapshot.read(tmp_path / "a.vtu")["mass"]) == count


def test_snapshots_that_meshio_wrote_are_still_read(points, tmp_path):
    count = len(points["mass"])
    arrays = snapshot.stored(points) | {"identity": points["identity"], "void_ratio": points["void_ratio"]}
    place = np.column_stack([points["position"], np.zeros(count)])
    mesh = meshio.Mesh(place, [("vertex", np.arange(count)[:, None])], point_data=arrays)
    mesh.write(tmp_path / "old.vtu")
    again = snapshot.read(tmp_path / "old.vtu")
    assert (again["position"] == points["position"]).all() and (again["void_ratio"] == points["void_ratio"]).all()


def test_points_that_are_not_finite_are_left_out(points, tmp_path):
    points["stress"][3, 1], points["position"][7, 0] = np.nan, np.inf
    snapshot.write(tmp_path / "a.vtu", points)
    assert sorted(set(points["identity"]) - set(snapshot.read(tmp_path / "a.vtu")["identity"])) == [3, 7]


@pytest.mark.parametrize(
    "spoil, sentence",
    [
        (lambda file: file.unlink(), "is missing"),
        (lambda file: file.write_text("<broken"), "it is damaged"),
        (lambda file: file.write_text(file.read_text()[:3000]), "it is damaged"),
        (lambda file: file.write_text(file.read_text().replace("strain_path", "other")), "holds no strain_path"),
    ],
)
def test_a_bad_snapshot_is_told_in_a_sentence(points, tmp_path, spoil, sentence):
    snapshot.write(tmp_path / "a.vtu", points)
    spoil(tmp_path / "a.vtu")
    with pytest.raises(BadInput, match=sentence):
        snapshot.read(tmp_path / "a.vtu")


def test_a_hundred_snapshots_are_even_in_displacement_and_ten_in_the_filling(tmp_path):
    index = written(tmp_path, scene(), SINKING)
    flow = index[index.stage == "flow"].drop_duplicates("displacement_m").query("displacement_m > 0")
    assert len(flow) == 100
    assert np.diff(flow.displacement_m) == pytest.approx(1e-4, abs=1.3e-5)
    between = index[index.file.str.startswith("film_")]
    assert (between.stage == "filling").sum() == 10
    assert index.file.is_unique and index.time_s.is_monotonic_increasing
    assert {file.name for file in (tmp_path / "snapshots").glob("*")} == {*index.file, "index.csv", "silo.pvd"}


def test_the_named_snapshots_do_not_depend_on_how_many_stand_between_them(tmp_path):
    few, many = (written(tmp_path / f"{count}", scene(), SINKING, between=count) for count in (0, 100))
    assert few.file.tolist() == NAMED
    assert snapshot.figured(many).reset_index(drop=True).equals(few)


def test_an_end_between_two_intervals_is_always_written(tmp_path):
    moved = SINKING[:408]  # the last one is due for the film as well
    index = written(tmp_path, scene(), moved, wanted=(0.002, 0.01))
    assert snapshot.figured(index).file.tolist() == ["start.vtu", "filled.vtu", "flow_002.000mm.vtu", "end.vtu"]


def test_free_outflow_is_followed_by_what_has_left_and_by_time(tmp_path):
    silo, flow = Silo(outlet=Outlet(width_m=0.08)), Flow(outflow="gravity", displacement_m=1.25, longest_s=4.0)
    gravity = Scene(silo=silo, grid=Mesh(cell_size_m=0.02), flow=flow)
    moved = [(0.002 * k, min(0.0025 * k, 1.0)) for k in range(1, 1501)]  # all has left after 0.8 s of 3 s
    index = written(tmp_path, gravity, moved, wanted=(0.025, 0.125))
    times = index[index.file.str.startswith("film_") & (index.stage == "flow")].time_s.to_numpy() - 0.6
    assert (times < 0.81).sum() == 80 - 2  # hundredths of the sand that can leave, less the named
    assert np.diff(times[times > 0.81]) == pytest.approx(0.04, abs=0.003)


def test_large_scenes_are_written_less_often_unless_asked_for():
    assert scene().snapshots == 100
    assert Scene(grid=Mesh(cell_size_m=0.0005)).snapshots == 25  # 400,000 points
    assert Scene(grid=Mesh(cell_size_m=0.0005), output=Output(snapshots=60)).snapshots == 60
    assert scene(snapshots=0).snapshots == 0


def test_the_list_for_paraview_names_all_files_with_their_times(tmp_path):
    index = written(tmp_path, scene(), SINKING[:100])
    entries = ElementTree.parse(tmp_path / "snapshots" / "silo.pvd").getroot().iter("DataSet")
    listed = [(entry.get("file"), float(entry.get("timestep"))) for entry in entries]
    assert [file for file, _ in listed] == index.file.tolist()
    assert [time for _, time in listed] == pytest.approx(index.time_s.tolist())


def test_figures_and_measures_choose_among_the_named(tmp_path):
    folder = made_up.leave(tmp_path / "dense_very-rough_bottom", states=40)
    shown = [row["file"] for row in chosen_snapshots(Result(folder)) if row is not None]
    named = [f"flow_{u:07.3f}mm.vtu" for u in (2, 5, 10, 20)]
    assert shown == ["filled.vtu", *named]
    paper = CaseRun(folder)
    for when, file in (("first", named[0]), ("before", named[2]), ("last", named[3])):
        assert (paper.points(when)["position"] == snapshot.read(folder / "snapshots" / file)["position"]).all()


def test_a_death_while_a_run_goes_on_leaves_nothing_listed_that_is_not_there(tmp_path, points, monkeypatch):
    """What was written after the checkpoint leaves the list before it leaves the disk."""
    snapshots = Snapshots(tmp_path, [])
    snapshots.folder.mkdir()
    snapshots.rows = [
        {"file": name, "stage": "filling", "time_s": 0.1, "displacement_m": 0.0} for name in ("start.vtu", "film_1.vtu")
    ]
    snapshots._list()
    for row in snapshots.rows:
        snapshot.write(snapshots.folder / row["file"], points)

    unlink = type(tmp_path).unlink

    def dies(file, *how, **ways):
        unlink(file, *how, **ways)
        if file.suffix == ".vtu":
            raise KeyboardInterrupt

    monkeypatch.setattr(type(tmp_path), "unlink", dies)
    with pytest.raises(KeyboardInterrupt):
        snapshots.restore(None, {"rows": snapshots.rows[:1], "wanted": [], "due": {}})
    assert pd.read_csv(snapshots.folder / "index.csv")["file"].tolist() == ["start.vtu"]
    assert [file.name for file in snapshots.folder.glob("*.vtu")] == ["start.vtu"]

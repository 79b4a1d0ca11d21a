"""What is drawn and written of a run whose silo is empty in the end."""

import pytest

from taichi_silo.runs.point_fields import FIELDS
from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import Flow
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.show.export import tables, vtkhdf
from taichi_silo.show.figures import plot_run
from taichi_silo.show.film.films import still
from taichi_silo.show.film.look import Look
from taichi_silo.show.report.page import report
from tests import made_up


@pytest.fixture(scope="module", params=["gravity", "controlled"])
def run(request, tmp_path_factory):
    """Sand that has all gone after seven tenths of the way."""
    flow = Flow(outflow=request.param, speed_m_per_s=0.02, displacement_m=0.02, longest_s=1.0)
    what = made_up.scene(silo=Silo(outlet=Outlet(width_m=0.08)), flow=flow)

    def gone(points, part):
        return (points["mass"] > 0.0) & (part > 0.7)

    folder = made_up.leave(tmp_path_factory.mktemp("empty") / "run", what, left=gone)
    assert len(Result(folder).state(-1)["mass"]) == 0
    return Result(folder)


def test_figures_and_report_show_what_there_was(run):
    assert {"forces", "void_ratio"} <= {file.stem for file in plot_run(run.folder)}
    assert report(run.folder).stat().st_size > 10_000


@pytest.mark.parametrize("field", sorted(FIELDS))
def test_a_picture_of_an_empty_silo_shows_its_walls(run, field, tmp_path):
    still(run, tmp_path / "last.png", -1, Look(field=field, size=(320, 240)))
    assert (tmp_path / "last.png").stat().st_size > 500


def test_exports_have_a_state_without_points(run, tmp_path):
    vtkhdf.write(run, tmp_path / "silo.vtkhdf")
    tables.write(run, tmp_path / "csv")
    assert len(list((tmp_path / "csv").glob("*.csv"))) >= len(run.snapshots)

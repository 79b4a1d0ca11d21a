"""Fills that are not level from wall to wall: columns, heaps, layers; and what is measured of a collapse."""

import math
from importlib import util

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError

from taichi_silo.analysis.measure.surface_profile import SurfaceProfile
from taichi_silo.cli import catalogue
from taichi_silo.runs import snapshot
from taichi_silo.runs.collapse_findings import collapse_findings, first_length_m
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.runs.theories import janssen_of
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.scene.silo import Silo
from taichi_silo.show.figures.collapse import run_collapse_figure
from taichi_silo.utils.schema import one_sentence

COLUMN = {"silo": {"width_m": 0.4, "height_m": 0.1, "column_m": [0.0, 0.1]}, "flow": {"outflow": "collapse"}}
HEAP = {"silo": {"surface_m": [[0.0, 0.1], [0.1, 0.2], [0.2, 0.1]]}}


def scene(tables=COLUMN, **parts):
    return Scene.model_validate({name: tables.get(name, {}) | parts.get(name, {}) for name in {*tables, *parts}})


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"silo": {"column_m": [0.0, 0.1]}}, ["outflow is controlled", "column can only collapse"]),
        ({"flow": {"outflow": "collapse"}}, ["outflow is collapse", "silo.column_m"]),
        ({"silo": {"column_m": [0.0, 0.2]}, "flow": {"outflow": "collapse"}}, ["0 to 0.2 m", "leave free width"]),
        ({"silo": {"column_m": [0.1, 0.05]}, "flow": {"outflow": "collapse"}}, ["0.1 to 0.05 m", "in order"]),
        ({"silo": {"column_m": [0.0, 0.1], "outlet": {"width_m": 0.05}}, "flow": {"outflow": "collapse"}},
         ["has an outlet", "closed level floor"]),
        ({"silo": {"column_m": [0.0, 0.103]}, "flow": {"outflow": "collapse"}, "grid": {"cell_size_m": 0.01}},
         ["x = 0.103 m", "on the grid"]),
        ({"silo": {"section": "round", "column_m": [0.0, 0.1]}, "flow": {"outflow": "collapse"}}, ["symmetric"]),
        ({"silo": {"surface_m": [[0.1, 0.2], [0.0, 0.1]]}}, ["2 corners", "x rising"]),
        ({"silo": {"surface_m": [[0.0, 0.2], [0.3, 0.1]]}}, ["x = 0 to 0.3 m", "width of 0.2 m"]),
        ({"silo": {"surface_m": [[0.0, -0.1], [0.1, 0.2]]}}, ["y = -0.1 m", "0 or more"]),
        ({"silo": {"surface_m": [[0.0, 0.1], [0.1, 0.2]], "height_m": 0.3}}, ["height is 0.3 m", "0.2 m"]),
        ({"silo": {"surface_m": [[0.0, 0.1], [0.2, 0.2]], "inserts": [
            {"kind": "cylinder", "width_m": 0.04, "bottom_m": 0.1, "position_m": 0.05}]}},
            ["insert 1", "x = 0.05", "up to 0.14 m", "must be covered"]),
        ({"silo": {"surface_m": [[0.0, 0.1], [0.2, 0.2]], "half": "yes"}}, ["half is yes", "not symmetric"]),
        ({"sand": {"layers": [{"from_m": 0.2, "void_ratio": 0.4}]}}, ["layer from 0.2 m", "is 0.4", "e_d0 = 0.51"]),
        ({"sand": {"layers": [{"from_m": 0.9, "void_ratio": 0.8}]}}, ["0.9 m", "height of 0.5 m"]),
        ({"sand": {"layers": [{"from_m": 0.2, "void_ratio": 0.8}, {"from_m": 0.1, "void_ratio": 0.7}]}},
         ["is 0.1", "above 0.2"]),
    ],
)  # fmt: skip
def test_a_fill_that_cannot_be_is_refused_in_one_sentence(tables, words):
    with pytest.raises(ValidationError) as refused:
        Scene.model_validate(tables)
    said = one_sentence(refused.value)
    assert all(word in said for word in words), said
    assert "\n" not in said


@pytest.mark.parametrize("section", ["plane", "round"])
@pytest.mark.parametrize("corners", [
    [[0.0, 0.1], [0.1, 0.2], [0.2, 0.1]],  # a heap
    [[0.05, 0.2], [0.1, 0.1], [0.15, 0.2]],  # a crater
    [[0.0, 0.0], [0.1, 0.2], [0.2, 0.0]],  # down to the floor at the walls
])  # fmt: skip
def test_the_weight_of_a_fill_is_that_of_the_area_below_its_surface(corners, section):
    found = scene({"silo": {"surface_m": corners, "section": section}}, grid={"cell_size_m": 0.005})
    x = (np.arange(20_000) + 0.5) / 20_000 * 0.2
    heights = np.interp(x, *np.transpose(corners))
    weights = np.abs(x - 0.1) / 0.05 if section == "round" else np.ones_like(x)  # twice the volume a radian, over R
    area = 0.2 * np.mean(heights * weights) / (2.0 if section == "round" else 1.0)
    unit = 2650.0 / 1.6 * 9.81
    assert found.weight_N_per_m == pytest.approx(unit * area, rel=2e-3)
    px, _, share = found.silo.lattice(found.spacing_m)
    turned = np.abs(px - 0.1) / 0.1 if section == "round" else np.ones_like(px)
    assert (share * turned).sum() == pytest.approx(area, rel=0.02)  # the points' own, in steps of one


def test_a_slope_of_either_side_holds_as_much_sand_as_its_level():
    rising = scene({"silo": {"surface_m": [[0.0, 0.3], [0.2, 0.5]]}})
    falling = scene({"silo": {"surface_m": [[0.0, 0.5], [0.2, 0.3]]}})
    assert rising.weight_N_per_m == pytest.approx(falling.weight_N_per_m, rel=1e-12)
    assert rising.silo.straight_m == pytest.approx(0.4, rel=1e-9)


def test_janssen_stands_for_the_level_surface_over_as_much_sand():
    found = scene(HEAP)
    theory = janssen_of(found, 20.0, 0.4)
    assert theory.height_m == pytest.approx(0.15, rel=1e-6)
    assert theory.weight_N_per_m == pytest.approx(found.weight_N_per_m, rel=1e-6)
    hanging = scene({"silo": {"surface_m": [[0.0, 0.0], [0.1, 0.2], [0.2, 0.0]]}})
    assert hanging.silo.straight_m == 0.0  # no sand on the walls: nothing to compare
    assert scene().silo.straight_m == 0.0


def test_a_level_surface_is_no_surface_at_all():
    level = scene({"silo": {"surface_m": [[0.0, 0.5], [0.2, 0.5]]}})
    for one, other in zip(level.silo.lattice(0.005), Scene().silo.lattice(0.005), strict=True):
        assert (one == other).all()
    assert level.weight_N_per_m == pytest.approx(Scene().weight_N_per_m, rel=1e-12)


@pytest.mark.parametrize(
    ("corners", "covered"),
    [
        ([[0.16, 0.05], [0.2, 0.05], [0.2, 0.1]], True),  # a ledge on the right wall
        ([[0.0, 0.08], [0.03, 0.08], [0.0, 0.12]], True),  # one on the left wall
        ([[0.08, 0.0], [0.12, 0.0], [0.1, 0.06]], True),  # a block on the floor
        ([[0.16, 0.1], [0.2, 0.1], [0.2, 0.17]], False),  # a ledge that ends above the surface at its wall
        ([[0.13, 0.1], [0.17, 0.1], [0.17, 0.18]], False),  # in the sand with its foot only
    ],
)
def test_a_body_on_a_wall_is_in_the_sand_if_the_surface_is_above_it(corners, covered):
    surface = [[0.0, 0.14], [0.08, 0.2], [0.2, 0.16]]
    outlet = {"width_m": 0.03, "position": 0.055}
    silo = {"surface_m": surface, "outlet": outlet, "inserts": [{"kind": "polygon", "corners_m": corners}]}
    if covered:
        assert Silo.model_validate(silo).inserts
    else:
        with pytest.raises(ValidationError, match="stands out of the sand"):
            Silo.model_validate(silo)


def test_a_column_holds_sand_between_its_sides_only():
    found = scene()
    x, y, area = found.silo.lattice(found.spacing_m)
    assert x.min() > 0.0 and x.max() < 0.1 and y.max() < 0.1
    assert area.sum() == pytest.approx(0.01, rel=1e-12)
    assert found.points == len(x)
    assert found.weight_N_per_m == pytest.approx(2650.0 / 1.6 * 9.81 * 0.01, rel=1e-12)


def test_a_round_column_has_the_weight_of_its_cylinder():
    tables = {"silo": {"section": "round", "width_m": 0.4, "height_m": 0.1, "column_m": [0.1, 0.3]}}
    found = scene(tables, flow={"outflow": "collapse"}, grid={"cell_size_m": 0.01})
    a, R, H = 0.1, 0.2, 0.1  # per metre of two opposite metres of girth: 2 (pi a^2 H) / (2 pi R)
    assert found.weight_N_per_m == pytest.approx(2650.0 / 1.6 * 9.81 * a**2 * H / R, rel=5e-3)


def test_layers_weigh_as_their_own_void_ratios_say():
    layers = [{"from_m": 0.2, "void_ratio": 0.9}, {"from_m": 0.4, "void_ratio": 0.7}]
    found = Scene.model_validate({"sand": {"layers": layers}})
    solid = 0.2 / 1.6 + 0.2 / 1.9 + 0.1 / 1.7
    assert found.weight_N_per_m == pytest.approx(2650.0 * 9.81 * 0.2 * solid, rel=1e-12)
    assert found.density_kg_per_m3 == pytest.approx(2650.0 * solid / 0.5, rel=1e-12)
    assert found.sand.void_ratio_at(np.array([0.1, 0.19, 0.2, 0.39, 0.45])).tolist() == [0.6, 0.6, 0.9, 0.9, 0.7]


def test_layers_under_a_heap_count_by_what_they_have_of_it():
    found = scene(HEAP, sand={"layers": [{"from_m": 0.1, "void_ratio": 0.9}]})
    below, above = 0.2 * 0.1, 0.5 * 0.2 * 0.1
    assert found.weight_N_per_m == pytest.approx(2650.0 * 9.81 * (below / 1.6 + above / 1.9), rel=1e-9)


def test_a_collapse_ends_where_there_is_no_more_room_or_time():
    flow = scene().flow
    assert flow.displacement_m == pytest.approx(0.3)
    assert flow.longest_s == pytest.approx(10.0 * math.sqrt(0.1 / 9.81), rel=0.01)
    assert scene(flow={"longest_s": 0.2, "displacement_m": 0.1}).flow.longest_s == 0.2


def test_a_scene_with_a_column_reads_as_it_was_written(tmp_path):
    write_parameters(tmp_path, scene(sand={"layers": [{"from_m": 0.05, "void_ratio": 0.8}]}), {})
    again = read_scene(tmp_path / "run.toml")
    assert again.silo.column_m == (0.0, 0.1) and again.silo.area_m2 == scene().silo.area_m2
    assert again.flow.model_dump() == scene().flow.model_dump()
    assert again.sand.layers[0].void_ratio == 0.8


# --- the surface and what is measured of it ---------------------------------------------------------------------------


def wedge(spacing=0.0025, high=0.1, long=0.3):
    """Points that fill a triangle over [0, long]."""
    x, y = np.meshgrid(np.arange(0.5 * spacing, long, spacing), np.arange(0.5 * spacing, high, spacing))
    kept = y < high * (1.0 - x / long)
    return x[kept], y[kept], np.full(kept.sum(), spacing**2)


def test_the_profile_of_a_wedge_has_its_height_its_front_and_its_slope():
    x, _, area = wedge()
    profile = SurfaceProfile.of(x, area, 0.0025, 0.0, 0.5, 200)
    assert profile.height_m.sum() * 0.0025 == pytest.approx(area.sum(), rel=1e-12)
    assert profile.top_m == pytest.approx(0.1, abs=0.0026)
    assert profile.fronts_m(0.01)[0] == 0.0
    assert profile.fronts_m(0.01)[1] == pytest.approx(0.3, abs=0.006)
    assert profile.slope_deg() == pytest.approx(math.degrees(math.atan(1.0 / 3.0)), abs=0.5)


def test_a_grain_that_has_rolled_away_is_no_front():
    x, _, area = wedge()
    with_grain = SurfaceProfile.of(np.append(x, 0.45), np.append(area, area[0]), 0.0025, 0.0, 0.5, 200)
    assert with_grain.fronts_m(0.01)[1] < 0.31


def spread(folder, what):
    """A made-up run: a rectangle, then a wedge of the same area that reaches twice as far."""
    (folder / "snapshots").mkdir(parents=True)
    write_parameters(folder, what, {})
    rows, d = [], what.spacing_m
    x, y, area = what.silo.lattice(d)
    for name, stage, time, stretch in (("start", "filling", 0.0, 1.0), ("filled", "filling", 0.5, 1.0),
                                       ("film_1", "flow", 0.6, 1.5), ("end", "flow", 0.8, 2.0)):  # fmt: skip
        points = {
            "position": np.stack([x * stretch, y / stretch], axis=1), "velocity": np.zeros((len(x), 2)),
            "stress": -np.ones((len(x), 4)), "mass": 1500.0 * area, "volume": area, "path": 0.0 * x,
            "void_ratio": 0.8 + 0.0 * x, "identity": np.arange(len(x)),
        }  # fmt: skip
        snapshot.write(folder / "snapshots" / f"{name}.vtu", points)
        rows.append({"file": f"{name}.vtu", "stage": stage, "time_s": time, "displacement_m": 0.0})
    pd.DataFrame(rows).to_csv(folder / "snapshots" / "index.csv", index=False)
    return folder


def test_the_measures_of_a_collapse_are_those_of_its_last_state(tmp_path):
    what = scene(grid={"cell_size_m": 0.01, "points_per_cell": 4})
    folder = spread(tmp_path / "run", what)
    found = collapse_findings(folder)
    assert first_length_m(what) == 0.1 and found["aspect_ratio"] == pytest.approx(1.0)
    assert found["run_out_over_L0"] == pytest.approx(1.0, abs=0.06)  # by half a spacing at the front
    assert found["height_over_L0"] == pytest.approx(0.5, abs=0.06)
    assert found["energy_dissipated_over_first_potential"] == pytest.approx(0.5, abs=1e-6)
    assert not found["reached_a_wall"]
    table = pd.read_csv(folder / "collapse.csv")
    assert table.time_s.tolist() == pytest.approx([0.0, 0.1, 0.3])
    assert table.mass_kg_per_m.tolist() == pytest.approx([15.0] * 3) and not table.isna().any().any()
    assert run_collapse_figure(Result(folder)) is not None


def test_the_scenario_gives_the_column_room_and_names_what_it_cannot_make():
    given = inspect_tables(aspect_ratio=2.0)
    assert given["silo"]["column_m"] == (0.0, 0.1) and given["silo"]["height_m"] == pytest.approx(0.2)
    both = inspect_tables(aspect_ratio=2.0, sides="both")["silo"]
    assert both["height_m"] == pytest.approx(0.1)  # L0 is half the breadth
    assert sum(both["column_m"]) == pytest.approx(both["width_m"])
    for wrong in ({"aspect_ratio": 0.0}, {"sides": "left"}, {"column_width": -1.0}):
        with pytest.raises(Exception, match=next(iter(wrong)).replace("_", " ")):
            inspect_tables(**wrong)


def inspect_tables(**values):
    """Tables of the scenario's scene, adapted."""
    tables = {"silo": {"section": "plane"}, "grid": {}, "flow": {}}
    _module().adapt(tables, **values)
    return tables


def _module():
    spec = util.spec_from_file_location("column", catalogue.script("column"))
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module

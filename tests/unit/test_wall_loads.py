"""Wall loads for shell programs: their resultants are those of the fields, of EN 1991-4 and of a run."""

import re
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad

from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.scene.design import Design
from taichi_silo.scene.eurocode import Eurocode
from taichi_silo.scene.scene import Mesh, Scene, Walls
from taichi_silo.scene.silo import Hopper, Silo
from taichi_silo.show.export import abaqus, wall_loads
from taichi_silo.show.report.eurocode import EurocodeReport

HOPPER = Hopper(half_angle_deg=30, outlet_width_m=1)
FAR = Eurocode(solid="wheat", wall="D3", action_class=3, outlet_eccentricity_m=3.0, wall_thickness_m=0.01)
ROUND = Design(silo=Silo(width_m=10, height_m=30, section="round", hopper=HOPPER), eurocode=FAR)
PLANE = Design(silo=Silo(width_m=4, height_m=12), eurocode=Eurocode(solid="barley", length_m=6.0))


def loads(design):
    return {one.case: one for one in wall_loads.of_code(EurocodeReport.of(design))}


@pytest.mark.parametrize("case", ["filling_pressure", "discharge_friction", "channel_40_pressure"])
def test_bands_press_and_rub_as_much_as_the_field(case):
    load = loads(ROUND)[case]
    bands, radius, height = pd.DataFrame(abaqus.bands(load)), 5.0, load.height_m
    area = (bands.to_height_m - bands.from_height_m) * np.radians(bands.to_angle_deg - bands.from_angle_deg) * radius
    turns = np.unique([0.0, 360.0, *load.turns_deg])
    for name, field in (("normal_Pa", load.normal_Pa), ("shear_Pa", load.shear_Pa)):
        whole = sum(
            radius * np.radians(end - start) * quad(field, 0.0, height, args=(0.5 * (start + end),))[0]
            for start, end in pairwise(turns)
        )
        assert (bands[name] * area).sum() == pytest.approx(whole, rel=1e-4)
    assert area.sum() == pytest.approx(2.0 * np.pi * radius * height)


def test_the_bands_of_a_patch_have_all_but_half_a_per_cent_of_its_force():
    report = EurocodeReport.of(ROUND)
    (patch,) = [one for one in report.patches if one.state == "discharge"]
    found = loads(ROUND)
    bands = pd.DataFrame(abaqus.bands(found["discharge_patch_thin_walled"]))
    middle = np.radians(0.5 * (bands.from_angle_deg + bands.to_angle_deg))
    chord = 10.0 * np.sin(np.radians(0.5 * (bands.to_angle_deg - bands.from_angle_deg)))  # what a pressure pushes on
    sideways = (bands.normal_Pa * (bands.to_height_m - bands.from_height_m) * chord * np.cos(middle)).sum()
    assert sideways == pytest.approx(patch.force_N * (np.sin(np.radians(7.5)) / np.radians(7.5)) ** 2, rel=1e-3)
    assert 0.993 < sideways / patch.force_N < 1.0


def test_a_hopper_s_bands_carry_what_walker_says():
    load, hopper = loads(ROUND)["hopper_filling"], EurocodeReport.of(ROUND).bottom.hopper("filling")
    beta, total = np.radians(30.0), 0.0
    for one in abaqus.bands(load):
        low, high = (0.5 * float(load.width_m(one[end])) for end in ("from_height_m", "to_height_m"))
        slope = (one["to_height_m"] - one["from_height_m"]) / np.cos(beta)
        area = np.pi * (low + high) * slope
        total += area * (one["normal_Pa"] * np.sin(beta) + one["shear_Pa"] * np.cos(beta))
    assert total == pytest.approx(hopper.wall_force_N_per_m * np.pi * 10.0, rel=1e-4)


@pytest.mark.parametrize(
    ("case", "zero"), [("filling_pressure", "the foot of the wall"), ("hopper_filling", "the outlet")]
)
def test_an_include_file_says_where_its_heights_begin(case, zero):
    texts, _ = abaqus.include_files(loads(ROUND)[case], "EN 1991-4")
    assert all(text.splitlines()[1] == f"** units N, m, Pa; z upwards from {zero}" for text in texts.values())


@pytest.mark.parametrize(("end", "keyword"), [("", "*DSLOAD"), ("_elements", "*DLOAD")])
def test_an_include_file_has_a_pressure_and_a_traction_for_each_surface(end, keyword):
    load = loads(ROUND)["discharge_pressure"]
    texts, surfaces = abaqus.include_files(load, "EN 1991-4")
    lines = [line for line in texts[end].splitlines() if not line.startswith("**")]
    assert lines[0] == keyword
    names = [f"WALL_B{number:02d}" for number in range(1, 21)]
    assert lines[1::2] == [line for line in lines[1:] if re.fullmatch(r"WALL_B\d\d, P, [\d.e+-]+", line)]
    assert lines[2::2] == [
        line for line in lines[1:] if re.fullmatch(r"WALL_B\d\d, TRSHR, [\d.e+-]+, 0., 0., -1.", line)
    ]
    assert [one["surface"] for one in surfaces] == [line.split(",")[0] for line in lines[1::2]] == names
    foot, top = float(lines[1].split(",")[2]), float(lines[-2].split(",")[2])
    assert foot > 10.0 * top > 0.0  # the first band is at the foot, and pushes outward


def test_the_folder_has_points_in_space_and_all_cases(tmp_path):
    found = loads(ROUND)
    wall_loads.write_loads(list(found.values()), tmp_path / "loads", "test")
    table = pd.read_csv(tmp_path / "loads" / "wall_pressures.csv")
    assert set(table.case) == set(found)
    deepest = table.groupby("case").depth_m.transform("max").to_numpy()
    assert (table.depth_m + table.height_m).to_numpy() == pytest.approx(deepest)
    wall = table[table.wall == "wall"]
    assert np.hypot(wall.x_m, wall.y_m).to_numpy() == pytest.approx(5.0)
    turned = np.degrees(np.arctan2(wall.y_m, wall.x_m)).to_numpy() % 360.0
    assert turned == pytest.approx(wall.angle_deg.to_numpy(), abs=1e-6)
    points = pd.read_csv(tmp_path / "loads" / "points_filling_pressure.txt", sep=" ")
    assert list(points) == ["X", "Y", "Z", "P", "T"]
    assert points.P.to_numpy() == pytest.approx(table[table.case == "filling_pressure"].normal_Pa.to_numpy())
    includes = {file.stem for file in (tmp_path / "loads").glob("*.inp")}
    assert includes == set(found) | {f"{case}_elements" for case in found}
    surfaces = pd.read_csv(tmp_path / "loads" / "surfaces.csv")
    assert set(surfaces.case) == set(found)


def test_a_rectangular_silo_has_points_on_four_walls():
    table = loads(PLANE)["filling_pressure"].table()
    places = {(round(x, 9), round(y, 9)) for x, y in zip(table.x_m, table.y_m, strict=True)}
    assert places == {(2.0, 0.0), (-2.0, 0.0), (0.0, 3.0), (0.0, -3.0)}


@pytest.fixture
def run(tmp_path):
    """A silo with a lopsided wall stress: right p = 2000 (0.5 - y), left three quarters of it, friction a third."""
    folder = tmp_path / "run"
    folder.mkdir()
    scene = Scene(grid=Mesh(cell_size_m=0.01), walls=Walls(kind="smooth", friction_angle_deg=18.0))
    write_parameters(folder, scene, {})
    y, rows = np.linspace(0.0, 0.5, 51), []
    for state, factor in (("filling", 1.0), ("maximum", 1.5), ("residual", 1.2)):
        for wall, share in (("left", 0.75), ("right", 1.0)):
            p = 2000.0 * factor * share * (0.5 - y)
            rows.append(pd.DataFrame({"state": state, "wall": wall, "height_m": y, "normal_stress_Pa": p,
                                      "shear_stress_Pa": p / 3.0}))  # fmt: skip
    pd.concat(rows).to_csv(folder / "walls.csv", index=False)
    return folder


def test_a_run_exports_the_pressures_of_its_walls(run, said):
    code, out, err = said("export", run, "--format", "wall-loads")
    assert (code, err) == (0, "") and "3 states" in out
    table = pd.read_csv(run / "wall-loads" / "wall_pressures.csv")
    assert list(table.case.unique()) == ["filling", "maximum", "residual"]
    filling = table[table.case == "filling"]
    right, left = (filling[filling.angle_deg == angle] for angle in (0.0, 180.0))
    assert right.normal_Pa.to_numpy() == pytest.approx(2000.0 * (0.5 - right.height_m.to_numpy()), abs=1e-6)
    assert left.normal_Pa.to_numpy() == pytest.approx(0.75 * right.normal_Pa.to_numpy(), abs=1e-6)
    assert left.shear_Pa.to_numpy() == pytest.approx(left.normal_Pa.to_numpy() / 3.0, abs=1e-6)
    assert (set(right.x_m), set(left.x_m)) == ({0.1}, {-0.1})
    bands = pd.DataFrame(abaqus.bands({one.case: one for one in wall_loads.of_run(Result(run))}["maximum"]))
    width = bands.to_height_m - bands.from_height_m
    one_side = bands.from_angle_deg < 0.0  # the right wall
    assert (bands.normal_Pa * width)[one_side].sum() == pytest.approx(1.5 * 2000.0 * 0.5**2 / 2.0, rel=1e-4)
    assert said("export", run, "--format", "wall-loads")[0] == 2  # it is there already
    assert said("export", run, "--format", "wall-loads", "--overwrite")[0] == 0


def test_a_round_hopper_of_which_one_side_is_kept_is_exported(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    hopper = Hopper(half_angle_deg=30, outlet_width_m=0.08)
    write_parameters(folder, Scene(silo=Silo(section="round", hopper=hopper), grid=Mesh(cell_size_m=0.01)), {})
    y = np.linspace(0.0, 0.1, 11)
    rows = [
        pd.DataFrame({"state": "filling", "wall": wall, "height_m": y + low, "normal_stress_Pa": 1e3 * (share + y),
                      "shear_stress_Pa": 300.0})
        for wall, low, share in (("left", 0.1, 1.0), ("right", 0.1, 2.0), ("hopper_right", 0.0, 4.0))
    ]  # fmt: skip
    pd.concat(rows).to_csv(folder / "walls.csv", index=False)
    wall, inclined = wall_loads.of_run(Result(folder))
    assert (wall.case, inclined.case) == ("filling", "hopper_filling")
    z = np.array([0.0, 0.05])
    assert inclined.normal_Pa(z, 0.0) == pytest.approx([4e3, 4.05e3]) == inclined.normal_Pa(z, 180.0)
    foot = float(Result(folder).scene.silo.transition_m) - 0.1
    assert wall.normal_Pa(np.array([0.0]), 90.0) == pytest.approx(1.5e3 + 1e3 * foot)  # the mean of both sides
    assert inclined.width_m(np.array([0.0, inclined.height_m])) == pytest.approx([0.08, 0.2])


def test_a_run_without_wall_stresses_has_none_to_export(run, said):
    (run / "walls.csv").unlink()
    code, _, err = said("export", run, "--format", "wall-loads")
    assert code == 2 and "walls.csv has none" in err

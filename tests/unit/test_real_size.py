"""Silos of every size and shape: theory beside the run is that of its own walls, and lengths are read in their unit."""

import json
import math

import numpy as np
import pandas as pd
import pytest

from taichi_silo.analysis.theory.janssen import Janssen
from taichi_silo.mpm.laws import Elastic, GudehusBauer, Intergranular
from taichi_silo.runs.inclined_walls import inclined_walls
from taichi_silo.runs.janssen_findings import janssen_findings
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.runs.theories import theory_of
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.scene import Scene, Walls
from taichi_silo.scene.silo import Silo
from taichi_silo.show.report.states import forces_of
from taichi_silo.show.report.tables import force_table
from taichi_silo.show.report.words import mm
from tests.made_up import state

SMOOTH = Walls(kind="smooth", friction_angle_deg=20.0)
ONE_SIDED = Silo.polygon([(0.12, 0), (0.2, 0), (0.2, 0.3), (0, 0.3), (0, 0.12)])
PURE = Silo.polygon([(0.06, 0), (0.14, 0), (0.2, 0.2), (0, 0.2)])
WALLS = ("left", "right")
COARSE = {"grid": {"cell_size_m": 0.02}}


def findings(scene, normal, shear, above=None):
    """Of forces after filling, those of the walls being equal unless told."""
    filling = {"normal_N_per_m": normal, "shear_N_per_m": shear, "bottom_N_per_m": 100.0}
    filling["wall_friction_angle_deg"] = math.degrees(math.atan2(shear, normal))
    return janssen_findings(scene, filling, state(scene, 0.0), above or {side: (normal, shear) for side in WALLS})


def test_between_frictionless_walls_the_fill_presses_like_a_fluid_times_k0():
    """T = 0, N = K gamma h^2 / 2, P = W; a relative difference from 0 is none."""
    scene = Scene(walls=Walls(kind="smooth", friction_angle_deg=0.0), **COARSE)
    weight_density = scene.density_kg_per_m3 * 9.81
    k0 = scene.law.rest_pressure_ratio(0.60)
    normal = 0.5 * k0 * weight_density * 0.5**2
    found = findings(scene, 1.1 * normal, 0.0)
    assert found["normal_N_per_m_K0"] == pytest.approx(normal, rel=1e-12)
    assert found["normal_N_per_m_K0_relative_difference"] == pytest.approx(0.1)
    assert found["shear_N_per_m_K0"] == 0.0 and "shear_N_per_m_K0_relative_difference" not in found
    assert found["bottom_N_per_m_K0"] == pytest.approx(scene.weight_N_per_m, rel=1e-12)
    assert found["pressure_ratio_fitted"] == pytest.approx(1.1 * k0, rel=1e-9)


def test_walls_that_are_not_alike_are_compared_one_by_one_above_the_higher_foot():
    scene = Scene(silo=ONE_SIDED, walls=SMOOTH, **COARSE)
    k0 = scene.law.rest_pressure_ratio(0.60)
    law = Janssen(0.2, 0.3 - 0.12, scene.density_kg_per_m3 * 9.81, 20.0, k0)
    n, t = law.normal_force_N_per_m, law.shear_force_N_per_m
    found = findings(scene, 5.0 * n, 5.0 * t, {"left": (1.2 * n, t), "right": (0.8 * n, t)})
    assert found["normal_N_per_m_K0"] == pytest.approx(n)
    assert found["normal_N_per_m_K0_relative_difference"] == pytest.approx(0.0, abs=1e-9), "not of the whole walls"
    assert found["above_m"] == 0.12
    assert found["walls"]["right"] == {"normal_N_per_m": 0.8 * n, "shear_N_per_m": t}


@pytest.mark.parametrize(
    "silo", [PURE, Silo.polygon([(0, 0), (0.12, 0), (0.2, 0.3), (0.08, 0.3)]),
             Silo.polygon([(0.06, 0), (0.14, 0), (0.2, 0.2), (0.2, 0.5), (0, 0.5), (0, 0.2)], height_m=0.14)],
    ids=["pure hopper", "tilted wall", "partly filled hopper"],
)  # fmt: skip
@pytest.mark.parametrize("walls", [SMOOTH, Walls()], ids=["smooth", "very rough"])
def test_without_vertical_walls_there_is_no_janssen_and_all_else_is_found(silo, walls):
    scene = Scene(silo=silo, walls=walls, **COARSE)
    found = findings(scene, 0.1, -0.03)
    assert not [name for name in found if name.startswith(("normal", "shear", "bottom"))]
    theory = theory_of(scene, found["wall_friction_angle_deg"], found["pressure_ratio_K0"])
    assert theory["beverloo_kg_per_s_m"] > 0.0


def test_k0_is_that_of_the_law_itself():
    """Of an elastic body nu / (1 - nu); of sand with memory that of its skeleton."""
    assert Elastic(1e6, 0.25).rest_pressure_ratio(0.6) == pytest.approx(1.0 / 3.0)
    skeleton = GudehusBauer(critical_friction_angle_deg=35.0)
    assert Intergranular(skeleton=skeleton).rest_pressure_ratio(0.7) == skeleton.rest_pressure_ratio(0.7)


def test_a_law_that_is_registered_anew_brings_its_own_k0_into_the_theory_beside_a_run(monkeypatch):
    """Janssen's N rises with K: that of a stiff elastic body is not that of sand with the same constants."""
    scene = Scene(walls=SMOOTH, **COARSE)
    usual = findings(scene, 100.0, 30.0)
    monkeypatch.setattr(Sand, "constitutive_law", lambda *given: Elastic(1e6, 0.4))
    found = findings(scene, 100.0, 30.0)
    assert found["pressure_ratio_K0"] == pytest.approx(2.0 / 3.0)
    assert found["normal_N_per_m_K0"] > 1.2 * usual["normal_N_per_m_K0"]
    assert found["pressure_ratio_measured"] == usual["pressure_ratio_measured"], "which the sand itself says"


def left(folder, scene, columns, **summary):
    """A run of a scene with forces that are the same in all rows of filling and flow."""
    folder.mkdir()
    write_parameters(folder, scene, {})
    time = np.linspace(0.1, 2.0, 20)
    forces = {
        "time_s": time,
        "stage": np.where(time < 1.0, "filling", "flow"),
        "displacement_m": np.maximum(time - 1.0, 0),
    }
    forces |= {"bottom_force_N_per_m": 100.0, "wall_friction_angle_deg": 0.0, "weight_N_per_m": 300.0}
    for side in WALLS:
        forces |= {f"{side}_normal_N_per_m": 0.0, f"{side}_shear_N_per_m": 0.0}
    pd.DataFrame(forces | columns).to_csv(folder / "forces.csv", index=False)
    (folder / "summary.json").write_text(json.dumps({"finished": True} | summary))
    return Result(folder)


def test_n_and_t_of_inclined_walls_are_their_force_across_and_along(tmp_path):
    """A wall that pushes with N across itself and T along itself, upwards, is told as N and T."""
    scene = Scene(silo=PURE, walls=SMOOTH, **COARSE)
    n, t, along = 50.0, 18.0, np.array([0.06, 0.2]) / math.hypot(0.06, 0.2)  # of the right wall, upwards
    across = np.array([-along[1], along[0]])
    force = n * across + t * along
    columns = {"hopper_right_horizontal_N_per_m": force[0], "hopper_right_vertical_N_per_m": force[1],
               "hopper_left_horizontal_N_per_m": -force[0], "hopper_left_vertical_N_per_m": force[1]}  # fmt: skip
    run = left(tmp_path / "run", scene, columns)
    for side in WALLS:
        assert float(inclined_walls(scene.silo, run.filled)[side]["N"]) == pytest.approx(n)
        assert inclined_walls(scene.silo, run.forces)[side]["T"].to_numpy() == pytest.approx(t)
    assert run.residual[["P", "T", "N"]].to_numpy() == pytest.approx([100.0, t, n])  # where none is vertical
    rows = {row[0]: row[1:] for row in force_table(run).rows}
    assert rows["hopper left, N across it (kN/m)"] == ("0.0500", "–", "0.0500")
    assert rows["hopper right, T along it (kN/m)"] == ("0.0180", "–", "0.0180")
    assert not [title for title in rows if title.startswith(("wall", "arctan"))]
    assert "Janssen:" not in force_table(run).note


@pytest.mark.parametrize("weight", [2e2, 3e5, 3e8])
def test_an_angle_is_no_share_of_the_weight(tmp_path, weight):
    forces = {"normal_N_per_m": 0.4 * weight, "shear_N_per_m": 0.14 * weight, "bottom_N_per_m": 0.7 * weight,
              "wall_friction_angle_deg": 19.3}  # fmt: skip
    run = left(tmp_path / "run", Scene(walls=SMOOTH, **COARSE), {}, weight_N_per_m=weight, filling=forces,
               residual=forces)  # fmt: skip
    assert forces_of(run)["angle"].filled == forces_of(run)["angle"].residual == 19.3
    assert forces_of(run)["N"].filled == 0.4 * weight


def test_lengths_from_1_m_on_are_read_in_m():
    assert [mm(x, 3) for x in (0.0042, 0.3, 0.9994, 0.9996, 4.25, 20.0)] == [
        "4.2 mm", "300 mm", "999 mm", "1 m", "4.25 m", "20 m",
    ]  # fmt: skip

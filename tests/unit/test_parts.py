"""A scene gets no more than it needs, each decision comes with its number, and a flag overrules it."""

import re
import subprocess
import sys
from pathlib import Path
from typing import ClassVar

import pytest

from taichi_silo.cli.flags import OF_FIDELITY, paths_of_flags
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.walls import Coulomb
from taichi_silo.runs.method_choices import parts
from taichi_silo.scene.dotted_paths import known
from taichi_silo.scene.outlets import Outlet
from taichi_silo.scene.scene import Averaging, Flow, Mesh, Method, Output, Sand, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation

SCRIPT = Path(__file__).parents[2] / "scenarios" / "mass_flow.py"


class Shaken(Flow):
    """A flow that strains the sand to and fro."""

    turns_back: ClassVar[bool] = True


def decided(**tables):
    return {part.part: part for part in parts(Scene(**tables))}


def test_the_list_has_a_choice_and_a_number_for_every_part():
    found = parts(Scene())
    assert [part.part for part in found] == [
        "accuracy", "cell size", "outflow",
        "intergranular strain", "non-local average", "half model", "stress sub-stepping", "stress filter",
        "particle domains", "wall friction solve", "noise control", "output", "inactive cells", "sand at rest",
    ]  # fmt: skip
    for part in found:
        assert part.choice
        assert part.because.endswith(".")
        assert re.search(r"\d", part.because), part


def test_every_flag_that_overrules_is_one_of_the_command_line():
    helped = subprocess.run([sys.executable, str(SCRIPT), "--help"], capture_output=True, text=True, timeout=120).stdout
    for part in parts(Scene()):
        for flag in re.findall(r"--[a-z-]+", part.flag):
            assert flag in helped


@pytest.mark.parametrize("flow", [Flow(), Flow(outflow="gravity"), Flow(outflow="collapse")], ids=lambda f: f.outflow)
def test_what_overrules_in_a_scene_file_is_what_the_flag_of_a_scenario_sets(flow):
    silo = Silo(column_m=(0.0, 0.1)) if flow.outflow == "collapse" else Silo(outlet=Outlet(width_m=0.1))
    for part in parts(Scene(silo=silo, flow=flow)):
        flags = [flag for flag in re.findall(r"--[a-z-]+", part.flag) if flag != "--no-film"]
        if flags == ["--fidelity"]:
            assert part.key == ", ".join(OF_FIDELITY)
        else:
            assert part.key == ", ".join(paths_of_flags()[flag] for flag in flags)
        assert not [key for key in part.key.split(", ") if key and not known(key)]


SMOOTH = Walls(kind="smooth", friction_angle_deg=19.0)


@pytest.mark.parametrize(
    ("part", "choice", "words", "tables"),
    [
        ("intergranular strain", "off", "", {}),
        ("intergranular strain", "on", "", {"flow": Shaken()}),  # only sand that is turned back gets a memory
        ("non-local average", "off", "", {"walls": SMOOTH}),  # on once points are closer than its length
        ("non-local average", "on", "2.5 mm", {}),  # half a cell between very rough walls
        ("non-local average", "on", "10 mm", {"averaging": Averaging(characteristic_length_m=0.01)}),
        ("wall friction solve", "off", "", {}),  # solved only where sand slips with friction
        ("wall friction solve", "on", "", {"walls": Walls(bottom_friction_angle_deg=20.0)}),
        ("wall friction solve", "on", "19 deg", {"walls": SMOOTH}),
        ("wall friction solve", "off", "", {"walls": Walls(kind="smooth", friction_angle_deg=0.0)}),
        ("particle domains", "off", "", {}),
        ("particle domains", "on", "", {"grid": Mesh(shape="cpdi")}),
        ("particle domains", "on", "", {"grid": Mesh(shape="cpgimp")}),
        ("noise control", "off", "", {"method": Method(noise_control="none")}),
    ],
)
def test_a_part_is_on_where_the_scene_needs_it(part, choice, words, tables):
    found = decided(**tables)[part]
    assert found.choice == choice
    assert words in found.because


def test_a_law_that_is_asked_for_is_kept_where_sand_is_turned_back():
    assert Scene(flow=Shaken()).law.REMEMBERS
    assert not Scene(flow=Shaken(), sand=Sand(law="gudehus-bauer")).law.REMEMBERS


def test_nodes_in_the_sand_are_counted_of_what_is_computed():
    coarse = {"grid": Mesh(cell_size_m=0.02), "walls": SMOOTH}
    whole, half = (decided(silo=Silo(half=choice), **coarse)["inactive cells"] for choice in ("no", "yes"))
    simulation = Simulation(Scene(silo=Silo(half="no"), **coarse))
    assert whole.because.startswith(f"{11 * 26} of {simulation.solver.grid.nodes} nodes")
    assert half.because.startswith(f"{6 * 26} of ")


def test_a_frictionless_wall_takes_what_approaches_and_lets_go_what_recedes():
    contact = Coulomb(0.0)

    @ti.kernel
    def touched(x: real, y: real) -> ti.types.vector(2, real):
        touched = contact.touch((x, y), (1.0, 0.0))
        return ti.Vector([touched[0], touched[1]])

    assert list(touched(2.0, 3.0)) == [0.0, 3.0]
    assert list(touched(-2.0, 3.0)) == [-2.0, 3.0]


def test_twice_the_records_change_no_force():
    """Rows are more, their means the same: the steps in between are chosen from the sand, not from the rows."""

    def run(records):
        scene = Scene(
            silo=Silo(width_m=0.12, height_m=0.2), grid=Mesh(cell_size_m=0.02), walls=SMOOTH,
            flow=Flow(speed_m_per_s=0.02, displacement_m=0.001), output=Output(records_per_period=records),
            method=Method(filling_time_s=0.2, longest_settling_s=0.1),
        )  # fmt: skip
        return [record for record in Simulation(scene).run() if record.stage == "flow"]

    few, many = run(10), run(20)
    assert len(many) == pytest.approx(2 * len(few), abs=1)
    for name in ("bottom_N_per_m", "shear_N_per_m", "normal_N_per_m"):
        means = [sum(getattr(r, name) * r.interval_s for r in rows) / rows[-1].displacement_m for rows in (few, many)]
        assert means[1] == pytest.approx(means[0], rel=2e-3)


def test_explaining_runs_nothing(tmp_path):
    done = subprocess.run(
        [sys.executable, str(SCRIPT), "--explain", "--output", str(tmp_path / "run")],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "half model" in done.stdout
    assert "--noise-control" in done.stdout
    assert not (tmp_path / "run").exists()

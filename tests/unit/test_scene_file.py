"""Scenes from files: what is left out, named or misspelt; template, page and schema; fidelities and single changes."""

import json
import math

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st

from taichi_silo.cli import model_silo
from taichi_silo.errors import BadInput
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.scene import reference, sands
from taichi_silo.scene.dotted_paths import changed, known, value
from taichi_silo.scene.fidelity import FIDELITIES, fidelity, like
from taichi_silo.scene.flow import FROUDE
from taichi_silo.scene.published_sands import published
from taichi_silo.scene.scene import Flow, Mesh, Scene, Walls
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.scene.silo import Insert, Outlet, Silo

ROOF_ABOVE = Insert(kind="roof", width_m=0.06, bottom_m=0.1)


@pytest.fixture
def read(tmp_path):
    def of(text, *changes):
        file = tmp_path / "scene.toml"
        file.write_text(text if isinstance(text, str) else tomli_w.dumps(text), encoding="utf-8")
        return read_scene(file, changes)

    return of


@pytest.mark.parametrize("text", ["", reference.template()], ids=["nothing", "the template"])
def test_an_empty_file_and_the_template_are_the_default_scene(read, text):
    assert read(text) == Scene()


def test_template_page_and_schema_show_every_value_with_what_it_is():
    lines = [line.lstrip("# ").split(" = ")[0] for line in reference.template().splitlines() if " = " in line]
    assert sorted(lines) == sorted(entry.name for entry in reference.entries())
    assert "|---|" not in reference.markdown()  # a phone shows lists as they are, tables sideways
    page, schema = reference.markdown(), json.dumps(Scene.model_json_schema())
    for entry in reference.entries():
        assert entry.meaning and entry.kind, entry.path
        assert f"- **`{entry.name}`** ({entry.kind}" in page
        assert f'"{entry.name}"' in schema


def test_every_quantity_with_a_unit_in_its_name_has_that_unit():
    units = {entry.path: entry.unit for entry in reference.entries()}
    for path, unit in (
        ("flow.speed_m_per_s", "m/s"), ("method.gravity_m_per_s2", "m/s²"), ("silo.inserts.0.width_m", "m"),
        ("sand.grain_density_kg_per_m3", "kg/m³"), ("sand.void_ratio", ""), ("sand.n", ""),
    ):  # fmt: skip
        assert units[path] == unit


@pytest.mark.parametrize("more", [{}, {"d50_m": 1e-3}], ids=["name", "name and a constant that beats its own"])
def test_a_published_sand_is_known_by_its_name(read, more):
    assert read({"sand": {"name": "hostun", "void_ratio": 0.7, **more}}).sand == sands.sand("hostun", 0.7, **more)


def test_a_run_toml_is_a_scene(read, tmp_path):
    scene = Scene(
        silo=Silo(outlet=Outlet(width_m=0.08, position=0.06), inserts=(ROOF_ABOVE,)),
        walls=Walls(kind="smooth", friction_angle_deg=15), grid=Mesh(cell_size_m=0.01), sand=sands.sand("hostun", 0.7),
    )  # fmt: skip
    write_parameters(tmp_path, scene, {"wall_seconds": 1.0})
    again = read_scene(tmp_path / "run.toml")
    assert again.silo.model_copy(update={"half": "auto"}) == scene.silo
    assert (again.sand.skeleton(), again.walls, again.grid) == (scene.sand.skeleton(), scene.walls, scene.grid)


@settings(max_examples=25, deadline=None)
@given(
    width=st.integers(4, 40), height=st.integers(6, 60), speed=st.floats(1e-5, 0.1), share=st.floats(0.01, 1.0),
    walls=st.sampled_from(["smooth", "very-rough"]), name=st.sampled_from(sorted(published())),
    outlet=st.none() | st.tuples(st.integers(2, 3), st.sampled_from(["centre", "left", "right"])),
)  # fmt: skip
def test_a_scene_written_and_read_is_the_same(tmp_path_factory, width, height, speed, share, walls, name, outlet):
    h, constants = 0.01, published()[name]
    gate = None
    if outlet:
        columns, position = outlet
        columns += (width - columns) % 2 if position == "centre" else 0
        gate = Outlet(width_m=columns * h, position=position) if columns < width else None
    scene = Scene(
        silo=Silo(width_m=width * h, height_m=height * h, outlet=gate), walls=model_silo.walls(walls, 0.60),
        grid=Mesh(cell_size_m=h), sand=sands.sand(name, 0.5 * (constants["e_d0"] + constants["e_c0"])),
        flow=Flow(speed_m_per_s=speed, displacement_m=share * height * h * (0.5 if gate else 1.0)),
    )  # fmt: skip
    file = tmp_path_factory.mktemp("scene") / "scene.toml"
    file.write_text(tomli_w.dumps(scene.model_dump(exclude_none=True)), encoding="utf-8")
    assert read_scene(file) == scene


def test_changes_stand_over_the_file(read):
    scene = read(
        '[sand]\nname = "hostun"\nvoid_ratio = 0.7', "flow.speed_m_per_s=0.005", "silo.outlet.width_m=0.08",
        "walls.kind=smooth", "walls.friction_angle_deg=19", "silo.outlet.position=right",
    )  # fmt: skip
    assert (scene.flow.speed_m_per_s, scene.silo.outlet, scene.walls.kind) == (
        0.005, Outlet(width_m=0.08, position="right"), "smooth",
    )  # fmt: skip


ROOF = '[[silo.inserts]]\nkind = "roof"\nwidth_m = 0.06\nbottom_m = 0.1\n'


def test_changes_reach_entries_of_lists(read):
    assert read(ROOF, "silo.inserts.0.width_m=0.04").silo.inserts[0].width_m == 0.04


@pytest.mark.parametrize(
    ("text", "changes", "words"),
    [
        ("[flow]\nspeed = 1", (), ["flow.speed is not", "did you mean flow.speed_m_per_s"]),
        ("[flw]\nspeed_m_per_s = 1", (), ["flw is not", "did you mean flow"]),
        ("[sand.intergranular]\nradios = 1", (), ["sand.intergranular.radios", "radius"]),
        (ROOF + "wdth_m = 1", (), ["silo.inserts.0.wdth_m", "silo.inserts.0.width_m"]),
        ("[flow]\nspeed_m_per_s = -1", (), ["speed_m_per_s is -1", "at least 1e-09 and at most 1"]),
        ("[flow]\nspeed_m_per_s = nan", (), ["speed_m_per_s is nan", "finite"]),
        ("[flow]\nspeed_m_per_s = 'fast'", (), ["speed_m_per_s is fast", "number"]),
        ("[walls]\nkind = 'rough'", (), ["walls is rough", "'smooth' or 'very-rough'"]),
        ("[silo.outlet]\nposition = 'left'", (), ["silo.outlet.width_m is missing"]),
        ("flow = 3", (), ["flow is 3", "a table"]),
        ("[sand]\nname = 'hostum'", (), ["sand.name is hostum", "did you mean hostun"]),
        ("[sand]\nname = 'mine'\nn = 0.5", (), ["sand.name is mine", "critical_friction_angle_deg is missing"]),
        ("[silo]\nwidth_mm = 200", (), ["silo.width_mm is not", "did you mean silo.width_m = 0.2?"]),
        ("[silo.outlet]\nwidth_CM = 8.5", (), ["did you mean silo.outlet.width_m = 0.085?"]),
        ("[sand]\ngranular_hardness_MPa = 190", (), ["did you mean sand.granular_hardness_Pa = 190000000?"]),
        ("[sand]\ngrain_density_g_cm3 = 2.65", (), ["did you mean sand.grain_density_kg_per_m3 = 2650?"]),
        ("[silo]\nwidth_mm = 'a'", (), ["did you mean silo.width_m?"]),
        ("[silo]\nwidth_m = 0,2", (), ["cannot be read as a scene: line 2 has 0,2; write 0.2, with a point"]),
        ("[silo]\noutlet = { width_m = 0,08 } # m", (), ["line 2 has 0,08; write 0.08, with a point"]),
        ("", ("silo.width_m=0,2",), ["width_m is 0,2; it must be a number: write 0.2, with a point"]),
        ("[silo\n", (), ["cannot be read as a scene", "line 1"]),
        ("", ("flow.speed_m_per_s",), ["PATH=VALUE"]),
        ("", ("flow.speed=1",), ["flow.speed is not"]),
        ("", ("silo.width_m.x=1",), ["width_m is {'x': 1}", "number"]),
        (ROOF, ("silo.inserts.3.width_m=0.04",), ["silo.inserts.3", "1 are there, so the next has number 1"]),
    ],
    ids=lambda value: "",
)
def test_what_is_wrong_is_said_in_one_sentence(read, text, changes, words):
    with pytest.raises(BadInput) as caught:
        read(text, *changes)
    sentence = str(caught.value)
    assert "\n" not in sentence
    for word in words:
        assert word in sentence, sentence


def test_a_file_that_is_not_there_or_no_text_is_refused(tmp_path):
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    for name, words in (("none.toml", "No such file"), ("bytes.toml", "cannot be read"), ("", "cannot be read")):
        with pytest.raises(BadInput, match=words):
            read_scene(tmp_path / name)


@pytest.mark.parametrize("name", published())
def test_in_the_template_another_name_is_another_sand(read, name):
    constants = published()[name]
    e = round(0.5 * (constants["e_d0"] + constants["e_c0"]), 3)
    text = reference.template().replace('"karlsruhe"', f'"{name}"').replace("void_ratio = 0.6 ", f"void_ratio = {e} ")
    assert read(text).sand == sands.sand(name, e)


def test_a_setting_changes_its_own_value_and_no_other():
    scene = changed(Scene(), {"flow.speed_m_per_s": 0.005})
    assert value(scene, "flow.speed_m_per_s") == 0.005
    assert scene == Scene(flow={"speed_m_per_s": 0.005})
    assert not known("flow.colour") and not known("flow")
    with pytest.raises(BadInput, match=r"setting is flow\.colour"):
        changed(Scene(), {"flow.colour": 1.0})


def test_every_fidelity_makes_a_scene_of_any_size_and_others_are_refused():
    """Cells across and the Froude number of the bottom are the same in a model silo and in one of 6 m × 20 m."""
    assert list(FIDELITIES) == ["draft", "standard", "fine", "converged"]
    for silo in ({}, {"width_m": 6.0, "height_m": 20.0}, {"outlet": {"width_m": 0.08}}):
        scene = Scene(silo=Silo(**silo))
        made = {name: changed(scene, one.values(scene)) for name, one in FIDELITIES.items()}
        assert made["standard"] == scene, "the default"
        assert [like(one) for one in made.values()] == list(FIDELITIES)
        across = [one.silo.width_m / one.grid.cell_size_m for one in made.values()]
        assert across == pytest.approx([20, 40, 100, 130], rel=0.06)
        froude = [one.flow.speed_m_per_s / math.sqrt(9.81 * one.silo.width_m) for one in made.values()]
        assert froude == pytest.approx([FROUDE * one.hurry for one in FIDELITIES.values()], rel=0.06)
    wanted = {"grid.points_per_cell": 4, "averaging.characteristic_length_m": 0.0, "method.noise_control": "none"}
    for other in ({path: one} for path, one in wanted.items()):
        assert like(changed(Scene(), other)) is None, "whose errors are others"
    with pytest.raises(BadInput, match="fidelity is perfect; it must be one of draft, standard, fine, converged"):
        fidelity("perfect")

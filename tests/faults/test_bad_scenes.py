"""Scenes that nobody could mean: each is refused in one short sentence before any work, or it runs, and rightly.

What is tried follows from the types themselves: a new value of the scene is tried without a word here.
"""

import copy
import datetime
import math
import re
import time

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from taichi_silo import api, reference, runtime
from taichi_silo.faults import BadInput, RunFailed
from taichi_silo.quoting import LONGEST
from taichi_silo.scene import Scene
from taichi_silo.scene_file import read_scene, scene_of
from taichi_silo.simulation import Simulation
from taichi_silo.table import one_sentence

JARGON = re.compile(r"Value error|instance of|Input |dictionary|\btuple|pydantic|<object|validat|Traceback|Error\b|\\x")
SECONDS = 5.0
SMALL = {  # 8 x 4 cells
    "silo": {"width_m": 0.2, "height_m": 0.4}, "grid": {"cell_size_m": 0.05},
    "flow": {"speed_m_per_s": 0.02, "displacement_m": 0.01},
    "method": {"filling_time_s": 0.1, "longest_settling_s": 0.0}, "machine": {"threads": 1, "lanes": False},
}  # fmt: skip
OPTIONAL = {
    "silo.outlet.": {"width_m": 0.1},
    "silo.hopper.": {"half_angle_deg": 30.0, "outlet_width_m": 0.1},
    "silo.inserts[].": [{"kind": "roof", "width_m": 0.06, "bottom_m": 0.1}],
}


def deep(levels):
    found = []
    for _ in range(levels):
        found = [found]
    return found


VALUES = [
    None, True, False, math.nan, math.inf, -math.inf, -1, -1.0, 0, -0.0, 5e-324, 1e-300, 1e-30, 1e-9, 0.5, 1, 3, 7, 1e3,
    1e9, 1e15, 1e300, 10**400, -(10**400), 16**6000, "", "x", "1", "0.2", "nan", "\x00a", "a\nb", "a" * 1_000_000,
    "\u202eabc", "\ud800", "🙂", "../x", "/etc/passwd", [], [1], [[0, 0]], [0.1, 0.2], {}, {"a": 1}, {"a": {"a": {}}},
    deep(5000), datetime.date(2020, 1, 1), datetime.time(1), b"ab", object(), [math.nan] * 3, [[True, 0], [1, 0], [1, 1]],
    [[0, 0], [1, 0], [1, "x"]], [[0, 0], [0.2, 0], [0.2, 10**400]], [[0, 0], [1e300, 0], [0, 1e300]], range(3), {1, 2},
]  # fmt: skip
PATHS = [*(entry.path for entry in reference.entries()), *reference.tables_of()]


def with_value(path, value):
    """The tables of a small scene with a value at a path of the reference."""
    tables = copy.deepcopy(SMALL)
    for before, table in OPTIONAL.items():
        if f"{path}.".startswith(before):
            tables["silo"][before.split(".")[1].removesuffix("[]")] = copy.deepcopy(table)
    *names, last = path.removesuffix("[]").split(".")
    table = tables
    for name in names:
        table = table[name[:-2]][0] if name.endswith("[]") else table.setdefault(name, {})
    table[last] = value
    return tables


def refusal(make):
    """The sentence with which something is refused, None if it is not; it is one, short, and comes soon."""
    begun = time.monotonic()
    try:
        make()
    except BadInput as error:
        words = str(error)
    except ValidationError as error:
        words = one_sentence(error)
    else:
        return None
    assert time.monotonic() - begun < SECONDS
    assert 0 < len(words) <= LONGEST and words.isprintable(), words
    assert not JARGON.search(words), words
    return words


@pytest.mark.parametrize("path", PATHS)
def test_whatever_a_value_is_it_is_refused_in_a_sentence_that_names_it_or_possible(path, tried):
    refused = 0
    for value in VALUES:
        words = refusal(lambda value=value: scene_of(with_value(path, value)))
        refused += words is not None
        simple = isinstance(value, float) and not 1e-8 < abs(value) < 1e4
        last = path.removesuffix("[]").split(".")[-1]
        if words is not None and simple and value != 0.0:
            named = {*path.split("."), last.split("_")[0], "roof"}  # the kind of walls is called walls
            assert any(name in words for name in named), words
    assert refused
    tried("inputs refused", "a wrong value at a key of the scene", refused)


def test_values_that_are_refused_name_their_range(tried):
    """Both ends of it, where there are two."""
    count = 0
    for entry in reference.entries():
        ends = [float(word) for word in re.findall(r"[\d.e+-]+", entry.limits)]
        for end in ends:
            beyond = -1.0 if end == 0.0 else 1e13 if end == max(ends) and len(ends) > 1 else -1.0
            words = refusal(lambda path=entry.path, beyond=beyond: scene_of(with_value(path, beyond)))
            assert words is not None and all(f"{one:g}" in words for one in ends), (entry, words)
            count += 1
    assert count > 60
    tried("inputs refused", "a number outside of its range", count)


@pytest.mark.parametrize("table", [*(path.removesuffix("[]") for path in reference.tables_of()), ""])
def test_an_unknown_name_is_refused(table, tried):
    names = [
        "nonsense",
        "",
        " ",
        "WIDTH_M",
        "width",
        "__class__",
        "model_config",
        "a" * 1_000_000,
        "a\nb",
        "\u202e",
        "../x",
    ]
    for name in names:
        path = f"{table}.{name}" if table else name
        tables = with_value("silo.width_m", 0.2)
        for before, optional in OPTIONAL.items():
            if f"{table}.".startswith(before.replace("[]", "")):
                tables["silo"][table.split(".")[1]] = copy.deepcopy(optional)
        inner = tables
        for step in filter(None, table.split(".")):
            inner = inner.setdefault(step, {})
            inner = inner[0] if isinstance(inner, list) else inner
        inner[name] = 1
        words = refusal(lambda tables=tables: scene_of(tables))
        assert words is not None and "is not a parameter" in words, path
    tried("inputs refused", "an unknown name", len(names))


CONFLICTS = [
    ({"silo.outlet": {"width_m": 0.1}, "silo.hopper": {"half_angle_deg": 30, "outlet_width_m": 0.1}}, "not both"),
    ({"silo.outlet": {"width_m": 0.3}}, "outlet width is 0.3"),
    ({"silo.outlet": {"width_m": 0.2}}, "outlet width is 0.2"),
    ({"silo.outlet": {"width_m": 0.0}}, "width_m is 0"),
    ({"silo.outlet": {"width_m": 0.1, "position": 0.19}}, "outlet position is 0.19"),
    ({"silo.outlet": {"width_m": 0.1, "position": -5.0}}, "outlet position is -5"),
    ({"silo.outlet": {"width_m": 0.1, "position": 1e300}}, "outlet position is 1e+300"),
    ({"silo.outlet": {"width_m": 0.07}}, "outlet width is 0.07"),
    (
        {"silo.outlet": {"width_m": 0.1}, "silo.inserts": [{"kind": "roof", "width_m": 0.3, "bottom_m": 0.1}]},
        "below the surface",
    ),
    ({"silo.hopper": {"half_angle_deg": 0, "outlet_width_m": 0.1}}, "half_angle_deg is 0"),
    ({"silo.hopper": {"half_angle_deg": 90, "outlet_width_m": 0.1}}, "half_angle_deg is 90"),
    ({"silo.hopper": {"half_angle_deg": 1, "outlet_width_m": 0.1}}, "half angle of the hopper is 1"),
    ({"silo.hopper": {"half_angle_deg": 30, "outlet_width_m": 0.2}}, "outlet width of the hopper is 0.2"),
    ({"silo.height_m": 1e-9}, "height_m is 1e-09"),
    ({"silo.width_m": 1e9}, "width_m is 1000000000.0"),
    ({"silo.width_m": 1000.0, "silo.height_m": 1000.0}, "makes"),
    ({"grid.cell_size_m": 1e-5}, "makes"),
    ({"grid.cell_size_m": 0.4}, "cell size is 0.4"),
    ({"grid.points_per_cell": 10_000, "silo.width_m": 100.0, "silo.height_m": 100.0}, "makes"),
    ({"walls": {"kind": "very-rough", "friction_angle_deg": 20}}, "friction angle is 20"),
    ({"method": {"time_step_s": 1e-5, "cfl": 0.5}}, "cfl is 0.5"),
    ({"method": {"transfer": "cpic"}}, "transfer is cpic"),
    ({"sand": {"e_d0": 0.9, "e_c0": 0.8}}, "limits of the void ratio"),
    ({"sand": {"void_ratio": 0.3}}, "void ratio is 0.3"),
    ({"sand": {"intergranular": {"m_R": 2, "m_T": 3}}}, "m_T is 3"),
    ({"flow": {"outflow": "gravity"}}, "outflow is gravity"),
    ({"flow": {"displacement_m": 0.5}}, "displacement is 0.5"),
    ({"filling": {"kind": "rain", "drop_m": 3.0}}, "drop is 3"),
    ({"averaging": {"characteristic_length_m": 0.3}}, "characteristic length is 0.3"),
    ({"silo.section": "round", "silo.outlet": {"width_m": 0.1, "position": "left"}}, "round"),
    ({"silo.half": "yes", "silo.outlet": {"width_m": 0.1, "position": "left"}}, "half is yes"),
    ({"machine.threads": 100_000}, "threads is 100000"),
    ({"machine.arch": "abacus"}, "arch is abacus"),
    ({"sand.name": "hostum"}, "did you mean hostun"),
    ({"sand.name": "mine", "sand.n": 0.5}, "critical_friction_angle_deg is missing"),
]


@pytest.mark.parametrize(("changes", "word"), CONFLICTS, ids=range(len(CONFLICTS)))
def test_choices_that_do_not_go_together_are_refused(changes, word, tried):
    tables = copy.deepcopy(SMALL)
    for path, value in changes.items():
        *names, last = path.split(".")
        table = tables
        for name in names:
            table = table.setdefault(name, {})
        table[last] = value
    words = refusal(lambda: scene_of(tables))
    assert words is not None and word in words, words
    tried("inputs refused", "choices that do not go together")


def turned(corners, about=(0.1, 0.2), size=0.04):
    return [[about[0] + size * x, about[1] + size * y] for x, y in corners]


SQUARE = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
CIRCLE = [(math.cos(0.002 * math.pi * k), math.sin(0.002 * math.pi * k)) for k in range(1000)]
POLYGONS = {  # corners about the origin, and the word with which they are refused, or nothing
    "crosses itself": ([(-1, -1), (1, 1), (1, -1), (-1, 1)], "self-intersection"),
    "touches itself": ([(-1, -1), (1, -1), (0, 0), (1, 1), (-1, 1), (0, 0)], "self-intersection"),
    "has a spike": ([(-1, -1), (1, -1), (1, 0), (1.5, 0), (1, 0), (1, 1), (-1, 1)], "simple polygon"),
    "has no corner": ([], "0 corners"),
    "has one corner": ([(0, 0)], "0 corners"),
    "has two corners": ([(0, 0), (1, 0)], "2 corners"),
    "has three corners in one place": ([(0, 0)] * 3, "0 corners"),
    "lies on a line": ([(-1, 0), (0, 0), (1, 0)], "simple polygon"),
    "has a hair's area": ([(-1, 0), (1, 0), (0, 1e-12)], "no area"),
    "has too many corners": ([SQUARE[k % 4] for k in range(1001)], "at most 1000"),
    "has a million corners": ([(0.0, 0.0)] * 1_000_000, "at most 1000"),
    "has a corner that is none": ([(math.nan, 0), *SQUARE], "finite number"),
    "has a corner without end": ([(math.inf, 0), *SQUARE], "finite number"),
    "has a corner far away": ([(1e300, 0), *SQUARE], "must be between -1000 and 1000"),
    "crosses a wall": ([(-5, -1), (1, -1), (1, 1)], "free of the walls"),
    "lies outside": ([(100 + x, y) for x, y in SQUARE], "free of the walls"),
    "covers everything": ([(2.5 * x, 5 * y) for x, y in SQUARE], "must"),
    "runs clockwise": (SQUARE[::-1], None),
    "repeats a corner": ([SQUARE[0], SQUARE[0], *SQUARE[1:]], None),
    "repeats its first corner at its end": ([*SQUARE, SQUARE[0]], None),
    "has as many corners as it may": (CIRCLE, None),
}


@pytest.mark.parametrize("kind", POLYGONS)
def test_a_polygon_in_the_sand_is_refused_or_a_scene(kind, tried):
    corners, word = POLYGONS[kind]
    insert = {"kind": "polygon", "corners_m": turned(corners)}
    tables = SMALL | {"silo": SMALL["silo"] | {"inserts": [insert]}}
    words = refusal(lambda: scene_of(tables))
    if word is None:
        assert words is None
        fills(scene_of(tables))
        return
    assert words is not None and word in words, words
    tried("inputs refused", "a body that is no simple polygon in the sand")


def fills(scene):
    """Its points stand in the silo, none in an insert, and weigh what the fill weighs."""
    x, y, area = scene.silo.lattice(scene.spacing_m)
    assert len(x) and scene.silo.holds(x, y).all()
    assert abs(area.sum() - scene.silo.area_m2) < 0.1 * scene.silo.area_m2


OUTLINES = {
    "crosses itself": [[0, 0], [0.2, 0.4], [0.2, 0], [0, 0.4]],
    "has two corners": [[0, 0], [0.2, 0]],
    "has no floor": [[0.1, 0], [0.2, 0.4], [0, 0.4]],
    "has no top": [[0, 0], [0.2, 0], [0.1, 0.4]],
    "turns down": [[0, 0], [0.2, 0], [0.2, 0.4], [0.15, 0.2], [0.1, 0.4], [0, 0.4]],
    "begins elsewhere": [[0.1, 0.1], [0.3, 0.1], [0.3, 0.5], [0.1, 0.5]],
    "is below the floor": [[0, -0.4], [0.2, -0.4], [0.2, 0], [0, 0]],
    "is not finite": [[0, 0], [0.2, 0], [0.2, math.inf], [0, 0.4]],
    "is larger than a mountain": [[0, 0], [1e6, 0], [1e6, 1e6], [0, 1e6]],
    "has triples": [[0, 0, 0], [0.2, 0, 0], [0.2, 0.4, 0]],
    "has words": [["left", "low"], ["right", "low"], ["right", "high"]],
    "has a million corners": [[0.0, 0.0]] * 1_000_000,
    "is flat": [[0, 0], [0.2, 0], [0.2, 1e-12], [0, 1e-12]],
}


@pytest.mark.parametrize("kind", OUTLINES)
def test_an_outline_that_is_no_silo_is_refused(kind, tried):
    tables = SMALL | {"silo": {"outline_m": OUTLINES[kind]}}
    assert refusal(lambda: scene_of(tables)) is not None
    tried("inputs refused", "an outline that is no silo")


ROOF = {"kind": "roof", "width_m": 0.06, "bottom_m": 0.1}
INSERTS = {
    "two in one place": [ROOF, ROOF],
    "two that cross": [ROOF, {"kind": "cylinder", "width_m": 0.05, "bottom_m": 0.12}],
    "one below the floor": [ROOF | {"bottom_m": -0.1}],
    "one on the floor": [ROOF | {"bottom_m": 0.0}],
    "one above the sand": [ROOF | {"bottom_m": 0.5}],
    "one beside the silo": [ROOF | {"position_m": 5.0}],
    "one in a wall": [ROOF | {"position_m": 0.01}],
    "one as wide as the silo": [ROOF | {"width_m": 0.2}],
    "one without a width": [{"kind": "roof", "bottom_m": 0.1}],
    "one without a kind": [{"width_m": 0.06, "bottom_m": 0.1}],
    "a roof with corners": [ROOF | {"corners_m": [[0, 0], [1, 0], [0, 1]]}],
    "a polygon with a width": [{"kind": "polygon", "corners_m": turned(SQUARE), "width_m": 0.1}],
    "a polygon without corners": [{"kind": "polygon"}],
    "too many": [ROOF] * 51,
    "far too many": [ROOF] * 100_000,
}


@pytest.mark.parametrize("kind", INSERTS)
def test_inserts_that_cannot_stand_are_refused(kind, tried):
    tables = SMALL | {"silo": SMALL["silo"] | {"inserts": INSERTS[kind]}}
    assert refusal(lambda: scene_of(tables)) is not None
    tried("inputs refused", "an insert that cannot stand")


# --- whatever else comes to mind --------------------------------------------------------------------------------------

numbers = st.one_of(
    st.floats(), st.integers(), st.integers(-(10**400), 10**400), st.sampled_from([0.05, 0.1, 0.2, 0.4, 1, 2, 4, 9]),
    st.floats(1e-12, 1e12),
)  # fmt: skip
values = st.one_of(
    numbers, st.booleans(), st.none(), st.text(max_size=30), st.lists(st.tuples(numbers, numbers), max_size=8),
    st.recursive(numbers, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
                 max_leaves=5),
)  # fmt: skip
SETTINGS = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]}


def changed(changes):
    tables = copy.deepcopy(SMALL)
    for path, value in changes:
        for before, table in OPTIONAL.items():
            name = before.split(".")[1].removesuffix("[]")
            if f"{path}.".startswith(before) and not isinstance(tables["silo"].get(name), dict | list):
                tables["silo"][name] = copy.deepcopy(table)
        *names, last = path.removesuffix("[]").split(".")
        table = tables
        for name in names:
            table = table[name[:-2]] if name.endswith("[]") else table.setdefault(name, {})
            table = table[0] if isinstance(table, list) and table and name.endswith("[]") else table
            if not isinstance(table, dict):
                return tables
        table[last] = value
    return tables


def tries(examples, derandomize):
    """Scenes with one to three changed values: how many were refused, and those that were not."""
    refused, possible = [], []

    @settings(max_examples=examples, derandomize=derandomize, **SETTINGS)
    @given(st.lists(st.tuples(st.sampled_from(PATHS[:-10]), values), min_size=1, max_size=3))
    def attempt(changes):
        tables = changed(changes)
        words = refusal(lambda: scene_of(tables))
        if words is None:
            scene = scene_of(tables)
            assert math.isfinite(scene.weight_N_per_m) and scene.points > 0
            possible.append(scene)
        else:
            refused.append(words)

    attempt()
    return refused, possible


def test_random_changes_of_a_scene_are_refused_in_a_sentence_or_possible(tried):
    refused, possible = tries(400, True)
    assert len(refused) > 100 and possible
    tried("inputs refused", "a scene with random values", len(refused))


@pytest.mark.long
def test_many_random_changes_are_too(tried):
    refused, possible = tries(20_000, False)
    tried("inputs refused", "a scene with random values", len(refused))


# --- what is not refused runs -----------------------------------------------------------------------------------------

STEPS_MOST = 3000


def runs(scene, intervals=4):
    """A few intervals: forces finite and in balance, or a sentence of what went wrong. False if it takes too long."""
    runtime.init()
    simulation = Simulation(scene)
    step = scene.method.time_step(simulation.solver.survey(), 0.95)
    if simulation.interval * intervals / step > STEPS_MOST or scene.points > 20_000:
        return False
    try:
        for _, record in zip(range(intervals), simulation.run(), strict=False):
            forces = [record.bottom_N_per_m, record.left_shear_N_per_m, record.right_shear_N_per_m]
            forces += [upwards for _, upwards in record.bodies_N_per_m.values()]
            assert np.isfinite(forces).all()
            rest = record.weight_N_per_m + record.momentum_rate_N_per_m - record.control_N_per_m
            scale = max(map(abs, [*forces, record.weight_N_per_m, record.momentum_rate_N_per_m, 1e-12]))
            assert abs(sum(forces) - rest) < 1e-9 * scale
    except RunFailed as error:
        assert 10 < len(str(error)) < 1000 and "\n" not in str(error)
    return True


EXTREMES = [  # ends of what is allowed
    {"sand.granular_hardness_Pa": 1e5}, {"sand.granular_hardness_Pa": 1e12}, {"sand.n": 0.01}, {"sand.n": 0.99},
    {"sand.alpha": 0.001}, {"sand.beta": 20}, {"sand.grain_density_kg_per_m3": 10}, {"sand.e_i0": 10},
    {"sand.grain_density_kg_per_m3": 1e5}, {"sand.critical_friction_angle_deg": 5}, {"sand.void_ratio": 0.5100001},
    {"sand.critical_friction_angle_deg": 80}, {"sand.void_ratio": 1.2999}, {"method.gravity_m_per_s2": 0.01},
    {"method.gravity_m_per_s2": 1e4}, {"method.cfl": 2}, {"method.time_step_s": 1}, {"method.mass_scaling": 1e6},
    {"method.filling_time_s": 1e-6}, {"flow.speed_m_per_s": 1}, {"flow.speed_m_per_s": 1e-9},
    {"flow.displacement_m": 1e-9}, {"flow.displacement_m": 0.4}, {"walls.bottom_friction_angle_deg": 89.999999},
    {"walls.kind": "smooth", "walls.friction_angle_deg": 89.9999}, {"filling.kind": "layers", "filling.layers": 1000},
    {"filling.kind": "rain", "filling.drop_m": 0}, {"filling.kind": "rain", "filling.drop_m": 0.4},
    {"grid.points_per_cell": 100}, {"averaging.characteristic_length_m": 0.2}, {"sand.d50_m": 1e-7},
    {"output.records_per_period": 100}, {"sand.law": "intergranular", "sand.intergranular.radius": 1e-7},
    {"sand.law": "intergranular", "sand.intergranular.chi": 100}, {"sand.name": "🙂 <b>$\\frac"},
    {"silo.outlet.width_m": 0.1, "flow.outflow": "gravity", "flow.longest_s": 1e6},
    {"silo.hopper": {"half_angle_deg": 79.9, "outlet_width_m": 0.1}},
    {"silo.outlet.width_m": 0.1, "silo.inserts": [{"kind": "roof", "width_m": 1e-4, "bottom_m": 1e-9}]},
    {"silo.inserts": [{"kind": "polygon", "corners_m": turned(SQUARE[::-1] + SQUARE[:1])}]},
    {"silo.inserts": [{"kind": "polygon", "corners_m": turned(CIRCLE)}]},
    {"silo.width_m": 0.001, "silo.height_m": 0.002, "grid.cell_size_m": 0.00025, "flow.displacement_m": 1e-4},
    {"silo.width_m": 1000.0, "silo.height_m": 1000.0, "grid.cell_size_m": 100.0},
]  # fmt: skip


def extreme(changes):
    tables = copy.deepcopy(SMALL)
    for path, value in changes.items():
        *names, last = path.split(".")
        table = tables
        for name in names:
            table = table.setdefault(name, {})
        table[last] = value
    if "sand.name" in changes:
        return Scene.model_validate(tables)
    return scene_of(tables)


def runs_or_is_refused(changes):
    words = refusal(lambda: extreme(changes))
    return "refused" if words else "run" if runs(extreme(changes)) else "not run"


@pytest.mark.parametrize("number", [24, 38])
def test_scenes_at_the_ends_of_what_is_allowed_run(number, tried):
    assert runs_or_is_refused(EXTREMES[number]) == "run"
    tried("inputs run", "a scene at the ends of what is allowed")


@pytest.mark.long
@pytest.mark.parametrize("number", range(len(EXTREMES)))
def test_all_scenes_at_the_ends_of_what_is_allowed_run_or_are_refused(number, tried):
    if runs_or_is_refused(EXTREMES[number]) == "run":
        tried("inputs run", "a scene at the ends of what is allowed")


@pytest.mark.long
def test_random_scenes_that_are_not_refused_run(tried):
    _, possible = tries(2000, False)
    done = sum(runs(scene) for scene in possible[:150])
    tried("inputs run", "a scene with random values", done)


# --- from Python ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [None, 3, "scene.toml", [], object(), {"silo": 3}, {1: 2}, {"a" * 10**6: {}},
                                   {"silo": {"width_m": object()}}], ids=range(9))  # fmt: skip
def test_what_is_no_scene_is_refused_by_run(scene, tmp_path, tried):
    words = refusal(lambda: api.run(scene, tmp_path / "run", progress=False))
    assert words and not list(tmp_path.iterdir())
    tried("inputs refused", "a call of run with what is no scene")


def test_a_scene_that_was_changed_without_being_checked_is_refused(tmp_path, tried):
    good = Scene.model_validate(SMALL)
    changed = [
        good.model_copy(update={"flow": good.flow.model_copy(update={"speed_m_per_s": -1.0})}),
        good.model_copy(update={"silo": good.silo.model_copy(update={"width_m": 0.21})}),
        good.model_copy(update={"silo": None}),
        good.model_copy(update={"machine": "cpu"}),
    ]
    for scene in changed:
        assert refusal(lambda scene=scene: api.run(scene, tmp_path / "run", progress=False))
    assert not list(tmp_path.iterdir())
    tried("inputs refused", "a call of run with what is no scene", len(changed))


@pytest.mark.parametrize(
    "folder", [3, "a\x00b", "x" * 5000, "~nobody-of-this-name/run", "\ud800\ud800", [], b"\xff"], ids=range(7)
)
def test_what_is_no_path_is_refused(folder, tmp_path, monkeypatch, tried):
    monkeypatch.chdir(tmp_path)
    assert refusal(lambda: api.run(Scene.model_validate(SMALL), folder, progress=False))
    assert refusal(lambda: api.resume(folder, progress=False))
    assert refusal(lambda: read_scene(folder))
    assert not list(tmp_path.iterdir())
    tried("inputs refused", "a path that can be none", 3)


def test_what_is_no_observer_is_refused(tmp_path, tried):
    assert refusal(lambda: api.run(SMALL, tmp_path / "run", progress=False, extra=(3,)))
    assert not list(tmp_path.iterdir())
    tried("inputs refused", "a call of run with what is no observer")

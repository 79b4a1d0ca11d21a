"""Scenes that nobody could mean: each is refused in one short sentence before any work, or it runs, and rightly.

What is tried follows from the types themselves: a new value of the scene is tried without a word here.
"""

import copy
import datetime
import math
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from taichi_silo.scene import reference
from taichi_silo.scene.scene_files import scene_of
from tests.faults import bad
from tests.faults.bad import refusal
from tests.faults.test_edge_scenes import runs
from tests.smallest import TABLES

OPTIONAL = {
    "silo.outlet.": {"width_m": 0.1},
    "silo.hopper.": {"half_angle_deg": 30.0, "outlet_width_m": 0.1},
    "silo.inserts.0.": [{"kind": "roof", "width_m": 0.06, "bottom_m": 0.1}],
    "sand.layers.0.": [{"from_m": 0.1, "void_ratio": 0.7}],
    "walls.bands.0.": [{"to_m": 0.1, "friction_angle_deg": 10.0}],
}


def deep(levels):
    found = []
    for _ in range(levels):
        found = [found]
    return found


VALUES = [
    None, True, False, math.nan, math.inf, -math.inf, -1, -1.0, 0, -0.0, 5e-324, 1e-300, 1e-30, 1e-9, 0.5, 1, 3, 7,
    1e3, 1e9, 1e15, 1e300, 10**400, -(10**400), 16**6000, "", "x", "1", "0.2", "nan", "\x00a", "a\nb",
    "a" * 1_000_000, "\u202eabc", "\ud800", "🙂", "../x", "/etc/passwd", [], [1], [[0, 0]], [0.1, 0.2], {}, {"a": 1},
    {"a": {"a": {}}}, deep(5000), datetime.date(2020, 1, 1), datetime.time(1), b"ab", object(), [math.nan] * 3,
    [[True, 0], [1, 0], [1, 1]], [[0, 0], [1, 0], [1, "x"]], [[0, 0], [0.2, 0], [0.2, 10**400]],
    [[0, 0], [1e300, 0], [0, 1e300]], range(3), {1, 2},
]  # fmt: skip
PATHS = [*(entry.path for entry in reference.entries()), *reference.tables_of()]


def with_value(path, value):
    """The tables of a small scene with a value at a path of the reference."""
    tables = copy.deepcopy(TABLES)
    for before, table in OPTIONAL.items():
        if f"{path}.".startswith(before):
            tables.setdefault(before.split(".")[0], {})[before.split(".")[1]] = copy.deepcopy(table)
    *names, last = path.removesuffix(".0").split(".")
    table = tables
    for name in names:
        table = table[0] if name == "0" else table.setdefault(name, {})
    table[last] = value
    return tables


@pytest.mark.parametrize("path", PATHS)
def test_whatever_a_value_is_it_is_refused_in_a_sentence_that_names_it_or_possible(path, tried):
    refused = 0
    for value in VALUES:
        words = refusal(lambda value=value: scene_of(with_value(path, value)))
        refused += words is not None
        simple = isinstance(value, float) and not 1e-8 < abs(value) < 1e4
        last = path.removesuffix(".0").split(".")[-1]
        if words is not None and simple and value != 0.0:
            named = {
                *path.replace(".0", "").split("."),
                last.split("_")[0],
                "roof",
            }  # walls.kind is "walls"
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


@pytest.mark.parametrize("table", [*(path.removesuffix(".0") for path in reference.tables_of()), ""])
def test_an_unknown_name_is_refused(table, tried):
    names = [
        "nonsense",
        "",
        " ",
        "WIDTH_M",
        "width",
        "__class__",
        "model_config",
        "a" * 10**6,
        "a\nb",
        "\u202e",
        "../x",
    ]
    for name in names:
        path = f"{table}.{name}" if table else name
        tables = with_value("silo.width_m", 0.2)
        for before, optional in OPTIONAL.items():
            if f"{table}.".startswith(before.replace(".0", "")):
                tables.setdefault(table.split(".")[0], {})[table.split(".")[1]] = copy.deepcopy(optional)
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
    tables = bad.changed(TABLES, changes)
    words = refusal(lambda: scene_of(tables))
    assert words is not None and word in words, words
    tried("inputs refused", "choices that do not go together")


# --- whatever else comes to mind --------------------------------------------------------------------------------------

numbers = st.one_of(
    st.floats(),
    st.integers(),
    st.integers(-(10**400), 10**400),
    st.sampled_from([0.05, 0.1, 0.2, 0.4, 1, 2, 4, 9]),
    st.floats(1e-12, 1e12),
)
values = st.one_of(
    numbers,
    st.booleans(),
    st.none(),
    st.text(max_size=30),
    st.lists(st.tuples(numbers, numbers), max_size=8),
    st.recursive(
        numbers,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
        max_leaves=5,
    ),
)
SETTINGS = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]}


def changed(changes):
    tables = copy.deepcopy(TABLES)
    for path, value in changes:
        if not isinstance(tables["silo"], dict):
            return tables
        for before, table in OPTIONAL.items():
            name = before.split(".")[1]
            if f"{path}.".startswith(before) and not isinstance(tables["silo"].get(name), dict | list):
                tables["silo"][name] = copy.deepcopy(table)
        *names, last = path.removesuffix(".0").split(".")
        table = tables
        for name in names:
            if name == "0":
                table = table[0] if isinstance(table, list) and table else None
            else:
                table = table.setdefault(name, {})
            if not isinstance(table, dict | list):
                return tables
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


@pytest.mark.long
def test_random_scenes_that_are_not_refused_run(tried):
    _, possible = tries(2000, False)
    done = sum(runs(scene) for scene in possible[:150])
    tried("inputs run", "a scene with random values", done)

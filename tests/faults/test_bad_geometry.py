"""Polygons, outlines and inserts that no silo can have are refused in a sentence; odd ones that one can have run."""

import math

import pytest

from taichi_silo.scene.scene_files import scene_of
from tests.faults.bad import CIRCLE, SQUARE, refusal, turned
from tests.smallest import TABLES

POLYGONS = {  # corners about the origin, and the word with which they are refused, or nothing
    "crosses itself": ([(-1, -1), (1, 1), (1, -1), (-1, 1)], "touch or cross each other at ("),
    "touches itself": ([(-1, -1), (1, -1), (0, 0), (1, 1), (-1, 1), (0, 0)], "touch or cross each other at ("),
    "has a spike": ([(-1, -1), (1, -1), (1, 0), (1.5, 0), (1, 0), (1, 1), (-1, 1)], "touch or cross"),
    "has no corner": ([], "0 corners"),
    "has one corner": ([(0, 0)], "0 corners"),
    "has two corners": ([(0, 0), (1, 0)], "2 corners"),
    "has three corners in one place": ([(0, 0)] * 3, "0 corners"),
    "lies on a line": ([(-1, 0), (0, 0), (1, 0)], "lie on one line"),
    "has a hair's area": ([(-1, 0), (1, 0), (0, 1e-12)], "lie on one line"),
    "has too many corners": ([SQUARE[k % 4] for k in range(1001)], "at most 1000"),
    "has 200,000 corners": ([(0.0, 0.0)] * 200_000, "at most 1000"),
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
    tables = TABLES | {"silo": TABLES["silo"] | {"inserts": [insert]}}
    words = refusal(lambda: scene_of(tables))
    if word is None:
        assert words is None
        fills(scene_of(tables))
        return
    assert words is not None and word in words, words
    tried("inputs refused", "a body that is no simple polygon in the sand")


def fills(scene):
    """Its points stand in the silo, none in an insert, and weigh what the fill weighs."""
    x, y, area = scene.silo.lattice(scene.spacing_m, scene.rise_m)
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
    "has 200,000 corners": [[0.0, 0.0]] * 200_000,
    "is flat": [[0, 0], [0.2, 0], [0.2, 1e-12], [0, 1e-12]],
}


ROOF = {"kind": "roof", "width_m": 0.06, "bottom_m": 0.1}
INSERTS = {
    "two in one place": [ROOF, ROOF],
    "two that cross": [ROOF, {"kind": "cylinder", "width_m": 0.05, "bottom_m": 0.12}],
    "one below the floor": [ROOF | {"bottom_m": -0.1}],
    "one on the floor": [ROOF | {"bottom_m": 0.0}],
    "one above the sand": [ROOF | {"bottom_m": 0.5}],
    "one in millimetres": [{"kind": "roof", "width_m": 60.0, "bottom_m": 100.0}],
    "one beside the silo": [ROOF | {"position_m": 5.0}],
    "one in a wall": [ROOF | {"position_m": 0.01}],
    "one as wide as the silo": [ROOF | {"width_m": 0.2}],
    "one without a width": [{"kind": "roof", "bottom_m": 0.1}],
    "without place": [{"kind": "roof"}],
    "one without a kind": [{"width_m": 0.06, "bottom_m": 0.1}],
    "a roof with corners": [ROOF | {"corners_m": [[0, 0], [1, 0], [0, 1]]}],
    "a polygon with a width": [{"kind": "polygon", "corners_m": turned(SQUARE), "width_m": 0.1}],
    "a polygon without corners": [{"kind": "polygon"}],
    "too many": [ROOF] * 51,
    "far too many": [ROOF] * 100_000,
}


SAID = {  # of some of these, what the sentence must name
    "two that cross": ["inserts 1 and 2 meet at (0.1", "stand apart"],
    "one above the sand": ["up to 0.56 m", "surface of the fill"],
    "one in millimetres": ["up to 160 m", "in mm?"],
    "one without a width": ["width_m must be given"],
    "without place": ["width_m and bottom_m must be given"],
}


CASES = [("an outline that is no silo", kind, {"outline_m": corners}) for kind, corners in OUTLINES.items()]
CASES += [("an insert that cannot stand", kind, TABLES["silo"] | {"inserts": them}) for kind, them in INSERTS.items()]


@pytest.mark.parametrize(("what", "kind", "silo"), CASES, ids=[kind for _, kind, _ in CASES])
def test_an_outline_or_inserts_that_cannot_be_are_refused(what, kind, silo, tried):
    words = refusal(lambda: scene_of(TABLES | {"silo": silo}))
    assert words is not None and all(part in words for part in SAID.get(kind, [])), words
    tried("inputs refused", what)

"""Silos from DXF drawings: what is taken of each kind of drawing, and what is asked."""

import math
import random
import re
import sys
import tomllib

import ezdxf
import numpy as np
import pytest

from taichi_silo.cli import app
from taichi_silo.errors import BadInput
from taichi_silo.scene.drawing.choice import Unclear
from taichi_silo.scene.drawing.units import units
from taichi_silo.scene.dxf import read_drawing, read_silo
from taichi_silo.scene.scene_files import read_scene, scene_of
from taichi_silo.scene.silo import Silo

BUNKER = [(60, 0), (120, 0), (160, 140), (200, 140), (200, 400), (0, 400), (0, 200)]
BIN = [(60, 0), (140, 0), (200, 200), (200, 500), (0, 500), (0, 200)]  # 0.2 m x 0.5 m, its outlet 0.08 m
SHELL = [(50, -10), (150, -10), (210, 195), (210, 510), (-10, 510), (-10, 195)]  # around it, 10 mm thick
BORDER = [(-200, -150), (500, -150), (500, 700), (-200, 700)]
AREA = 0.2 * 0.3 + 0.5 * (0.08 + 0.2) * 0.2  # of BIN [m2]


@pytest.fixture
def drawn(tmp_path):
    def of(*closed, units=4, shift=(0, 0), draw=None, version="R2010", name="silo.dxf"):
        document = ezdxf.new(version, units=units if version != "R12" else 0)
        space = document.modelspace()
        for corners in closed:
            space.add_polyline2d([(x + shift[0], y + shift[1]) for x, y in corners], close=True)
        if draw:
            draw(space)
        file = tmp_path / name
        document.saveas(file)
        return file

    return of


def on(layer):
    return {"layer": layer}


def closed(space, corners, layer="0"):
    return space.add_lwpolyline(corners, close=True, dxfattribs=on(layer))


def as_lines(space, corners, close=True, astray=0.0):
    """Each side a LINE, in any order and sense, its ends astray by up to half of a length."""
    some = random.Random(3)
    sides = list(zip(corners, corners[1:] + (corners[:1] if close else []), strict=False))
    some.shuffle(sides)
    for side in sides:
        ends = side[::-1] if some.random() < 0.5 else side
        space.add_line(*[tuple(one + astray * (some.random() - 0.5) for one in end) for end in ends])


def is_the_bin(silo, rel=1e-9):
    assert silo.area_m2 == pytest.approx(AREA, rel=rel)
    assert (silo.width_m, silo.height_m) == pytest.approx((0.2, 0.5), rel=max(rel, 1e-9))
    assert silo.floor_m == pytest.approx((0.06, 0.14), rel=max(rel, 1e-9))
    assert silo.feet_m == pytest.approx((0.2, 0.2), rel=max(rel, 1e-9))


def said(drawing):
    return " ".join(drawing.words)


# --- closed lines, units ----------------------------------------------------------------------------------------------


def test_a_closed_line_in_millimetres_is_the_silo_in_metres(drawn):
    silo = read_silo(drawn(BUNKER, shift=(1000, -35)))
    expected = Silo.polygon([(x / 1e3, y / 1e3) for x, y in BUNKER])
    assert silo.area_m2 == pytest.approx(expected.area_m2, rel=1e-9)
    assert silo.floor_m == pytest.approx((0.06, 0.12))
    assert silo.feet_m == pytest.approx((0.2, 0.14))


def test_lines_within_are_inserts_and_circles_become_corners(drawn):
    def draw(space):
        space.add_circle((100, 260), 20)
        space.add_line((0, 0), (50, 50))
        space.add_text("silo")

    drawing = read_drawing(drawn(BUNKER, draw=draw))
    (body,) = drawing.silo.inserts
    assert body.kind == "polygon"
    assert body.area_m2() == pytest.approx(math.pi * 0.02**2, rel=0.05)
    assert "1 body" in said(drawing)
    assert "Open lines passed over (1)" in said(drawing)


@pytest.mark.parametrize(("units", "unit", "scale"), [(6, None, 1.0), (4, "m", 1.0), (0, "cm", 0.01)])
def test_the_unit_is_that_of_the_drawing_unless_it_is_given(drawn, units, unit, scale):
    silo = read_silo(drawn([(0, 0), (2, 0), (2, 5), (0, 5)], units=units), unit)
    assert (silo.width_m, silo.height_m) == pytest.approx((2 * scale, 5 * scale))


METRES = {  # of a header's code, by their definitions
    1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 1e-3, 5: 1e-2, 6: 1.0, 7: 1e3, 8: 2.54e-8, 9: 2.54e-5, 10: 0.9144, 11: 1e-10,
    12: 1e-9, 13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0, 17: 1e9, 18: 149597870700.0, 21: 1200 / 3937, 22: 100 / 3937,
    23: 3600 / 3937, 24: 6336000 / 3937,
}  # fmt: skip


@pytest.mark.parametrize("code", METRES)
def test_every_unit_that_a_header_can_name_is_read(drawn, code):
    metres = METRES[code]
    file = drawn([(x * 2e-3 / metres, y * 2e-3 / metres) for x, y in BIN], units=code)
    silo = read_silo(file)
    assert (silo.width_m, silo.height_m) == pytest.approx((0.4, 1.0), abs=2e-7)


def test_a_unit_has_a_name_on_the_command_line(drawn):
    file = drawn(BIN, units=0)
    for name in ("mm", "MM", "millimeters", "Millimetres"):
        is_the_bin(read_silo(file, name))
    assert read_silo(file, "inches").width_m == pytest.approx(200 * 0.0254)
    assert {"mm", "cm", "m", "in", "ft", "dm", "yd", "survey-ft"} <= set(units())
    with pytest.raises(BadInput, match=r"unit is furlong; it must be one of mm, cm, m, in, ft"):
        read_silo(file, "furlong")


def test_only_units_in_which_silos_are_drawn_are_offered(drawn):
    file = drawn(BIN, units=0)
    for unit in ("a", "l", "furlong", None):
        with pytest.raises(BadInput) as refused:
            read_silo(file, unit)
        named = set(re.split(r"[ ,;?]+", str(refused.value)))
        assert {"mm", "cm", "m", "in", "ft", "dm", "yd"} <= named
        assert not {"au", "ly", "pc", "gm", "angstrom", "nm", "mi", "mil"} & named


def test_a_drawing_without_a_unit_says_what_each_would_make_of_it(drawn):
    for version, code in (("R2010", 0), ("R12", 0)):
        with pytest.raises(BadInput, match=r"--unit mm, cm, m, in, ft .*mm: 0.2 m x 0.5 m"):
            read_silo(drawn(BIN, units=code, version=version))


def test_a_size_that_no_silo_has_names_the_unit_as_the_way(drawn):
    file = drawn(BIN, units=6)  # a program's default: metres
    with pytest.raises(BadInput, match=r"unit is m, as the drawing says; .*200 m wide.*--unit mm makes 0.2 m x 0.5 m"):
        read_silo(file)
    is_the_bin(read_silo(file, "mm"))


def test_a_file_without_a_header_says_no_unit(drawn):
    file = drawn(BIN, units=6)
    text = file.read_text(encoding="utf-8")
    file.write_text("  0\nSECTION\n  2\n" + text[text.index("ENTITIES") :], encoding="utf-8")
    with pytest.raises(BadInput, match="the drawing says none; give --unit mm"):
        read_silo(file)
    is_the_bin(read_silo(file, "mm"))


@pytest.mark.parametrize("far", [1e6, 4e8])
def test_what_lies_far_from_the_silo_is_named_as_what_makes_the_drawing_too_large(drawn, far):
    def draw(space):
        closed(space, BIN, "BIN")
        space.add_line((far, far), (far + 10, far))

    file = drawn(draw=draw)
    with pytest.raises(BadInput, match=r"lines that span .* implausible; delete what lies far .* with --layer"):
        read_silo(file)
    is_the_bin(read_silo(file, layers=["BIN"]))


def test_inches_get_a_word_as_many_programs_write_them_unasked(drawn):
    drawing = read_drawing(drawn(BIN, units=1))
    assert drawing.silo.width_m == pytest.approx(5.08)
    assert "5.08 m wide, 12.7 m high" in said(drawing)
    assert "--unit mm) it would be 0.2 m x 0.5 m" in said(drawing)


# --- layers, blocks, planes -------------------------------------------------------------------------------------------


def test_layers_may_be_chosen(drawn):
    file = drawn(draw=lambda space: (closed(space, BORDER, "BORDER"), closed(space, BIN, "BIN")))
    drawing = read_drawing(file, layers=["bin"])
    is_the_bin(drawing.silo)
    assert "layer BIN" in said(drawing)
    with pytest.raises(BadInput, match=r"layer is BINS; the drawing has lines on BIN, BORDER; did you mean BIN\?"):
        read_silo(file, layers=["BINS"])


@pytest.mark.parametrize("how", ["freeze", "off"])
def test_hidden_layers_are_passed_over_unless_they_are_chosen(drawn, how):
    def draw(space):
        getattr(space.doc.layers.add("OLD"), how)()
        closed(space, [(1.2 * x, 1.2 * y) for x, y in BIN], "OLD")
        closed(space, BIN, "NEW")

    file = drawn(draw=draw)
    drawing = read_drawing(file)
    is_the_bin(drawing.silo)
    assert "passed over: OLD" in said(drawing)
    assert read_silo(file, layers=["OLD"]).width_m == pytest.approx(0.24)


def test_a_layer_that_is_not_printed_is_passed_over(drawn):
    def draw(space):
        space.doc.layers.add("AID").dxf.plot = 0
        closed(space, [(1.2 * x, 1.2 * y) for x, y in BIN], "AID")

    drawing = read_drawing(drawn(BIN, draw=draw))
    is_the_bin(drawing.silo)
    assert "passed over: AID" in said(drawing)


def test_invisible_lines_are_passed_over_and_their_layer_is_not_called_hidden(drawn):
    def draw(space):
        closed(space, SHELL).dxf.invisible = 1

    drawing = read_drawing(drawn(BIN, draw=draw))
    is_the_bin(drawing.silo)
    assert "Invisible lines passed over (1)" in said(drawing)
    assert "layers that are off" not in said(drawing).lower()
    with pytest.raises(BadInput, match=r"no closed line: its lines are invisible"):
        read_silo(drawn(draw=draw))


def test_a_drawing_whose_layers_are_all_hidden_names_them(drawn):
    def draw(space):
        space.doc.layers.add("OLD").freeze()
        closed(space, BIN, "OLD")

    with pytest.raises(BadInput, match=r"off, frozen or not printed; --layer OLD"):
        read_silo(drawn(draw=draw))


def test_blocks_are_taken_apart(drawn):
    def draw(space):
        inner, outer = space.doc.blocks.new("BIN"), space.doc.blocks.new("PLANT")
        closed(inner, BIN)
        outer.add_blockref("BIN", (3, 4), dxfattribs={"xscale": 0.5, "yscale": 0.5})
        space.add_blockref("PLANT", (1000, 1000), dxfattribs={"layer": "SILO", "xscale": 2, "yscale": 2})

    drawing = read_drawing(drawn(draw=draw))
    is_the_bin(drawing.silo)
    assert "layer SILO" in said(drawing)  # layer 0 of a block is that of its place


@pytest.mark.parametrize("name", ["GONE", "PLANT"])
def test_a_block_that_is_in_another_file_is_passed_over_with_a_word(drawn, name):
    def draw(space):
        space.doc.add_xref_def("plant.dwg", "PLANT")
        space.doc.blocks.new("OUTER").add_blockref(name, (0, 0))
        space.add_blockref("OUTER", (0, 0))

    drawing = read_drawing(drawn(BIN, draw=draw))
    is_the_bin(drawing.silo)
    assert f"Blocks whose lines are in other files passed over: {name}" in said(drawing)
    with pytest.raises(BadInput, match=rf"its lines are in other files, as block {name}; bind"):
        read_silo(drawn(draw=draw))


def test_a_block_on_a_frozen_layer_is_passed_over(drawn):
    def draw(space):
        closed(space.doc.blocks.new("FRAME"), BORDER)
        space.doc.layers.add("SHEET").freeze()
        space.add_blockref("FRAME", (0, 0), dxfattribs=on("SHEET"))
        closed(space, BIN)

    is_the_bin(read_silo(drawn(draw=draw)))


@pytest.mark.parametrize(
    ("draw", "plane"),
    [
        (lambda space: space.add_polyline3d([(x, 7, y) for x, y in BIN], close=True), "x and z"),
        (lambda space: space.add_polyline3d([(7, x, y) for x, y in BIN], close=True), "y and z"),
        (lambda space: space.add_lwpolyline(BIN, close=True, dxfattribs={"extrusion": (0, -1, 0)}), "x and z"),
    ],
)
def test_a_side_view_may_stand_upright_in_space(drawn, draw, plane):
    drawing = read_drawing(drawn(draw=draw))
    is_the_bin(drawing.silo)
    assert plane in said(drawing)


def test_lines_in_space_are_refused(drawn):
    def draw(space):
        space.add_polyline3d([(x, 0, y) for x, y in BIN], close=True)
        space.add_circle((100, 100), 100)

    with pytest.raises(BadInput, match="not in one plane"):
        read_silo(drawn(draw=draw))


def test_paper_space_is_named(drawn):
    with pytest.raises(BadInput, match=r"paper space \(Layout1\)"):
        read_silo(drawn(draw=lambda space: closed(space.doc.layout("Layout1"), BIN)))


def test_a_closed_spline_is_a_body_however_its_knots_are_numbered(drawn):
    def draw(space):
        closed = space.add_spline()
        closed.set_closed([(76, 276, 0), (124, 276, 0), (124, 324, 0), (76, 324, 0)])
        closed.knots = [knot - 3.0 for knot in closed.knots]

    drawing = read_drawing(drawn(BIN, draw=draw))
    (body,) = drawing.silo.inserts
    assert body.breadth_m == pytest.approx(0.048 * 11 / 12, rel=1e-3)  # of a uniform cubic spline about a square


# --- lines that are joined --------------------------------------------------------------------------------------------


def test_lines_that_meet_are_joined(drawn):
    is_the_bin(read_silo(drawn(draw=lambda space: as_lines(space, BIN))))


def test_lines_drawn_twice_are_one(drawn):
    is_the_bin(read_silo(drawn(draw=lambda space: (as_lines(space, BIN), as_lines(space, BIN)))))
    is_the_bin(read_silo(drawn(BIN, BIN)))


def test_lines_arcs_and_polylines_are_joined(drawn):
    def draw(space):
        space.add_line((0, 480), (0, 200))
        space.add_arc((20, 480), 20, 90, 180)
        space.add_arc((180, 480), 20, 0, 90)
        space.add_line((20, 500), (180, 500))
        space.add_lwpolyline([(200, 480), (200, 200), (140, 0), (60, 0), (0, 200)])

    silo = read_silo(drawn(draw=draw))
    assert silo.area_m2 == pytest.approx(AREA - 2 * (1 - math.pi / 4) * 0.02**2, rel=1e-4)


def test_small_gaps_are_closed_with_a_word_and_large_ones_named(drawn):
    drawing = read_drawing(drawn(draw=lambda space: as_lines(space, BIN, astray=0.5)))
    is_the_bin(drawing.silo, rel=0.01)
    assert "Gaps of up to 0.00051 m in it were closed (6)" in said(drawing)
    wide = drawn(draw=lambda space: as_lines(space, BIN, astray=8))
    with pytest.raises(BadInput, match=r"ends 0.003528 m from each other .* --gap 0.00356"):
        read_silo(wide)
    is_the_bin(read_silo(wide, gap_m=0.01), rel=0.08)  # as far as its corners are astray
    with pytest.raises(BadInput, match="gap is -1 m"):
        read_silo(wide, gap_m=-1)


def cut_back(space, corners, gap, close=True):
    """Each side a LINE that ends so far before its corners that the ends at a corner are `gap` apart, or cross it."""
    turns = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    count = len(corners) if close else len(corners) - 1
    for k in range(count):
        (x, y), (u, v) = corners[k], corners[(k + 1) % len(corners)]
        before, after = (abs(gap / 2 / math.cos(0.5 * (turns[m] - turns[m - 1]))) for m in (k, (k + 1) % len(corners)))
        across, up = math.cos(turns[k]), math.sin(turns[k])
        space.add_line((x + before * across, y + before * up), (u - after * across, v - after * up))


@pytest.mark.parametrize("gap", [1.0, 2.5])  # 0.2 and 0.5 % of the height of 500
def test_corners_that_are_left_open_by_half_a_per_cent_are_closed_with_a_word(drawn, gap):
    drawing = read_drawing(drawn(draw=lambda space: cut_back(space, BIN, gap)))
    is_the_bin(drawing.silo, rel=0.03)
    assert drawing.silo.floor_m[1] - drawing.silo.floor_m[0] == pytest.approx(0.08, abs=2e-3 * gap)
    assert "Gaps of up to" in said(drawing)


def test_an_open_top_does_not_hide_that_corners_are_open(drawn):
    walls = [(200, 500), (200, 200), (140, 0), (60, 0), (0, 200), (0, 500)][::-1]
    drawing = read_drawing(drawn(draw=lambda space: cut_back(space, walls, 2.4, close=False)))
    assert drawing.silo.area_m2 == pytest.approx(AREA, rel=0.03)
    assert "Its open top was closed" in said(drawing)


def test_short_lines_of_a_curve_stay_a_curve(drawn):
    turn = np.linspace(0.0, np.pi, 400)
    arc = [(100 - 100 * math.cos(t), 200 - 80 * math.sin(t)) for t in turn]
    kept = [p for p in arc if not 60 < p[0] < 140]
    left, right = [p for p in kept if p[0] < 100], [p for p in kept if p[0] > 100]
    low = left[-1][1] - 10.0
    outline = [*left, (60, low), (140, low), *right, (200, 500), (0, 500)]
    exact = Silo.polygon([(x / 1e3, (y - low) / 1e3) for x, y in outline]).area_m2
    assert read_silo(drawn(draw=lambda space: as_lines(space, outline))).area_m2 == pytest.approx(exact, rel=5e-4)


OPEN = [(0, 500), (0, 200), (60, 0), (140, 0), (200, 200), (200, 500)]
LEFT, RIGHT = OPEN[:3], OPEN[3:]


@pytest.mark.parametrize(
    ("draw", "word"),
    [
        (lambda space: space.add_lwpolyline(OPEN), ["top"]),
        (lambda space: as_lines(space, OPEN, close=False), ["top"]),
        (lambda space: space.add_lwpolyline([*LEFT[::-1], *RIGHT[::-1]]), ["floor"]),
        (lambda space: (space.add_lwpolyline(LEFT), as_lines(space, RIGHT, close=False)), ["top", "floor"]),
        (
            lambda space: (
                space.add_lwpolyline(LEFT),
                space.add_lwpolyline(RIGHT),
                space.add_line((100, -9), (100, 599)),
            ),
            ["top", "floor"],
        ),
    ],
    ids=["open top", "open top of lines", "open outlet", "two walls", "two walls about an axis"],
)
def test_what_is_open_above_or_below_is_closed_with_a_word(drawn, draw, word):
    drawing = read_drawing(drawn(draw=draw))
    is_the_bin(drawing.silo)
    for name in word:
        assert f"Its open {name} was closed by a level line" in said(drawing)


def test_a_drawn_lid_goes_before_one_that_is_put_in(drawn):
    def draw(space):
        space.add_lwpolyline([(0, 520), *OPEN[1:-1], (200, 520)])
        space.add_line((-50, 500), (250, 500))

    is_the_bin(read_silo(drawn(draw=draw)))


def test_walls_of_unequal_height_are_not_closed(drawn):
    with pytest.raises(BadInput, match="draw what is missing"):
        read_silo(drawn(draw=lambda space: space.add_lwpolyline([(0, 480), *OPEN[1:]])))


@pytest.mark.parametrize(
    ("draw", "word"),
    [
        (lambda space: (as_lines(space, BIN), space.add_line((0, 200), (200, 200))), "stand on each other"),
        (lambda space: (closed(space, BIN[:3] + BIN[-1:]), closed(space, BIN[2:])), "stand on each other"),
        (
            lambda space: [closed(space, [(s * x, y) for x, y in [(0, 0), (40, 0), (100, 200), (100, 500), (0, 500)]])
                           for s in (1, -1)],
            "mirrored halves",
        ),
        (lambda space: (as_lines(space, BIN), space.add_line((100, -40), (100, 540))), "Open lines passed over (1)"),
        (
            lambda space: (as_lines(space, BIN), [space.add_line((k, 0), (k, 500)) for k in (-40, 240)]),
            "Open lines passed over (2)",
        ),
    ],
    ids=["transition line", "hopper below a bin", "halves", "centre line", "dimension lines"],
)  # fmt: skip
def test_parts_of_one_silo_make_one(drawn, draw, word):
    drawing = read_drawing(drawn(draw=draw))
    is_the_bin(drawing.silo)
    assert word in said(drawing)


def test_a_half_and_its_mirror_image_make_a_silo_without_corners_in_its_middle(drawn):
    def draw(space):
        half = space.doc.blocks.new("HALF")
        half.add_lwpolyline([(0, 0), (-40, 0), (-100, 200), (-100, 500), (0, 500)])
        for scale in (1, -1):
            space.add_blockref("HALF", (100, 0), dxfattribs={"xscale": scale})

    silo = read_silo(drawn(draw=draw))
    is_the_bin(silo)
    assert len(silo.outline_m) == 6
    silo = read_silo(drawn([*BIN[:1], (100, 0), *BIN[1:4], (100, 500), *BIN[4:]]))
    is_the_bin(silo)
    assert len(silo.outline_m) == 6


HALF = [(100, 0), (140, 0), (200, 200), (200, 500), (100, 500)]  # of BIN, right of its axis


def axis(space, low=-30, high=530, linetype="CENTER", layer="0"):
    if layer not in space.doc.layers:
        space.doc.layers.add(layer, linetype=linetype)
    space.add_line((100, low), (100, high), dxfattribs=on(layer))


@pytest.mark.parametrize(
    ("draw", "where"),
    [
        (lambda space: (closed(space, HALF), axis(space, layer="AXIS")), r"left .* on a centre line \(layer AXIS\)"),
        (lambda space: (space.add_lwpolyline(HALF), axis(space, 0, 500, "DASHDOT", "A")), r"left .* \(layer A\)"),
        (lambda space: (space.add_lwpolyline(HALF), axis(space, linetype="CONTINUOUS")), r"left .* \(layer 0\)"),
        (
            lambda space: (closed(space, [(200 - x, y) for x, y in HALF]), axis(space, layer="Mittellinie")),
            r"right .* \(layer Mittellinie\)",
        ),
        (lambda space: (closed(space, [(0, 0), (100, 0), (100, 500), (0, 500)]), axis(space, layer="CL")), r"right"),
        (lambda space: closed(space, HALF), r"left .* opposite an inclined one"),
    ],
    ids=["centre line", "closed by it", "beyond both ends", "left half", "flat bottom", "none"],
)
def test_a_half_beside_its_axis_is_taken_with_a_word_that_names_the_remedy(drawn, draw, where):
    drawing = read_drawing(drawn(draw=draw))
    assert drawing.silo.width_m == pytest.approx(0.1)
    (word,) = [word for word in drawing.words if "MIRROR" in word]
    assert re.match(rf"Its {where}.*taken for a wall.*whole silo.*as one closed line", word)


def two_walls(space, corners):
    for some in (corners[:1] + corners[:3:-1], corners[1:4]):
        space.add_lwpolyline(some)


@pytest.mark.parametrize("lines", [closed, as_lines, two_walls])
@pytest.mark.parametrize("ends", [(-30, 530), (0, 500)], ids=["beyond", "from floor to top"])
def test_a_whole_silo_with_a_centre_line_is_no_half(drawn, lines, ends):
    drawing = read_drawing(drawn(draw=lambda space: (lines(space, BIN), axis(space, *ends, layer="AXIS"))))
    is_the_bin(drawing.silo)
    assert "MIRROR" not in said(drawing)


def test_sides_a_hair_out_of_level_are_levelled(drawn):
    silo = read_silo(drawn([(60, 0.03), (140, 0), (200, 200), (199.99, 500), (0, 499.97), (0.01, 200)]))
    is_the_bin(silo, rel=1e-3)
    assert silo.feet_m[0] == pytest.approx(0.2)


def test_a_silo_that_is_wider_below_than_above_gets_a_word(drawn):
    drawing = read_drawing(drawn([(x, -y) for x, y in BIN]))
    assert drawing.silo.floor_m == pytest.approx((0.0, 0.2))
    assert "Its floor is wider than its top" in said(drawing)
    assert "upside down" in said(drawing)
    assert "upside down" not in said(read_drawing(drawn(BIN)))


# --- what is asked ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("title", [False, True])
def test_a_border_is_asked_about(drawn, title):
    def draw(space):
        closed(space, BORDER, "BORDER")
        closed(space, BIN, "BIN")
        if title:
            closed(space, [(300, -150), (500, -150), (500, -100), (300, -100)], "TITLE")

    file = drawn(draw=draw)
    with pytest.raises(Unclear, match=r"line 1 \(layer BORDER, 0.7 m x 0.85 m.*border.*--line 2 or --layer BIN"):
        read_silo(file)
    for choice in ({"line": 2}, {"layers": ["BIN"]}):
        is_the_bin(read_silo(file, **choice))


def test_a_border_on_the_silo_s_own_layer_is_asked_about(drawn):
    with pytest.raises(Unclear, match="border"):
        read_silo(drawn(BORDER, BIN))


def test_an_open_bin_in_a_border_is_asked_about(drawn):
    file = drawn(BORDER, draw=lambda space: space.add_lwpolyline(OPEN))
    with pytest.raises(Unclear, match="border"):
        read_silo(file)
    is_the_bin(read_silo(file, line=2))


@pytest.mark.parametrize("draw", [closed, as_lines])
def test_a_wall_of_two_lines_is_asked_about(drawn, draw):
    file = drawn(draw=lambda space: (draw(space, SHELL), draw(space, BIN)))
    with pytest.raises(Unclear, match=r"line 2 .* fills 86% of line 1 .*inner face of a wall.*--line 2.*--line 1"):
        read_silo(file)
    is_the_bin(read_silo(file, line=2))


def test_walls_of_two_lines_each_are_asked_about(drawn):
    inner, outer = OPEN, [(x + (10 if x > 100 else -10), y) for x, y in OPEN]
    walls = [side for one in (inner, outer) for side in (one[:3], one[3:])]
    file = drawn(draw=lambda space: [space.add_lwpolyline(wall) for wall in walls])
    with pytest.raises(Unclear, match=r"line 2 .* fills 90% of line 1 .*inner face of a wall.*--line 2"):
        read_silo(file)
    is_the_bin(read_silo(file, line=2))


def test_an_open_tank_of_two_lines_has_one_lid(drawn):
    def draw(space):
        space.add_lwpolyline([(0, 500), (0, 0), (200, 0), (200, 500)])
        space.add_lwpolyline([(-8, 500), (-8, -8), (208, -8), (208, 500)])

    drawing = read_drawing(drawn(draw=draw), line=2)
    assert drawing.silo.width_m == pytest.approx(0.2)
    assert said(drawing).count("Its open top was closed") == 1


def test_two_bins_are_asked_about(drawn):
    file = drawn(BIN, [(x + 400, y) for x, y in BUNKER])
    with pytest.raises(Unclear, match=r"lines 1 .*at 0, 0 m.*, 2 .*at 0.4, 0 m.* could each be the silo; .*--line"):
        read_silo(file)
    assert read_silo(file, line=2).height_m == pytest.approx(0.4)
    with pytest.raises(BadInput, match="line is 3; the drawing has 2"):
        read_silo(file, line=3)


def test_two_walls_of_steel_in_section_are_no_two_bins(drawn):
    wall = [(0, 500), (0, 200), (60, 0), (48, 0), (-12, 197), (-12, 500)]
    with pytest.raises(Unclear, match=r"could each be the silo; .* as one closed line if they are its two walls"):
        read_silo(drawn(wall, [(200 - x, y) for x, y in wall]))
    bins = [[(x + k, y) for x, y in BIN] for k in (0, 400)]
    with pytest.raises(Unclear, match="choose one by --line or --layer$"):
        read_silo(drawn(*bins))


def test_a_round_plan_view_is_passed_over_and_a_square_one_asked_about(drawn):
    drawing = read_drawing(drawn(BIN, draw=lambda space: space.add_circle((500, 250), 180)))
    is_the_bin(drawing.silo)
    assert "beside it passed over (1)" in said(drawing)
    with pytest.raises(Unclear, match="could each be the silo"):
        read_silo(drawn(BIN, [(400, 0), (600, 0), (600, 200), (400, 200)]))


def test_bolt_holes_are_passed_over_with_a_word(drawn):
    def draw(space):
        for k in range(60):
            space.add_circle((10 + 3 * k, 480), 1)

    drawing = read_drawing(drawn(BIN, draw=draw))
    is_the_bin(drawing.silo)
    assert not drawing.silo.inserts
    assert "smaller than 0.005 m passed over (60)" in said(drawing)


def test_a_body_that_crosses_the_wall_is_refused(drawn):
    with pytest.raises(BadInput, match="crosses the inside"):
        read_silo(drawn(BIN, draw=lambda space: space.add_circle((0, 300), 20)))


def test_a_hollow_body_is_its_outer_line(drawn):
    drawing = read_drawing(drawn(BIN, draw=lambda space: [space.add_circle((100, 300), r) for r in (20, 15)]))
    (body,) = drawing.silo.inserts
    assert body.breadth_m == pytest.approx(0.04, rel=0.01)
    assert "within bodies passed over (1)" in said(drawing)


def test_what_is_no_drawing_of_a_silo_is_refused(drawn, tmp_path):
    with pytest.raises(BadInput, match="no closed line"):
        read_silo(drawn())
    with pytest.raises(BadInput, match="mm, cm"):
        read_silo(drawn(BUNKER, units=0))
    (tmp_path / "no.dxf").write_text("nothing", encoding="utf-8")
    for file in ("no.dxf", "none.dxf"):
        with pytest.raises(BadInput, match="cannot be read"):
            read_silo(tmp_path / file)
    with pytest.raises(ValueError, match="turns down"):
        read_silo(drawn([(0, 0), (100, 0), (100, 300), (200, 200), (200, 500), (0, 500)]))


# --- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("damage", [
    lambda data: data[:-2000],
    lambda data: data.replace(b"  0\nENDSEC\n  0\nSECTION\n  2\nOBJECTS", b"  0\nSECTION\n  2\nOBJECTS"),
])  # fmt: skip
def test_a_damaged_file_is_read_at_the_second_try_with_a_word(drawn, damage):
    file = drawn(BIN)
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert file.read_bytes() != whole
    drawing = read_drawing(file)
    is_the_bin(drawing.silo)
    assert "damaged" in said(drawing)


def test_a_dwg_file_is_named(tmp_path):
    (tmp_path / "silo.dxf").write_bytes(b"AC1027" + bytes(100))
    with pytest.raises(BadInput, match="it is a DWG file; save it as DXF"):
        read_silo(tmp_path / "silo.dxf")


def test_names_may_be_in_any_script(drawn, tmp_path, monkeypatch, capsys):
    name = "Trichter Süd 筒仓"
    file = drawn(draw=lambda space: closed(space, BIN, "Wand – 筒仓"), name=f"{name}.dxf")
    scene = tmp_path / f"{name}.toml"
    assert "Wand – 筒仓" in command(monkeypatch, capsys, file, "--output", scene)[1]
    assert "Wand – 筒仓" in scene.read_text(encoding="utf-8")
    is_the_bin(read_scene(scene).silo)


# --- the grid ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stretch", "outlet", "cell"),
    [
        ((1, 1), 80, 0.005),
        ((1, 1), 30, 0.0025),
        ((1, 1), 10, 0.001),
        ((25.4, 25.4), 80, 0.127),
        ((1.01585, 1.0226), 80, None),
    ],
)
def test_cells_divide_the_silo_and_ten_or_more_cross_the_outlet(drawn, stretch, outlet, cell):
    corners = [(100 - outlet / 2, 0), (100 + outlet / 2, 0), *BIN[2:]]
    drawing = read_drawing(drawn([(x * stretch[0], y * stretch[1]) for x, y in corners]))
    scene = scene_of(drawing.tables())  # its own checks: they divide
    left, right = scene.silo.outlet_m
    assert (right - left) / drawing.cell_size_m >= 10 - 1e-6
    assert scene.silo.width_m / drawing.cell_size_m >= 40 - 1e-6
    assert cell is None or drawing.cell_size_m == pytest.approx(cell, rel=0.35)
    assert abs(scene.silo.height_m - 0.5 * stretch[1]) < drawing.cell_size_m
    assert "across the narrowest opening" in said(drawing)


def test_an_opening_too_narrow_for_ten_cells_is_named(drawn):
    drawing = read_drawing(drawn([(99.9, 0), (100.1, 0), *BIN[2:]]))
    assert drawing.silo.points(drawing.cell_size_m) < 1.1e6
    assert "fewer than the ten that it should have" in said(drawing)


# --- the command ------------------------------------------------------------------------------------------------------


def command(monkeypatch, capsys, *words):
    """Exit code, what it says on stdout, and on stderr."""
    monkeypatch.setattr(sys, "argv", ["taichi-silo", "drawing", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        app.main()
    return ended.value.code or 0, *capsys.readouterr()


def test_the_command_writes_a_scene_that_runs_says_what_it_took_and_draws_it(drawn, tmp_path, monkeypatch, capsys):
    scene = tmp_path / "bin.toml"
    code, out, _ = command(monkeypatch, capsys, drawn(BIN), "--output", scene)
    assert code == 0
    assert "0.2 m wide, 0.5 m high, floor from x = 0.06 to 0.14 m, 0 bodies; unit mm" in out
    assert "Cells of 5 mm: 40 across, 16 across" in out
    text = scene.read_text(encoding="utf-8")
    assert text.startswith("# From the drawing silo.dxf.\n# Taken: closed line 1 of 1, layer 0: 0.2 m wide")
    assert tomllib.loads(text)["grid"] == {"cell_size_m": 0.005}
    is_the_bin(read_scene(scene).silo)
    assert (tmp_path / "bin.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_that_is_there_is_left_alone(drawn, tmp_path, monkeypatch, capsys):
    (tmp_path / "bin.png").write_text("mine", encoding="utf-8")
    code, out, _ = command(monkeypatch, capsys, drawn(BIN), "--output", tmp_path / "bin.toml")
    assert code == 0
    assert "The picture" not in out
    assert (tmp_path / "bin.png").read_text(encoding="utf-8") == "mine"
    for show, word in (("bin.png", "there already"), ("bin.pdf", "FILE.png"), ("no/bin.png", "no folder")):
        code, _, err = command(
            monkeypatch, capsys, drawn(BIN), "--output", tmp_path / "b.toml", "--show", tmp_path / show
        )
        assert code == 2
        assert word in err
    assert not (tmp_path / "b.toml").exists()


def test_what_is_printed_is_a_scene_file_and_what_was_taken_is_said_beside_it(drawn, monkeypatch, capsys):
    code, out, err = command(monkeypatch, capsys, drawn(BIN))
    assert code == 0
    assert set(tomllib.loads(out)) == {"silo", "grid"}
    assert "Taken: closed line 1 of 1" in err


def test_a_question_comes_with_a_picture_of_the_numbers_if_one_is_asked_for(drawn, tmp_path, monkeypatch, capsys):
    picture = tmp_path / "lines.png"
    file = drawn(SHELL, BIN)
    code, _, err = command(monkeypatch, capsys, file, "--show", picture, "--output", tmp_path / "bin.toml")
    assert code == 2
    assert err.count("\n") == 1
    assert f"{picture.name} shows them" in err
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / "bin.toml").exists()
    code, _, _ = command(monkeypatch, capsys, file, "--line", 2, "--layer", "0", "--gap", 0.001, "--unit", "mm")
    assert code == 0


def test_the_picture_shows_every_closed_line_with_its_number():
    from taichi_silo.show.figures.drawing import lines_figure

    figure = lines_figure([np.array(SHELL, float), np.array(BIN, float)], 2, ())
    (panel,) = figure.axes
    assert [one.get_text() for one in panel.texts] == ["1", "2"]
    assert panel.get_aspect() == 1.0
    assert len(panel.patches) == 1  # the sand

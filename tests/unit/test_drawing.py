"""Silos from DXF drawings."""

import math

import ezdxf
import pytest

from taichi_silo.errors import BadInput
from taichi_silo.scene.dxf import read_silo
from taichi_silo.scene.silo import Silo

BUNKER = [(60, 0), (120, 0), (160, 140), (200, 140), (200, 400), (0, 400), (0, 200)]


@pytest.fixture
def drawn(tmp_path):
    def of(*closed, units=4, shift=(0, 0), draw=None):
        document = ezdxf.new(units=units)
        space = document.modelspace()
        for corners in closed:
            space.add_lwpolyline([(x + shift[0], y + shift[1]) for x, y in corners], close=True)
        if draw:
            draw(space)
        file = tmp_path / "silo.dxf"
        document.saveas(file)
        return file

    return of


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

    silo = read_silo(drawn(BUNKER, draw=draw))
    (body,) = silo.inserts
    assert body.kind == "polygon"
    assert body.area_m2() == pytest.approx(math.pi * 0.02**2, rel=0.05)


@pytest.mark.parametrize(("units", "unit", "scale"), [(6, None, 1.0), (4, "m", 1.0), (0, "cm", 0.01)])
def test_the_unit_is_that_of_the_drawing_unless_it_is_given(drawn, units, unit, scale):
    silo = read_silo(drawn([(0, 0), (2, 0), (2, 5), (0, 5)], units=units), unit)
    assert (silo.width_m, silo.height_m) == pytest.approx((2 * scale, 5 * scale))


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

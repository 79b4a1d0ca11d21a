"""A drawing of a silo with its dimensions, as SVG that takes its colours from the page."""

import math
from html import escape
from itertools import pairwise

import numpy as np

from taichi_silo.runs.result import Result
from taichi_silo.scene import fill_shape, polygons
from taichi_silo.scene.closed_parts import closed_parts
from taichi_silo.scene.silo import Silo
from taichi_silo.show.report.words import mm

TALL, WIDE = 360.0, 200.0  # px that the sand may take
SIDE, TOP, FOOT = 84.0, 44.0, 92.0  # px around it
FREEBOARD = 0.05  # of the height: how far walls reach above the sand
ARROW = 7.0


class Sheet:
    """A drawing in SVG of shapes given in metres from the silo's left wall and floor, y upwards."""

    def __init__(self, silo: Silo):
        self.scale = min(TALL / silo.height_m, WIDE / silo.width_m)
        self.height = silo.height_m
        self.size = (silo.width_m * self.scale + 2.0 * SIDE, silo.height_m * self.scale + TOP + FOOT)
        self.parts: list[str] = []

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Pixels of a place."""
        return SIDE + x * self.scale, TOP + (self.height - y) * self.scale

    def shape(self, outline, kind: str) -> None:
        """A filled outline (n, 2) [m]."""
        points = " ".join("{:.1f},{:.1f}".format(*self.at(x, y)) for x, y in outline)
        self.parts.append(f'<polygon class="{kind}" points="{points}"/>')

    def line(self, start, end, kind: str) -> None:
        """Between two places [px]."""
        ends = 'x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}"'.format(*start, *end)
        self.parts.append(f'<line class="{kind}" {ends}/>')

    def words(self, x: float, y: float, text: str, anchor: str = "middle", turn: float = 0.0) -> None:
        """Text at a place [px]."""
        turned = f' transform="rotate({turn:g} {x:.1f} {y:.1f})"' if turn else ""
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{turned}>{escape(text)}</text>')

    def arrow(self, start, end, kind: str = "dimension") -> None:
        """A line with a head at its end [px]."""
        self.line(start, end, kind)
        along = np.subtract(end, start) / max(math.dist(start, end), 1e-9)
        across = np.array([-along[1], along[0]])
        corners = [end, end - ARROW * along + 0.4 * ARROW * across, end - ARROW * along - 0.4 * ARROW * across]
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in corners)
        self.parts.append(f'<polygon class="head {kind}" points="{points}"/>')

    def dimension(self, start, end, text: str) -> None:
        """A dimension line with arrows at both ends [px] and its text beside it."""
        middle = np.add(start, end) / 2.0
        if math.dist(start, end) > 3.0 * ARROW:
            self.arrow(middle, start)
            self.arrow(middle, end)
        else:
            self.line(start, end, "dimension")
        if abs(start[0] - end[0]) < abs(start[1] - end[1]):
            self.words(middle[0] - 7.0, middle[1], text, turn=-90.0)
        else:
            self.words(middle[0], middle[1] - 7.0, text)

    def svg(self, title: str) -> str:
        """The drawing as an SVG element with this title."""
        wide, high = self.size
        head = f'<svg class="silo" viewBox="0 0 {wide:.0f} {high:.0f}" role="img" aria-label="{escape(title)}">'
        return "\n".join([head, f"<title>{escape(title)}</title>", *self.parts, "</svg>"])


def drawing(run: Result) -> str:
    """SVG of a run's silo: walls, sand, outlet, solids, and what is done to it."""
    silo = run.scene.silo
    sheet = Sheet(silo)
    wide, high = silo.width_m, silo.height_m
    left, right = ([*side[side[:, 1] < high], (polygons.place(side, high), high)] for side in silo.sides)
    filled = silo.body.intersection(fill_shape.region(silo))
    sheet.shape(filled.exterior.coords[:-1], "sand")
    for solid in silo.solids():
        sheet.shape(solid, "solid")
    top = high * (1.0 + FREEBOARD)
    for side in (left, right):
        for start, end in pairwise([*side, (side[-1][0], top)]):
            sheet.line(sheet.at(*start), sheet.at(*end), "wall")
    if silo.section == "round":
        sheet.line(sheet.at(0.5 * wide, top), sheet.at(0.5 * wide, -0.03 * high), "axis")
    _floor(sheet, run)
    for x, free in zip(fill_shape.sides_m(silo), fill_shape.free_walls(silo), strict=True):
        if free:
            sheet.line(sheet.at(x, 0.0), sheet.at(x, top), "gate")
    _dimensions(sheet, silo)
    return sheet.svg(f"Section of the silo, {mm(wide)} wide and filled {mm(high)} high")


def _floor(sheet: Sheet, run: Result) -> None:
    """Floor, gate, and an arrow where the sand leaves."""
    silo = run.scene.silo
    for begin, end in closed_parts(silo, "floor"):
        sheet.line(sheet.at(begin, 0.0), sheet.at(end, 0.0), "wall")
    if silo.column_m is not None:
        sheet.words(0.5 * sheet.size[0], sheet.size[1] - 10.0, "walls of the column taken away")
        return
    for one in silo.openings:
        edge, other = (sheet.at(*place) for place in one.ends)
        sheet.line(edge, other, "gate")
        x, y = 0.5 * (edge[0] + other[0]), 0.5 * (edge[1] + other[1])
        right, up = one.outwards
        sheet.arrow((x + 8.0 * right, y - 8.0 * up), (x + 30.0 * right, y - 30.0 * up), "flow")
    x, y = sheet.at(0.5 * sum(silo.outlet_m), 0.0)
    speed, depth = run.scene.flow.speed_m_per_s, run.scene.flow.displacement_m
    if run.free:
        said = "opened, sand falls out"
    else:
        said = f"{'bottom' if silo.floor_is_outlet else 'gate'}: {mm(depth)} at {1e3 * speed:g} mm/s"
    half = 3.6 * len(said)  # of the text, about
    sheet.words(min(max(x, half), sheet.size[0] - half), sheet.size[1] - 10.0, said)


def _dimensions(sheet: Sheet, silo: Silo) -> None:
    wide, high = silo.width_m, silo.height_m
    top = sheet.at(0.0, high * (1.0 + FREEBOARD))[1] - 9.0
    (x0, y0), (x1, _) = sheet.at(0.0, 0.0), sheet.at(wide, 0.0)
    sheet.dimension((x0, top), (x1, top), f"{'⌀ ' if silo.section == 'round' else ''}{mm(wide)}")
    sheet.dimension((x0 - 26.0, sheet.at(0.0, high)[1]), (x0 - 26.0, y0), mm(high))
    if silo.has_opening:
        for one in silo.openings:
            if one.in_floor:
                left, right = (sheet.at(x, 0.0)[0] for x in (one.low, one.high))
                sheet.dimension((left, y0 + 52.0), (right, y0 + 52.0), mm(one.width))
            else:
                x = sheet.at(one.at_m, 0.0)[0] + 12.0 * one.outwards[0]
                sheet.dimension((x, sheet.at(0.0, one.high)[1]), (x, sheet.at(0.0, one.low)[1]), mm(one.width))
    level = sheet.at(0.0, silo.transition_m)[1]
    if silo.transition_m:
        sheet.dimension((x1 + 32.0, level), (x1 + 32.0, y0), mm(silo.transition_m))
    if silo.hopper is not None:
        sheet.words(x1 + 8.0, level - 24.0, f"{silo.hopper.half_angle_deg:g}° from", "start")
        sheet.words(x1 + 8.0, level - 9.0, "the vertical", "start")
    for insert in silo.inserts:
        bottom = float(insert.outline(wide)[:, 1].min())
        x, y = sheet.at(insert.centre_m(wide), bottom)
        sheet.words(x, y + 15.0, mm(insert.breadth_m))
        place = x1 + (60.0 if silo.transition_m else 32.0)  # beside that of the hopper
        sheet.dimension((place, y), (place, y0), mm(bottom))

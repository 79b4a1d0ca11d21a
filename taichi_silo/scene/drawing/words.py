"""What is said of a drawing: what was taken, what was passed over, and why there is nothing to take."""

from typing import Any

import numpy as np

from taichi_silo.scene import polygons
from taichi_silo.scene.drawing import choice, entities, joining
from taichi_silo.scene.silo import Silo
from taichi_silo.utils.messages import shown


def of_rest(found: entities.Found, unused: int, axes: tuple[int, int], mended: bool) -> list[str]:
    """What else there is to know."""
    said = [f"open lines passed over ({unused})"] if unused else []
    if found.hidden:
        names = shown(", ".join(sorted(found.hidden)), 120)
        said.append(f"layers that are off, frozen or not printed passed over: {names}")
    if found.invisible:
        said.append(f"invisible lines passed over ({found.invisible})")
    if found.elsewhere:
        said.append(f"blocks whose lines are in other files passed over: {shown(', '.join(found.elsewhere), 120)}")
    if axes != (0, 1):
        said.append(
            f"the drawing stands upright in space: its side view is the plane of {' and '.join('xyz'[k] for k in axes)}"
        )
    if mended:
        said.append("the drawing's file is damaged: what could be read was taken")
    return said


def of_open(joined: joining.Joined) -> str:
    """What keeps lines from being closed."""
    if joined.gap is None:
        return "the silo's inside must be one, or lines that meet"
    apart, x, y = joined.gap
    return (
        f"its lines end apart ({len(joined.unused)}), the nearest ends {apart:.4g} m from each other at x = {x:.4g}, "
        f"y = {y:.4g} m; draw what is missing"
        + (f", or join them with --gap {1.01 * apart:.3g}" if apart < 0.05 * joined.extent_m else "")
    )


def of_none(drawing: Any, found: entities.Found) -> str:
    """Where the lines are, if not in sight in the model space."""
    papers = [layout.name for layout in drawing.layouts if layout.name != "Model" and _holds_lines(layout)]
    if found.hidden:
        names = sorted(found.hidden)
        return (
            f"its lines are on layers that are off, frozen or not printed; --layer {shown(names[0])} takes one anyway"
        )
    if papers:
        return (
            f"its lines are in the paper space ({shown(', '.join(papers), 100)}); move them to the model space (in "
            "CAD: CHSPACE), where a silo is drawn in its size"
        )
    if found.invisible:
        return "its lines are invisible; show them (in CAD: UNISOLATEOBJECTS)"
    if found.elsewhere:
        return (
            f"its lines are in other files, as block {shown(', '.join(found.elsewhere), 100)}; bind them to this one "
            "(in CAD: XREF, Bind)"
        )
    if found.others:
        kinds = ", ".join(f"{count} {kind}" for kind, count in found.others.most_common(5))
        return f"it holds {shown(kinds, 120)}; draw the inside as a closed line"
    return "it is empty"


def _holds_lines(layout: Any) -> bool:
    return any(entity.dxftype() in (*entities.KINDS, *entities.CONTAINERS) for entity in layout)


def of_upside_down(outline: np.ndarray) -> list[str]:
    """A sentence on a silo (n, 2) that is wider below than above; none on another one."""
    left, right = polygons.sides(tuple((x, y) for x, y in outline.tolist()))
    floor, top = (right[k, 0] - left[k, 0] for k in (0, -1))
    if top >= 0.99 * floor:
        return []
    return [f"its floor is wider than its top, {floor:.4g} m against {top:.4g} m: turn it if it is drawn upside down"]


def of_taken(taken: choice.Chosen, count: int, silo: Silo, unit: str, known: str) -> str:
    """What was taken."""
    left, right = silo.floor_m
    wide, high = silo.width_m, silo.height_m
    bodies = f"{len(taken.bodies)} bodies" if len(taken.bodies) != 1 else "1 body"
    return (
        f"Taken: closed line {taken.number} of {count}, layer {shown(taken.inside.layer)}: {wide:.6g} m wide, "
        f"{high:.6g} m high, floor from x = {left:.6g} to {right:.6g} m, {bodies}; unit {unit}, {known}"
    )

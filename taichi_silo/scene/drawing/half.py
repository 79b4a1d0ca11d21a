"""A drawing of one half of a silo beside its axis, whose straight side would be taken for a wall."""

from collections.abc import Iterable

import numpy as np

from taichi_silo.scene import polygons
from taichi_silo.scene.drawing.joining import Piece
from taichi_silo.utils.messages import shown

OVER = 0.01  # of a silo's height: a straight line that reaches so far beyond floor and top is an axis
ALONG = 0.5  # of the same: least length of an axis beside it


def words_of(outline: np.ndarray, place: np.ndarray, pieces: Iterable[Piece], level_m: float) -> list[str]:
    """What is to be said of a silo of which only one half may be drawn: a sentence, or none if nothing hints at that.

    A half has one side that is a vertical line from floor to top. A centre line stands on it, or the other side is
    inclined.

    Parameters
    ----------
    outline : corners (n, 2) of the silo, the leftmost and the lowest place at 0 [m].
    place : its leftmost and lowest place (2,) in the drawing [m].
    pieces : lines of the drawing.
    level_m : tolerance of places.

    """
    left, right = polygons.sides(tuple((x, y) for x, y in outline.tolist()))
    wide, high = outline.max(axis=0).tolist()
    upright = {name: np.ptp(side[:, 0]) <= polygons.SAME for name, side in (("left", left), ("right", right))}
    for name, x in (("left", 0.0), ("right", wide)):
        on = [piece.layer for piece in pieces if _axis(piece, place + (x, 0.0), high, level_m)]
        if upright[name] and on:
            return [_sentence(name, f"on a centre line (layer {shown(on[0], 30)})")]
    if upright["left"] != upright["right"]:
        return [_sentence("left" if upright["left"] else "right", "opposite an inclined one")]
    return []


def _axis(piece: Piece, foot: np.ndarray, high: float, level_m: float) -> bool:
    """Whether a line may be the axis of a silo so high, with its foot there.

    It stands along most of the silo, and is drawn as a centre line or reaches beyond floor and top.
    """
    x, y = (piece.corners - foot).T
    beyond = y.min() < -OVER * high and y.max() > (1.0 + OVER) * high
    along = min(y.max(), high) - max(y.min(), 0.0) >= ALONG * high
    return bool((np.abs(x) <= level_m).all() and along and (piece.centre or beyond))


def _sentence(side: str, where: str) -> str:
    return (
        f"its {side} side is one vertical line from floor to top, {where}: it was taken for a wall, and what is drawn "
        "for the whole silo; where it is the axis and only one half is drawn, add the other half (in CAD: MIRROR) and "
        "draw both as one closed line"
    )

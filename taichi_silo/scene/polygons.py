"""Polygons: the outline of a silo's inside, and that of a body in the sand."""

import numpy as np
import shapely
from numpy.typing import ArrayLike

Corners = tuple[tuple[float, float], ...]
MOST_CORNERS = 1000
LARGEST = 1000.0  # of a coordinate [m]
SAME = 1e-9  # places closer than that are one [m]


def polygon(corners: Corners, name: str) -> np.ndarray:
    """Corners (n, 2) anticlockwise [m], the last not again the first.

    Raises ValueError if they are fewer than three, enclose nothing, or the sides cross.
    """
    given = np.array(corners, float).reshape(-1, 2)
    if not (np.abs(given) <= LARGEST).all():
        worst = given.flat[np.argmax(np.where(np.isnan(given), np.inf, np.abs(given)))]
        raise ValueError(f"the {name} has a corner at {worst:g} m; it must be between -{LARGEST:g} and {LARGEST:g} m")
    apart = without_repeats(given)
    if len(apart) < 3:
        raise ValueError(f"the {name} has {len(apart)} corners; a polygon has at least 3")
    shape = shapely.Polygon(apart)
    if shapely.MultiPoint(apart).convex_hull.area < SAME:
        raise ValueError(f"the corners of the {name} lie on one line; a polygon must enclose an area")
    if not shape.is_valid:
        _, _, place = shapely.is_valid_reason(shape).partition("[")
        at = f" at ({', '.join(f'{float(one):.4g}' for one in place.rstrip(']').split())}) m" if place else ""
        raise ValueError(
            f"sides of the {name} touch or cross each other{at}; its corners must go around it once, in order"
        )
    return np.array(shapely.geometry.polygon.orient(shape).exterior.coords[:-1])


def without_repeats(corners: np.ndarray) -> np.ndarray:
    """Corners (n, 2) without those that repeat the one before; the last does not repeat the first."""
    return corners[np.abs(corners - np.roll(corners, 1, axis=0)).max(axis=1) > SAME] if len(corners) else corners


def without_straight(corners: np.ndarray) -> np.ndarray:
    """Corners (n, 2) of a closed line without those on the straight line between their neighbours."""
    while len(corners) > 3:
        before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
        across = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
        turns = (across > SAME * np.hypot(*(before + after).T)) | ((before * after).sum(axis=1) <= 0.0)
        if turns.all():
            break
        first = int(np.argmin(turns))  # one after the other: what is left decides on its neighbours
        corners = np.delete(corners, first, axis=0)
    return corners


def inside(x: ArrayLike, y: ArrayLike, corners: np.ndarray) -> np.ndarray:
    """Whether points x, y (arrays) [m] lie inside a polygon."""
    return shapely.contains_xy(shapely.Polygon(corners), np.asarray(x, float), np.asarray(y, float))


def area(corners: np.ndarray) -> float:
    """Area of a polygon [m2]."""
    return float(shapely.Polygon(corners).area)


def sides(corners: Corners) -> tuple[np.ndarray, np.ndarray]:
    """Left and right side of a silo's inside, each (n, 2) from the floor up to the top.

    Corners on the straight line between their neighbours are left out.

    Raises ValueError if it has no level floor at y = 0 or no level top, does not begin at x = 0, or a level line would
    cross it more than twice.
    """
    found = without_straight(polygon(corners, "outline"))
    low, high, left = found[:, 1].min(), found[:, 1].max(), found[:, 0].min()
    if abs(low) > SAME or abs(left) > SAME:
        raise ValueError(
            f"the outline's least x and y are {left:g} and {low:g} m; both must be 0: x counts from its leftmost "
            "place, y from the floor or the outlet"
        )
    for name, level in (("floor", low), ("top", high)):
        if (np.abs(found[:, 1] - level) < SAME).sum() != 2:
            raise ValueError(
                f"the outline has no level {name} at y = {level:g} m; two corners must be there: cut what is pointed, "
                "round or leaning off level, however narrow"
            )
    start = int(np.lexsort((-found[:, 0], np.round(found[:, 1] / SAME)))[0])  # right end of the floor
    turned = np.roll(found, -start, axis=0)  # anticlockwise: right side up, top, left side down
    top = int(np.argmax(np.round(turned[:, 1] / SAME)))  # the first corner of the top
    chains = turned[: top + 1], turned[top + 1 :][::-1]
    for name, chain in zip(("right", "left"), chains, strict=True):
        if (np.diff(chain[:, 1]) < -SAME).any():
            raise ValueError(f"the outline's {name} side turns down on its way up; a level line may cross it only once")
    right, left = chains
    return left, right


def foot(chain: np.ndarray, wall_m: float) -> float:
    """Height [m] above which a side follows the vertical line x = `wall_m`; its top if it never does."""
    if abs(chain[-1, 0] - wall_m) < SAME and abs(chain[-2, 0] - wall_m) < SAME:
        return float(chain[-2, 1])
    return float(chain[-1, 1])


def place(chain: np.ndarray, y: ArrayLike) -> np.ndarray:
    """X of a side at heights y (array) [m]; above and below its ends that of the end."""
    y = np.asarray(y, float)
    nudge = np.arange(len(chain)) * 1e-12  # a level part is passed at once
    return np.interp(y, chain[:, 1] + nudge, chain[:, 0])

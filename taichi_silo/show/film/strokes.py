"""Smooth lines and discs on an image."""

import numpy as np


def stroke(shape: tuple[int, int], start: np.ndarray, end: np.ndarray, half_width: float):
    """Return the window (two slices) of an image and a round-ended line's smooth coverage (0 to 1) in it.

    `shape` is (rows, columns); `start` and `end` are (x, y) in pixels. Equal ends give a disc.
    """
    low = np.floor(np.minimum(start, end) - half_width - 1).astype(int)
    high = np.ceil(np.maximum(start, end) + half_width + 2).astype(int)
    (x0, y0), (x1, y1) = np.clip(low, 0, shape[::-1]), np.clip(high, 0, shape[::-1])
    y, x = np.ogrid[y0:y1, x0:x1]
    along = end - start
    share = ((x - start[0]) * along[0] + (y - start[1]) * along[1]) / max(along @ along, 1e-12)
    share = np.clip(share, 0.0, 1.0)
    distance = np.hypot(x - start[0] - share * along[0], y - start[1] - share * along[1])
    return (slice(y0, y1), slice(x0, x1)), np.clip(half_width + 0.5 - distance, 0.0, 1.0).astype(np.float32)


def blend(image: np.ndarray, coverage: np.ndarray, colour: tuple[int, int, int]) -> None:
    """Lay `colour` over `image` (rows, columns, 3) of bytes, weighted by `coverage` (rows, columns)."""
    weight = coverage[..., None]
    image[...] = np.rint(image * (1 - weight) + weight * np.asarray(colour, np.float32)).astype(np.uint8)

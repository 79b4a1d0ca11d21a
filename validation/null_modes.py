"""Which patterns of point stress no node feels, for each shape and number of points a cell.

On an endless lattice of points every pattern is a sum of waves: one stress for each point of a cell, times
exp(i (k_x column + k_y row)). The nodes feel of a wave f = B(k) sigma, two forces for the 3 n stresses of n points in a
cell, so that at least 3 n - 2 patterns a wave are not felt. One of them is the continuum's own, a stress in equilibrium
with itself (Airy's function); all others exist on the lattice only. With one point a cell there is none of these but
where B loses its rank, at the edge of the range of wave numbers.

Leaves `null_modes.csv` (how many patterns a wave are not felt, and what one turn of the filter leaves of the worst that
is the lattice's own) and `null_modes.png` (some of them, drawn).
"""

import functools
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib import rc_context
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.patch_passes import PASSES
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.show.figures.style import STYLE, new_figure

WAVES = {"0": 0.0, "pi/2": 0.5 * np.pi, "pi": np.pi}  # wave number along an axis, per cell
PHASES = {"middle of the cells": 0.0, "on the nodes": 0.5}  # where the lattice of points lies, in cells
UNFELT = 1e-9  # of the largest force of a pattern of that size
CELLS = 6  # cells along the edge of a drawing
NAMES = ("xx", "yy", "xy")


@ti.data_oriented
class Weights:
    """Weights and slopes of a shape at places along both axes, as its own kernel computes them."""

    def __init__(self, shape):
        n = shape.NODES
        self.shape = shape
        self.first = ti.Vector.field(2, ti.f64, shape=shape.PATCHES)
        self.found = ti.Vector.field(n, ti.f64, shape=(shape.PATCHES, 4))

    @ti.kernel
    def _compute(self, x: ti.f64, y: ti.f64, size: ti.f64):
        for patch in ti.static(range(self.shape.PATCHES)):
            i, sx, gx, j, sy, gy = self.shape.patch(patch, x, y, (size, 0.0, 0.0, size))
            self.first[patch] = ti.Vector([i, j])
            for number, values in ti.static(enumerate((sx, gx, sy, gy))):
                for a in ti.static(range(self.shape.NODES)):
                    self.found[patch, number][a] = values[a]

    def at(self, x: float, y: float, size: float) -> dict[tuple[int, int], np.ndarray]:
        """Weight and both slopes [per cell] of each node that a point at (x, y), as wide as `size`, touches [cells]."""
        self._compute(x, y, size)
        nodes: dict[tuple[int, int], np.ndarray] = {}
        for patch in range(self.shape.PATCHES):
            i, j = (int(value) for value in self.first[patch])
            sx, gx, sy, gy = (np.array(self.found[patch, number]) for number in range(4))
            for b in range(self.shape.NODES):
                for a in range(self.shape.NODES):
                    one = np.array([sx[a] * sy[b], gx[a] * sy[b], sx[a] * gy[b]])
                    nodes[i + a, j + b] = nodes.get((i + a, j + b), 0.0) + one
        return nodes


@functools.cache
def weights_of(name: str, half_size: float) -> Weights:
    """Of a shape by its name."""
    return Weights(SHAPES[name](half_size))


def places(per_axis: int, phase: float) -> np.ndarray:
    """Places (n, 2) of the points of one cell [cells]."""
    along = (np.arange(per_axis) + 0.5) / per_axis + phase
    x, y = np.meshgrid(along, along)
    return np.stack([x.ravel(), y.ravel()], axis=1)


def symbols(weights: Weights, per_axis: int, phase: float, k: tuple[float, float]) -> np.ndarray:
    """B(k), (2, 3 n): force on the node of cell (0, 0) from (xx, yy, xy) of each point of a cell of unit volume."""
    found = np.zeros((2, 3 * per_axis**2), dtype=complex)
    for number, (x, y) in enumerate(places(per_axis, phase)):
        for (i, j), (_weight, along_x, along_y) in weights.at(x, y, 1.0 / per_axis).items():
            # the point that touches node (0, 0) as this one touches (i, j) lies (-i, -j) cells away
            wave = np.exp(-1j * (k[0] * i + k[1] * j)) / per_axis**2
            found[0, 3 * number] += wave * along_x
            found[1, 3 * number + 1] += wave * along_y
            found[0, 3 * number + 2] += wave * along_y
            found[1, 3 * number + 2] += wave * along_x
    return found


def kept_by_filter(weights: Weights, per_axis: int, phase: float, k: tuple[float, float]) -> np.ndarray:
    """1 - (1 - P)^PASSES, (n, n): what a turn of the patch filter keeps of the n values of a wave."""
    count = per_axis**2
    to_nodes = np.zeros(count, dtype=complex)
    for number, (x, y) in enumerate(places(per_axis, phase)):
        for (i, j), (weight, *_slopes) in weights.at(x, y, 1.0).items():
            to_nodes[number] += weight * np.exp(-1j * (k[0] * i + k[1] * j)) / count
    rest = np.eye(count) - count * np.outer(to_nodes.conj(), to_nodes)
    return np.eye(count) - np.linalg.matrix_power(rest, PASSES)


def analyse(name: str, per_axis: int, phase: float, k: tuple[float, float]) -> tuple[int, np.ndarray, np.ndarray]:
    """Number of unfelt patterns of a wave, what the filter keeps of each, and the patterns (m, n, 3)."""
    B = symbols(weights_of(name, 0.5 / per_axis), per_axis, phase, k)
    _u, size, rows = np.linalg.svd(B)
    felt = int((size > UNFELT * per_axis**-2).sum())
    unfelt = rows[felt:].conj()
    keeps = kept_by_filter(weights_of("ugimp", 0.5), per_axis, phase, k)
    patterns = unfelt.reshape(len(unfelt), per_axis**2, 3)
    # within the unfelt patterns: the matrix of the filter, and its spectrum
    kept = np.einsum("anc,nm,bmc->ab", patterns.conj(), keeps, patterns)
    values, vectors = np.linalg.eigh(0.5 * (kept + kept.conj().T))
    return len(unfelt), values, np.einsum("ab,anc->bnc", vectors, patterns)


def null_modes(
    output: Annotated[Path, Option(help="folder, for null_modes.csv and null_modes.png")] = Path("outputs/null_modes"),
):
    """Count and draw the patterns of stress that no node feels."""
    runtime.init()
    output.mkdir(parents=True, exist_ok=True)
    rows, drawn = [], []
    for name in ("ugimp", "cpgimp", "cpdi", "bspline", "linear"):
        for per_axis in (1, 2, 3):
            for where, phase in PHASES.items():
                for kx, ky in (("0", "pi"), ("pi", "pi"), ("pi/2", "pi"), ("pi/2", "pi/2")):
                    count, kept, patterns = analyse(name, per_axis, phase, (WAVES[kx], WAVES[ky]))
                    # the continuum's own pattern is the smoothest: the filter keeps most of it
                    own = kept[:-1] if len(kept) > 1 else kept
                    rows.append((name, per_axis**2, where, kx, ky, count, kept[-1], own[-1]))
                    if name == "ugimp" and per_axis < 3 and phase == 0.0 and (kx, ky) != ("pi/2", "pi/2"):
                        drawn.append((per_axis, (kx, ky), patterns[0]))
    columns = ["shape", "points", "lattice", "k_x_h", "k_y_h", "unfelt", "kept_of_smoothest", "kept_of_the_others"]
    table = pd.DataFrame(rows, columns=columns)
    table.to_csv(output / "null_modes.csv", index=False, float_format="%.4g")
    print(table.to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    draw(drawn).savefig(output / "null_modes.png")


def draw(drawn: list) -> object:
    """Real parts of some patterns, a row each: xx, yy, xy of each point as a coloured square."""
    with rc_context(STYLE):
        figure = new_figure(7.5, 2.3 * len(drawn))
        panels = figure.subplots(len(drawn), 3, sharex=True, sharey=True)
        for line, (per_axis, (kx, ky), pattern) in zip(panels, drawn, strict=True):
            column, row = np.meshgrid(np.arange(CELLS), np.arange(CELLS))
            wave = np.exp(1j * (WAVES[kx] * column + WAVES[ky] * row))
            turn = np.exp(-1j * np.angle(pattern.ravel()[np.abs(pattern).argmax()]))
            field = np.einsum("rc,ns->rcns", wave, pattern * turn).real
            field = field.reshape(CELLS, CELLS, per_axis, per_axis, 3)
            image = field.transpose(0, 2, 1, 3, 4).reshape(CELLS * per_axis, CELLS * per_axis, 3)
            for panel, name, values in zip(line, NAMES, np.moveaxis(image, 2, 0), strict=True):
                panel.imshow(
                    values, cmap="RdBu_r", origin="lower", vmin=-abs(image).max(), vmax=abs(image).max(),
                    extent=(0, CELLS, 0, CELLS),
                )  # fmt: skip
                panel.set(xticks=range(CELLS + 1), yticks=range(CELLS + 1), title=f"stress {name}")
                panel.tick_params(labelbottom=False, labelleft=False)
                panel.grid(True)
            line[0].set_ylabel(f"{per_axis**2} a cell\nk h = ({kx}, {ky})")
    return figure


if __name__ == "__main__":
    command_line.command(null_modes)

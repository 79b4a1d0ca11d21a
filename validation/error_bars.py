"""How often the error bars of `taichi-silo converge` hold the truth, on cases whose answer is known.

    layer    the sheared layer against its one-dimensional solution: shear stress at u = 1, 2 and 4 mm, other pressure,
             void ratio and length, one and four points a cell, from three grids each
    silo     sand between frictionless walls: P is its weight, N and the wall stress follow from compression without
             lateral strain, which is integrated at one point of the material
    bar      an elastic bar that swings: the error of the displacement, RMS over the bar, tends to nothing
    fall     a body that falls: place and speed, as the time step shrinks

Leaves `error_bars.csv`, one row a case: limit, error bar, truth, whether the bar holds it; `error_bars_by_kind.csv`, a
row a kind. Cost: twelve minutes on two cores.
"""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from typer import Option

from taichi_silo.analysis.extrapolation import limit
from taichi_silo.analysis.measure.wall_pressure import cell_mean
from taichi_silo.cli import command_line
from taichi_silo.errors import RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.laws.stress_point import StressPoint
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.scene import sands
from taichi_silo.scene.scene import Flow, Machine, Method, Scene, Walls
from taichi_silo.studies.converge.quantities import BAND, HEIGHTS
from taichi_silo.studies.converge.study import converge

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # as a plain script, too
from validation import layer_study  # noqa: E402
from validation.in_parallel import in_parallel  # noqa: E402
from validation.stability import order  # noqa: E402
from validation.stability.bodies import block, solver  # noqa: E402

COLUMNS = ("case", "quantity", "value", "error", "truth", "held", "order", "trust")
LADDERS = ((0.5, 1.0, 2.0), (1.0, 2.0, 4.0))  # cells along the length, of the layer
SANDS = {"karlsruhe": (0.60, 0.75, 0.90), "hostun": (0.70,)}  # void ratios of the frictionless silo
FILLED_S = 2.0  # slowly, so that inertia plays no part
COMPRESSED, INCREMENTS = 0.02, 4000  # strain up to which a point is compressed, and its increments
CELLS = ((8, 16, 32), (16, 32, 64))  # along the bar
FALL_S, FALL_STEPS = 0.1, (50, 100, 200)


def row(case: str, quantity: str, sizes, values, truth: float) -> dict:
    """A case whose sizes and values are given."""
    found = limit(sizes, values)
    held = abs(found.value - truth) <= found.error
    told = (case, quantity, found.value, found.error, truth, held, found.order, found.trust)
    return dict(zip(COLUMNS, told, strict=True))


def of_layer(case: str, points: int) -> Iterator[dict]:
    """The sheared layer of one case, on each ladder whose grids are wanted."""
    ladders = LADDERS if case == "a" else LADDERS[:1]
    curves = {one: layer_study.compute(case, one, points, "patch")[0] for one in sorted({*sum(ladders, ())})}
    truth = layer_study.reference(case)
    for ladder in ladders:
        for u in layer_study.AT_MM:
            values = [float(np.interp(1e-3 * u, *curves[one])) for one in ladder]
            exact = float(np.interp(1e-3 * u, *truth))
            name = f"layer {case}, {points} a cell, from {ladder[0]:g} cells"
            yield row(name, f"shear stress at {u:g} mm", [1.0 / one for one in ladder], values, exact)


def of_silo(sand: str, void_ratio: float, folder: Path) -> Iterator[dict]:
    """Sand between frictionless walls after filling, by the study of convergence itself."""
    scene = Scene(
        sand=sands.sand(sand, void_ratio), walls=Walls(kind="smooth", friction_angle_deg=0.0),
        flow=Flow(speed_m_per_s=0.02, displacement_m=2e-4), machine=Machine(threads=1),
        method=Method(filling_time_s=FILLED_S),
    )  # fmt: skip
    found = converge(scene, folder / f"{sand}_{void_ratio:g}", to=1e-3, budget="1h", jobs=1, progress=False, steps=3)
    truth = compressed(scene)
    for name, exact in truth.items():
        number = found.numbers[name]
        held = abs(number.value - exact) <= number.error
        trust = number.parts["grid"].trust
        told = (f"silo {sand} {void_ratio:g}", name, number.value, number.error, exact, held, number.order, trust)
        yield dict(zip(COLUMNS, told, strict=True))


def compressed(scene: Scene) -> dict[str, float]:
    """P, N and wall stresses of a column of sand that is compressed by its weight without lateral strain."""
    law = scene.sand.skeleton()
    rest = law.rest_stress
    point = StressPoint(law, (-rest, -rest, -rest, 0.0), scene.sand.void_ratio)
    rows = [(0.0, 0.0, point.void_ratio)]
    for _ in range(INCREMENTS):
        point.step((0.0, -COMPRESSED / INCREMENTS, 0.0, 0.0))
        rows.append((-point.stress[1], -point.stress[0], point.void_ratio))
    vertical, sideways, void_ratio = np.array(rows).T
    weight = scene.weight_N_per_m / scene.silo.width_m  # on a square metre
    above = np.linspace(weight, 0.0, 20001)
    if vertical[-1] < weight:
        raise RunFailed(f"a strain of {COMPRESSED} brings {vertical[-1]:g} Pa, less than the weight of {weight:g} Pa")
    solid = scene.sand.grain_density_kg_per_m3 * scene.method.gravity_m_per_s2
    thickness = (1.0 + np.interp(above, vertical, void_ratio)) / solid  # of sand that weighs a pascal
    height = np.concatenate([[0.0], np.cumsum(0.5 * (thickness[1:] + thickness[:-1]) * -np.diff(above))])
    normal = np.interp(above, vertical, sideways)
    found = {"P_filled": weight * scene.silo.width_m, "N_filled": float(np.trapezoid(normal, height))}
    mean = cell_mean(height, normal, BAND * scene.silo.height_m)
    for share in HEIGHTS:
        found[f"pressure_filled_{share:g}"] = float(np.interp(share * scene.silo.height_m, height, mean))
    return found


def of_bar(shape: str) -> Iterator[dict]:
    """The swinging bar: its error tends to nothing."""
    runtime.init()
    errors = {cells: order.bar(SHAPES[shape](0.25), cells) for cells in sorted({*sum(CELLS, ())})}
    for ladder in CELLS:
        values = [errors[cells] for cells in ladder]
        yield row(f"bar {shape}, from {ladder[0]} cells", "error", [1.0 / cells for cells in ladder], values, 0.0)


def of_fall(shape: str) -> Iterator[dict]:
    """A body that falls from rest in ever smaller steps."""
    runtime.init()
    places, speeds = [], []
    for steps in FALL_STEPS:
        law, functions = Elastic(1e4, 0.0), SHAPES[shape](0.5)
        body, grid = block(width=0.1, height=0.1, cell=0.02, origin=(0.1, 0.3), box=(0.3, 0.5),
                           extra=Particles.extras(law, functions, Flip()))  # fmt: skip
        falling = solver(body, grid, functions, law)
        before = float(body.position.to_numpy()[:, 1].mean())
        falling.advance(steps, FALL_S / steps, (9.81, 9.81))
        places.append(float(body.position.to_numpy()[:, 1].mean()) - before)
        speeds.append(float(body.velocity.to_numpy()[:, 1].mean()))
    sizes = [FALL_S / steps for steps in FALL_STEPS]
    yield row(f"fall {shape}", "place", sizes, places, -0.5 * 9.81 * FALL_S**2)
    yield row(f"fall {shape}", "speed", sizes, speeds, -9.81 * FALL_S)


KINDS: dict[str, Callable[..., Iterator[dict]]] = {
    "layer": of_layer, "silo": of_silo, "bar": of_bar, "fall": of_fall,
}  # fmt: skip


def part(kind: str, arguments: tuple, file: Path) -> str:
    """Compute the cases of one part, and leave them in a file."""
    rows = pd.DataFrame(list(KINDS[kind](*arguments)))
    rows.to_csv(file, index=False, float_format="%.6g")
    return f"{int(rows['held'].sum())} of {len(rows)} held"


def by_kind(rows: pd.DataFrame) -> pd.DataFrame:
    """Of each kind: cases, how many bars hold the truth, and medians of the bar and of the distance from the truth."""
    truth = rows["truth"].abs().where(rows["truth"] != 0.0)
    told = rows.assign(
        kind=rows["case"].str.split().str[0],
        bar_percent=100.0 * rows["error"] / truth,
        distance_percent=100.0 * (rows["value"] - rows["truth"]).abs() / truth,
        distance_over_bar=(rows["value"] - rows["truth"]).abs() / rows["error"],
    )
    parts = told.groupby("kind", sort=False)
    medians = parts[["bar_percent", "distance_percent", "distance_over_bar"]].median()
    counts = parts["held"].agg(cases="size", held="sum")
    return counts.join(medians).reset_index()


def error_bars(
    output: Annotated[Path, Option(help="folder, for error_bars.csv")] = Path("outputs/error_bars"),
    only: Annotated[str, Option(help="layer | silo | bar | fall: these alone")] = "",
):
    """Count how often error bars hold the truth."""
    output = output.expanduser().resolve()
    output.mkdir(parents=True, exist_ok=True)
    parts: dict[str, tuple] = {}
    for case in layer_study.CASES:
        parts |= {f"layer-{case}-{points}": ("layer", (case, points)) for points in (1, 4)}
    for sand, ratios in SANDS.items():
        parts |= {f"silo-{sand}-{e:g}": ("silo", (sand, e, output)) for e in ratios}
    for shape in ("ugimp", "cpdi", "bspline"):
        parts |= {f"bar-{shape}": ("bar", (shape,)), f"fall-{shape}": ("fall", (shape,))}
    parts = {name: one for name, one in parts.items() if one[0].startswith(only)}
    files = {name: output / f"{name}.csv" for name in parts}
    missing = {name: (*parts[name], files[name]) for name in parts if not files[name].exists()}
    costs = {name: 10.0 if name.startswith(("layer-a", "silo")) else 3.0 for name in missing}
    failures = in_parallel(part, missing, costs)
    rows = pd.concat([pd.read_csv(file) for file in files.values() if file.exists()])
    rows.to_csv(output / "error_bars.csv", index=False)
    by_kind(rows).to_csv(output / "error_bars_by_kind.csv", index=False, float_format="%.3g")
    held = int(rows["held"].sum())
    print(f"{held} of {len(rows)} error bars hold the truth ({100.0 * held / len(rows):.0f} %)")
    print(output / "error_bars.csv")
    if failures:
        name, why = next(iter(failures.items()))
        raise RunFailed(f"in {name}: {why}")


if __name__ == "__main__":
    command_line.command(error_bars)

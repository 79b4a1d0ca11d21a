"""Folders of runs whose sand moves as it is told: what a run leaves, without one."""

import numpy as np
import pandas as pd

from taichi_silo.runs import snapshot
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.scene.scene import Flow, Mesh, Scene
from taichi_silo.scene.silo import Silo
from taichi_silo.scene.symmetry import whole_points

SPEED, DEPTH, FILLED_S = 0.02, 0.02, 0.5  # [m/s], [m], [s]


def scene(cell_m=0.02, silo=None, **tables):
    """A silo of 0.2 m x 0.5 m whose bottom sinks by 20 mm within a second."""
    flow = tables.pop("flow", Flow(speed_m_per_s=SPEED, displacement_m=DEPTH))
    return Scene(silo=silo or Silo(), grid=Mesh(cell_size_m=cell_m), flow=flow, **tables)


def state(what, moved_m, half=False):
    """Sand that sinks by so much, more slowly next to the walls, where it dilates; half of it mirrored, if so asked."""
    x, y, area = what.silo.lattice(what.spacing_m, what.rise_m)
    identity, wide = np.arange(len(x)), what.silo.width_m
    if half:
        kept = x < 0.5 * wide
        x, y, area, identity = x[kept], y[kept], area[kept], identity[kept]
    near = np.minimum(np.minimum(x, wide - x) / (0.2 * wide), 1.0)
    e = what.sand.void_ratio + 0.2 * (1.0 - near) * moved_m / DEPTH
    pressure = 15e3 * (what.silo.height_m - y) * (0.5 + 0.5 * moved_m / DEPTH) + 10.0
    tilt = 0.1 * pressure * np.sign(0.5 * wide - x)
    points = {
        "position": np.stack([x, y - near * moved_m], axis=1),
        "velocity": np.stack([0.0 * x, -SPEED * near * (moved_m > 0.0)], axis=1),
        "stress": -np.stack([0.5 * pressure, pressure, 0.6 * pressure, tilt], axis=1),
        "mass": 1600.0 * area, "volume": area * (1.0 + e) / (1.0 + what.sand.void_ratio),
        "path": (1.0 - near) * moved_m / 0.02 + 1e-3, "void_ratio": e, "identity": identity,
    }  # fmt: skip
    return whole_points(points, wide) if half else points


def leave(folder, what=None, states=20, half=False, left=None):
    """Write a run of so many states of flow; `left(points, part)` says which points are gone by then."""
    what = what or scene()
    (folder / "snapshots").mkdir(parents=True)
    write_parameters(folder, what, {})
    times = [("start", "filling", 0.0, 0.0), ("filled", "filling", FILLED_S, 0.0)]
    for k in range(1, states + 1):
        u = DEPTH * k / states
        named = round(1e3 * u, 6) in (2.0, 5.0, 10.0, 20.0)
        name = f"flow_{1e3 * u:07.3f}mm" if named else f"{snapshot.BETWEEN}{k:05d}"
        times.append((name, "flow", FILLED_S + u / SPEED, u))
    index = pd.DataFrame(times, columns=["file", "stage", "time_s", "displacement_m"])
    for _, row in index.iterrows():
        points = state(what, row.displacement_m, half)
        if left is not None:
            gone = left(points, row.displacement_m / DEPTH)
            points = {name: values[~gone] for name, values in points.items()}
        snapshot.write(folder / "snapshots" / f"{row.file}.vtu", points)
    index.assign(file=index.file + ".vtu").to_csv(folder / "snapshots" / "index.csv", index=False)
    write_forces(folder, what, index["time_s"].iloc[-1])
    return folder


def write_forces(folder, what, end_s, rows=60):
    """`forces.csv`: a third of the weight on each wall, the rest on the bottom."""
    time = np.linspace(end_s / rows, end_s, rows)
    weight = what.weight_N_per_m * np.minimum(time / FILLED_S, 1.0)
    columns = {"time_s": time, "stage": np.where(time <= FILLED_S, "filling", "flow")}
    columns["displacement_m"] = SPEED * np.maximum(time - FILLED_S, 0.0)
    columns["bottom_force_N_per_m"] = weight / 3.0
    for side in ("left", "right"):
        columns |= {f"{side}_normal_N_per_m": weight / 2.0, f"{side}_shear_N_per_m": weight / 3.0}
    columns |= {"wall_friction_angle_deg": np.full(rows, 33.7), "weight_N_per_m": weight}
    pd.DataFrame(columns).to_csv(folder / "forces.csv", index=False)


def lattice(columns=40, seed=5, jitter=0.2):
    """Points (n, 2) of a silo of 0.2 m x 0.5 m, off their lattice by up to a fifth; their volumes and the spacing."""
    spacing = 0.2 / columns
    x, y = np.meshgrid((np.arange(columns) + 0.5) * spacing, (np.arange(round(0.5 / spacing)) + 0.5) * spacing)
    points = np.column_stack([x.ravel(), y.ravel()])
    points += jitter * spacing * np.random.default_rng(seed).uniform(-1, 1, points.shape)
    return points, np.full(len(points), spacing**2), spacing


def down(speed):
    """Velocities (n, 2) of points that sink this fast."""
    return np.column_stack([0.0 * speed, -speed])

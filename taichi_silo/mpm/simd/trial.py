"""Formulas of sand on eight points at once and on one after the other: the program that `selftest` runs.

They are what a step is made of: the law's rate and bounds (powers, exponentials, roots, choices, a branch on the
greatest lane) in a loop, and sums to which each lane adds at a place of its own. The step itself is for the tests: an
operation that vectors do not know is unknown on every machine.
"""

import sys

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.vectors import LANES, arrays_of_eight, compiling_simd, eight
from taichi_silo.mpm.tensors import added, chosen

GROUPS, PLACES, STEPS, DT = 8, 10, 4, 2e-3
RECORD = 6  # numbers of a point: stress (4) [Pa], void ratio, place at which it adds
TOLERANCE = 1e-10  # of the greatest of each number
LAW = GudehusBauer()


@ti.func
def strained(s, e):
    """Stress and void ratio after some strain, which takes sand of little stress to its bounds."""
    s0, s1, s2, s3 = s
    for _ in range(STEPS):
        rate = LAW.rate(
            (s0, s1, s2, s3), (s0, s0, s0, s0), LAW.factors((s0, s1, s2, s3), e), (0.6, -1.0, 0.0, 0.3), 1.2
        )
        held = LAW.admissible(added((s0, s1, s2, s3), rate, DT), e)
        s0, s1, s2, s3 = chosen(e > 0.6, held, added(held, (1.0, 1.0, 1.0, 0.0), -1.0))
        e = e - 0.4 * (1.0 + e) * DT
    return s0, s1, s2, s3, e


@ti.kernel
def eight_at_once(points: arrays_of_eight, sums: arrays_of_eight):
    """Strain the points, and add up what they have come to."""
    ti.loop_config(serialize=True)
    for g in range(GROUPS):
        k = g * RECORD
        s0, s1, s2, s3, e = strained((points[k], points[k + 1], points[k + 2], points[k + 3]), points[k + 4])
        points[k], points[k + 1], points[k + 2], points[k + 3], points[k + 4] = s0, s1, s2, s3, e
        for lane in range(LANES):
            place = ti.cast(points[k + 5][lane], ti.i32)
            sums[place] = sums[place] + eight(s0[lane], s1[lane], s2[lane], s3[lane], e[lane], 0.0, 0.0, 1.0)


@ti.kernel
def one_by_one(points: ti.types.ndarray(real, 2), sums: ti.types.ndarray(real, 2)):
    """The same, point after point."""
    ti.loop_config(serialize=True)
    for p in range(GROUPS * LANES):
        s0, s1, s2, s3, e = strained((points[p, 0], points[p, 1], points[p, 2], points[p, 3]), points[p, 4])
        found, place = ti.Vector([s0, s1, s2, s3, e]), ti.cast(points[p, 5], ti.i32)
        for c in ti.static(range(5)):
            points[p, c] = found[c]
            sums[place, c] += found[c]
        sums[place, 7] += 1.0


def compare() -> str:
    """Where the two ways differ; empty if they agree."""
    runtime.init()
    chance = np.random.default_rng(1)
    pressure = 10.0 ** chance.uniform(-1.0, 4.0, GROUPS * LANES)
    start = np.stack(
        [-0.5 * pressure, -pressure, -0.5 * pressure, 0.2 * chance.uniform(-1.0, 1.0, len(pressure)) * pressure,
         chance.uniform(0.52, 0.9, len(pressure)), chance.integers(0, PLACES, len(pressure))], axis=1
    )  # fmt: skip
    points, sums = runtime.array(eight, GROUPS * RECORD), runtime.array(eight, PLACES)
    points.from_numpy(start.reshape(GROUPS, LANES, RECORD).swapaxes(1, 2).reshape(-1, LANES).copy())
    with compiling_simd():
        eight_at_once(points, sums)
    plain, plain_sums = start.copy(), np.zeros((PLACES, LANES))
    one_by_one(plain, plain_sums)
    wide = points.to_numpy().reshape(GROUPS, RECORD, LANES).swapaxes(1, 2).reshape(-1, RECORD)
    for name, one, other in (("points", plain, wide), ("sums", plain_sums, sums.to_numpy())):
        apart = (np.abs(one - other) / np.maximum(np.abs(one).max(axis=0), 1e-300)).max()
        if not apart <= TOLERANCE:
            return f"eight points at once and one after the other differ by {apart:g} in {name}"
    return ""


if __name__ == "__main__":
    found = compare()
    print(found)
    sys.exit(1 if found else 0)

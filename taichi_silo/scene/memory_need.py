"""Whether the memory of this machine suffices for a scene, before any of it is taken."""

import contextlib
import math
import os
from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.mpm.grid_means import PER_LENGTH
from taichi_silo.mpm.neighbour_rows import most_pairs
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.symmetry import half_model

GIB = 2.0**30
OF_PROCESS = 0.26 * GIB  # Python, Taichi and the compiled step
OF_STEPS = 367.0  # bytes, of a computed point and its node while steps are done
OF_FILM = 28.0  # of a point of the whole silo, in what the next state of a film is told from
OF_FIELDS = 131.0  # of a computed point while points are looked at, for which the vector unit makes room,
OF_LOOKS = 262.0  # and of a point of the whole silo in what looks: checkpoints, alarms, the measures at the end
OF_MEAN = 140.0  # of a point in a non-local average
OF_PAIR = 12.0  # of neighbours
OF_MEAN_NODE = 32.0  # of the average's grid
GROUPS = (  # where Linux keeps the limit of a control group, such as that of a container or of a batch job
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)


def needed(scene: Scene) -> float:
    """Bytes that a run of a scene takes, on the processor; rather too few than too many."""
    half = half_model(scene)[0]
    whole = scene.points
    points = whole / (2 if half or scene.silo.section == "round" else 1)
    kernel, _ = scene.averaging.kernel(scene.characteristic_length_m, scene.spacing_m)
    average = 0.0
    if kernel:
        average = OF_MEAN * points
        if scene.averaging.summed_by(kernel, scene.spacing_m, half) == "rows":
            average += OF_PAIR * most_pairs(kernel.radius, scene.spacing_m, int(points))
        else:
            average += OF_MEAN_NODE * points * (PER_LENGTH * scene.spacing_m / kernel.length_m) ** 2
    stepping, looking = OF_STEPS * points + OF_FILM * whole, OF_FIELDS * points + OF_LOOKS * whole
    return OF_PROCESS + max(stepping, looking) + average


def available() -> float:
    """Bytes that this process may take: of the machine, of its control group, of its own limit; inf if unknown."""
    found = [math.inf]
    with contextlib.suppress(AttributeError, OSError, ValueError):  # Windows does not say
        found.append(float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
    for file in GROUPS:
        with contextlib.suppress(OSError, ValueError):  # ValueError: "max"
            found.append(float(file.read_text(encoding="ascii")))
    with contextlib.suppress(ImportError):
        import resource

        own = resource.getrlimit(resource.RLIMIT_AS)[0]
        found += [] if own == resource.RLIM_INFINITY else [float(own)]
    return min(found)


def check(scene: Scene) -> None:
    """Refuse a scene that this machine has no room for; of a graphics card nothing is known.

    Raises BadInput, which says what it needs and what there is.
    """
    wanted, there = needed(scene), available()
    if scene.machine.arch == "cpu" and wanted > there:
        raise BadInput(
            f"cell size is {scene.grid.cell_size_m:g} m; its {scene.points:,} points need about {wanted / GIB:.3g} GiB "
            f"of memory, and a process has at most {there / GIB:.3g} GiB here; larger cells, fewer points a cell or a "
            "shorter characteristic length need less"
        )

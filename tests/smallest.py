"""The smallest silo: 32 points that fill and flow in a second, for tests of everything but mechanics.

All of them share its kernels, which are compiled once for the whole suite: keep width, height, cells and walls.
"""

from taichi_silo import Scene

TABLES = {  # 8 x 4 cells
    "silo": {"width_m": 0.2, "height_m": 0.4},
    "grid": {"cell_size_m": 0.05},
    "flow": {"speed_m_per_s": 0.04, "displacement_m": 0.006},
    "method": {"filling_time_s": 0.1, "longest_settling_s": 0.0},
    "machine": {"threads": 1},
}
SMALLEST = Scene.model_validate(TABLES | {"output": {"snapshots": 12, "records_per_period": 4}})


def smallest(**parts) -> Scene:
    """The smallest silo with other parts, or with other values of a part given as a dictionary."""
    update = {
        name: getattr(SMALLEST, name).model_copy(update=part) if isinstance(part, dict) else part
        for name, part in parts.items()
    }
    return SMALLEST.model_copy(update=update)

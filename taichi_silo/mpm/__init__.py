"""The explicit material point method, a library of its own: points, grid, shapes, laws, walls, the solver of a step.

from taichi_silo import mpm

mpm.init()
law = mpm.Elastic(young_modulus_Pa=1e6)
grid = mpm.Grid(width_m=1.0, height_m=1.0, cell_size_m=0.05)
points = mpm.Particles.lattice(law, width_m=0.2, height_m=0.2, spacing_m=0.05, origin_m=(0.4, 0.5))
solver = mpm.Solver(points, grid, mpm.UniformGimp(), law)
solver.run_for(0.1, gravity=9.81)
points.arrays()["velocity"]
"""

import importlib

HOME = {  # of the public names; each is imported when it is first used, because Taichi takes a second
    "runtime": ("ArchitectureError", "init"),
    "grid": ("Grid",),
    "particles": ("Particles",),
    "solver": ("STRESS_UPDATES", "Solver"),
    "mirrored_solver": ("MirroredSolver",),
    "shapes": ("SHAPES", "ContiguousGimp", "ConvectedDomain", "Linear", "QuadraticSpline", "UniformGimp"),
    "laws": ("Elastic", "GudehusBauer", "Intergranular"),
    "laws.stress_point": ("StressPoint", "wave_speed"),
    "walls": (
        "Coulomb", "Edges", "FixedNode", "Frictionless", "Gate", "NoSlip", "OpenFloor", "PlaneWall", "RoughFree",
        "Surface",
    ),
    "noise_control": ("NoiseControl",),
    "velocity_transfer": ("TRANSFERS", "Apic", "Blend", "Enhanced", "Flip", "Pic", "Xpic"),
    "filters": ("FILTERS", "NullSpace", "Smoothing"),
    "nonlocal_average": ("Exponential", "Gaussian", "Local", "NonLocal"),
    "geometry": ("Axisymmetric", "PlaneStrain", "Surroundings"),
}  # fmt: skip
_MODULES = {name: module for module, names in HOME.items() for name in names}
__all__ = sorted(_MODULES)  # noqa: PLE0605


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

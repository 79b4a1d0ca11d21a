"""Confined granular flow in silos: explicit material point method with hypoplastic sand, on Taichi.

import taichi_silo as ts

silo = ts.Silo.polygon([(0.06, 0), (0.14, 0), (0.2, 0.2), (0.2, 0.5), (0, 0.5), (0, 0.2)])
result = ts.run(ts.Scene(silo=silo, sand=ts.named_sand("hostun", 0.70)), "outputs/mine")
result.forces.plot("displacement_m", "left_normal_N_per_m")
result.state("filled")["void_ratio"].mean()
"""

import importlib
import os
import tempfile
from pathlib import Path

if os.name == "posix" and not os.environ.get("HOME"):  # without it Taichi ends the process
    try:
        os.environ["HOME"] = str(Path.home())
    except RuntimeError:  # the system does not know the user either
        os.environ["HOME"] = tempfile.gettempdir()
for _language, _prefix in (("TAICHI", "TI"), ("QUADRANTS", "QD")):
    os.environ.setdefault(f"ENABLE_{_language}_HEADER_PRINT", "0")  # a run prints only its own lines
    os.environ.setdefault(f"{_prefix}_ENABLE_PYBUF", "0")  # no kernel prints, wherever standard output goes

HOME = {  # of the public names; each is imported when it is first used, which keeps the program's start short
    "errors": ("BadInput", "RunFailed", "Stopped"),
    "simulation.record": ("Record",),
    "api": ("named_sand", "read_scene", "resume", "run"),
    "runs.plugins": ("load_plugin", "register"),
    "runs.result": ("Result",),
    "studies.calibrate.whole": ("Calibration", "calibrate"),
    "scene.scene": ("Averaging", "Filling", "Flow", "Machine", "Mesh", "Method", "Output", "Scene"),
    "scene.walls": ("Walls",),
    "scene.sand": ("IntergranularStrain", "Sand"),
    "simulation.simulation": ("Simulation",),
    "studies.converge.study": ("converge",),
    "show.film.render": ("render",),
    "show.report.page": ("report",),
    "studies.compare.whole": ("Comparison", "compare"),
    "show.export.whole": ("export",),
    "studies.sweep.study": ("sweep",),
    "studies.element_run": ("ElementCurve", "element_test"),
    "scene.silo": ("Hopper", "Insert", "Outlet", "Silo"),
}
_MODULES = {name: module for module, names in HOME.items() for name in names}
__all__ = sorted(_MODULES)  # noqa: PLE0605


def __getattr__(name: str):
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

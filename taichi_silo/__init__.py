"""Confined granular flow in silos: explicit material point method with hypoplastic sand, on Taichi."""

import os

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")  # a run prints only its own lines

from taichi_silo.faults import BadInput, RunFailed  # noqa: E402
from taichi_silo.record import Record  # noqa: E402
from taichi_silo.run import resume, run  # noqa: E402
from taichi_silo.scene import Flow, Machine, Mesh, Method, Sand, Scene, Silo, Walls  # noqa: E402
from taichi_silo.simulation import Simulation  # noqa: E402

__all__ = [
    "BadInput",
    "Flow",
    "Machine",
    "Mesh",
    "Method",
    "Record",
    "RunFailed",
    "Sand",
    "Scene",
    "Silo",
    "Simulation",
    "Walls",
    "resume",
    "run",
]

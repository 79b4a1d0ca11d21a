"""Checks of what runs need: the kernels' language, the vector unit, a film encoder, a folder, and a small run."""

import importlib.metadata
import importlib.util
import platform
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.mpm import graphics_cards, language, runtime
from taichi_silo.mpm.simd import selftest
from taichi_silo.runs.run_folder import writable
from taichi_silo.scene.scene import Flow, Machine, Mesh, Method, Scene, Walls, cores
from taichi_silo.scene.silo import Silo
from taichi_silo.show.film.encoder import encode
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils.messages import counted

LEAST_FREE = 1e9  # bytes, for a few runs
BALANCE = 1e-9  # of the weight, which the self-test must not miss


class Finding(NamedTuple):
    """The result of one check."""

    what: str  # was checked
    good: bool | None  # None if it is missing but optional, False if runs cannot do without it
    words: str  # what was found


def examine(output: Path) -> Iterator[Finding]:
    """Run all checks, one after the other; starts Taichi."""
    versions = {name: importlib.metadata.version(name) for name in ("taichi-silo", language.NAME, "numpy")}
    named = ", ".join(f"{name} {number}" for name, number in versions.items())
    yield Finding("versions", True, f"{named}, Python {platform.python_version()}, {platform.system()}")
    yield _language()
    yield _vector_unit()
    yield _graphics_card()
    yield _film()
    yield _folder(output)
    yield _cluster()
    yield _small_run()


def _language() -> Finding:
    name = language.NAME.capitalize()
    try:
        runtime.init("cpu", 1)
    except Exception as error:  # noqa: BLE001 - whatever keeps it from starting is the finding
        return Finding(name, False, f"does not start: {error}")
    return Finding(name, True, f"starts; {counted(cores(), 'core')}")


def _vector_unit() -> Finding:
    why = selftest.failure()
    slow = f"not used, steps take two to four times as long: {why}"
    return Finding("vector unit", None if why else True, slow if why else "eight points at once, as the plain loop")


def _graphics_card() -> Finding:
    """What --arch cuda and --arch vulkan would find, or what it takes for them to find something."""
    there = [f"CUDA: {graphics_cards.cuda_card() or 'a card'}"] if runtime.has_cuda() else []
    cards = graphics_cards.vulkan_cards()
    there += [f"Vulkan: {card.name} ({card.kind})" for card in cards if card.f64]
    if there:
        return Finding("graphics card", True, "; ".join(there))
    words = "; ".join([f"{card.name} computes in f32 only" for card in cards] or ["no CUDA and no Vulkan device"])
    return Finding("graphics card", None, f"{words}; runs use the processor. Vulkan takes {runtime.DRIVERS}")


def _film() -> Finding:
    with tempfile.TemporaryDirectory() as place:
        try:
            encode(Path(place) / "film.mp4", 5 * [np.zeros((1080, 1920, 3), np.uint8)])
        except (OSError, RuntimeError, subprocess.SubprocessError) as error:
            return Finding("ffmpeg", False, f"cannot make a film: {error}")
        size = (Path(place) / "film.mp4").stat().st_size
    return Finding("ffmpeg", size > 0, "makes H.264 films")


def _folder(output: Path) -> Finding:
    there = output.exists()
    try:
        free = shutil.disk_usage(writable(output)).free
    except BadInput as error:
        return Finding("output", False, str(error))
    if not there:
        output.rmdir()
    words = f"{output} can be written, {free / 1e9:.0f} GB free"
    return Finding("output", free > LEAST_FREE, words if free > LEAST_FREE else f"{words}: too little")


def _cluster() -> Finding:
    there = importlib.util.find_spec("distributed") is not None
    return Finding("clusters", True if there else None, "dask is there" if there else "need dask, the extra [cluster]")


def _small_run() -> Finding:
    """A silo of 50 points is filled: forces must balance, and the walls carry part of the weight."""
    begun = time.perf_counter()
    try:
        runtime.init("cpu", 1)
        scene = Scene(
            silo=Silo(width_m=0.1, height_m=0.2),
            walls=Walls(kind="smooth", friction_angle_deg=19.0), grid=Mesh(cell_size_m=0.02),
            flow=Flow(speed_m_per_s=0.02, displacement_m=0.001),
            method=Method(filling_time_s=0.1, longest_settling_s=0.1),
            machine=Machine(threads=1, lanes=False),
        )  # fmt: skip
        records = list(Simulation(scene).run())
    except Exception as error:  # noqa: BLE001 - whatever goes wrong is the finding
        return Finding("self-test", False, f"a small silo went wrong: {error}")
    weight, last = scene.weight_N_per_m, records[-1]
    missed = max(abs(record.residual_N_per_m) for record in records) / weight
    carried = 2.0 * last.shear_N_per_m / weight
    good = bool(missed < BALANCE and 0.0 < carried < 1.0)
    seconds = time.perf_counter() - begun
    words = f"a small silo in {seconds:.1f} s: forces balance to {missed:.0e} of the weight, {carried:.0%} on the walls"
    return Finding("self-test", good, words)

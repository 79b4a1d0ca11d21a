"""The one place where the language of the kernels is started.

Every field of the project is f64: a bottom that moves at 0.1 mm/s shifts a point by 2e-9 m a step,
which is below the spacing of f32 numbers at 0.5 m (3e-8 m). The environment variable TAICHI_SILO_PRECISION makes a
process that does with less (f32; mixed: only places in f64), so that the stability map can show what is lost.
"""

import contextlib
import io
import os
import tempfile
import time
import weakref
from pathlib import Path

from taichi_silo.errors import way
from taichi_silo.mpm import graphics_cards, one_taichi
from taichi_silo.mpm.language import NAME, ti

PRECISION = os.environ.get("TAICHI_SILO_PRECISION", "f64")
if PRECISION not in ("f64", "f32", "mixed"):
    raise ValueError(f"TAICHI_SILO_PRECISION is {PRECISION!r}; it must be f64, f32 or mixed")
real = ti.f64 if PRECISION == "f64" else ti.f32
real_place = ti.f32 if PRECISION == "f32" else ti.f64
CACHE_BYTES = 1 << 30  # of compiled kernels that are kept; a tenth, which is usual, holds those of a few scenes
ON_CPU = way("arch", "cpu")
OWN_BUFFERS = 4  # of a kernel on Vulkan beside its trees: arguments, results, and the like
MOST_TREES = 512  # that there may be elsewhere
ARCHITECTURES = ("cpu", "cuda", "vulkan")
DRIVERS = "the driver of a graphics card, or Mesa's software driver (mesa-vulkan-drivers and libvulkan1 on Debian)"
_arrays: list[weakref.ref] = []  # what `array` has made under the running Taichi


class ArchitectureError(RuntimeError):
    """The asked-for processor cannot be used on this machine."""


def init(arch: str = "cpu", threads: int = 1) -> None:
    """Start Taichi afresh; all fields made before are dead afterwards. A crew goes on with the one that there is.

    Parameters
    ----------
    arch : "cpu", "cuda" or "vulkan".
    threads : number of CPU threads that share a step (ignored on a GPU).

    Raises
    ------
    ArchitectureError
        if `arch` is unknown, no device of the kind answers, or none of Vulkan computes in f64.
    BadInput
        if this process was forked from one in which Taichi ran, or it works for a run in another thread.

    """
    one_taichi.check()
    if arch not in ARCHITECTURES:
        raise ArchitectureError(f"arch is {arch!r}; it must be one of {', '.join(ARCHITECTURES)}")
    if (crew := one_taichi.crew()) and arch != _running():
        crew.wait_for_end()  # of the others, whose fields end with the Taichi that there is
    if crew and arch == _running():
        return
    options = {"default_fp": real, "log_level": ti.ERROR, "offline_cache": True}
    if not _cache_can_be_kept():
        options |= {"offline_cache": False, "offline_cache_file_path": tempfile.gettempdir()}
    options["offline_cache_max_size_of_files"] = CACHE_BYTES
    _forget_arrays()
    with contextlib.redirect_stdout(io.StringIO()):
        if arch == "cuda":
            if not has_cuda():
                raise ArchitectureError(f"arch is 'cuda' but this machine has no CUDA device; use {ON_CPU}")
            ti.init(arch=ti.cuda, **options)
        elif arch == "vulkan":
            ti._lib.core.set_vulkan_visible_device(str(vulkan_card().number))
            ti.init(arch=ti.vulkan, **options)
            if is_cpu():  # Taichi's own search has found none
                raise ArchitectureError(f"arch is 'vulkan' but {NO_VULKAN}")
        else:
            # one task of a parallel loop is one thread's whole share of the step (see solver.py)
            options["make_cpu_multithreading_loop"] = False
            if NAME == "taichi":  # the fork never groups tasks by itself
                options["cpu_block_dim_adaptive"] = False
            ti.init(arch=ti.cpu, cpu_max_num_threads=threads, **options)
    one_taichi.started()


NO_VULKAN = f"no Vulkan device answers; install {DRIVERS}, or use {ON_CPU}"


def vulkan_card() -> graphics_cards.Card:
    """The device that Vulkan computes on.

    Raises ArchitectureError, which says what to install, if there is none, or none that computes in f64.
    """
    cards = graphics_cards.vulkan_cards()
    if not cards:
        raise ArchitectureError(f"arch is 'vulkan' but {NO_VULKAN}")
    card = graphics_cards.chosen(cards)
    if card is None:
        names = ", ".join(card.name for card in cards)
        raise ArchitectureError(
            f"arch is 'vulkan' but {names} computes in f32 only (no shaderFloat64), in which slow sand stands still; "
            f"use {ON_CPU}"
        )
    return card


def device() -> str:
    """What the running Taichi computes on, and how precisely, in words."""
    if is_cpu():
        return f"cpu, {PRECISION}"
    if ti.lang.impl.current_cfg().arch == ti.vulkan:
        card = vulkan_card()
        return f"vulkan on {card.name}, {card.kind}, {PRECISION}"
    return f"cuda on {graphics_cards.cuda_card() or 'a card without a name'}, {PRECISION}"


def array(dtype: object, length: int) -> ti.Ndarray:
    """An array of so many elements, zero at first, which ends with the Taichi that it belongs to."""
    made = ti.ndarray(dtype, length)
    setattr(made, one_taichi.MARK, True)
    _arrays.append(weakref.ref(made))
    return made


def whole_numbers(*shapes: tuple[int, ...]) -> list[ti.Field]:
    """Fields of i32, zero at first, of these shapes, in a tree of their own.

    On Vulkan, Taichi 1.7.4 lays what follows an odd number of i32 in the same tree as f64 over them.
    """
    made, tree = [], ti.FieldsBuilder()
    for shape in shapes:
        made.append(ti.field(ti.i32))
        branch = tree.dense([ti.i, ti.ij, ti.ijk][len(shape) - 1], shape) if shape else tree
        branch.place(made[-1])
    tree.finalize()
    return made


def _forget_arrays() -> None:
    """Take their memory from all arrays that `array` has made; the end of Taichi frees it.

    An array hands its memory back when Python collects it, to whichever Taichi runs by then. In Taichi 1.7 one that is
    collected after the next start so takes away a new array that happens to lie at the same address.
    """
    for reference in _arrays:
        if (made := reference()) is not None:
            made.arr = None
    _arrays.clear()


def _cache_can_be_kept() -> bool:
    """Whether compiled kernels can be kept for the next process; Taichi fails with a folder that it cannot make."""
    place = Path(ti.lang.impl.default_cfg().offline_cache_file_path)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(place, os.R_OK | os.W_OK | os.X_OK)


def wait() -> None:
    """Return when everything launched so far is done."""
    ti.sync()


def seconds() -> float:
    """Of a clock that measures the work for this run."""
    crew = one_taichi.crew()
    return crew.seconds() if crew else time.perf_counter()


def has_cuda() -> bool:
    """Whether a CUDA device answers."""
    return ti._lib.core.with_cuda()


def is_cpu() -> bool:
    """Whether the running Taichi works on the CPU."""
    return ti.lang.impl.current_cfg().arch in (ti.x64, ti.arm64)


def lacks_functions() -> bool:
    """Whether the running Taichi has no power and no exponential of f64 numbers (SPIR-V has them of f32 only)."""
    return ti.lang.impl.current_cfg().arch == ti.vulkan


def most_trees() -> int:
    """How many trees of fields a kernel may use."""
    return vulkan_card().buffers - OWN_BUFFERS if _running() == "vulkan" else MOST_TREES


def _running() -> str:
    """The architecture of the running Taichi."""
    return "cpu" if is_cpu() else "vulkan" if ti.lang.impl.current_cfg().arch == ti.vulkan else "cuda"


def threads() -> int:
    """Number of CPU threads that share a step; 1 on a GPU."""
    return ti.lang.impl.current_cfg().cpu_max_num_threads if is_cpu() else 1


def alone() -> bool:
    """Whether one thread of a processor does everything: that which calls a kernel, so that its cache stays warm."""
    return is_cpu() and threads() == 1

"""Pages of memory: large ones where steps go through them, and none where nothing of worth is. On Linux."""

import ctypes
import mmap
import sys

from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import NAME, ti

PAGE = mmap.PAGESIZE
M_MMAP_THRESHOLD = -3  # of malloc.h: what is as large lies in pages of its own
LARGE = 1 << 20  # bytes


def in_large_pages(*arrays: ti.Ndarray) -> None:
    """Have arrays lie in pages of 2 MiB from when they are next given back: steps of large silos are a tenth faster."""
    if sys.platform == "linux":
        _advise(arrays, mmap.MADV_HUGEPAGE)


def give_back(*arrays: ti.Ndarray) -> None:
    """Hand back the memory of arrays: they are zero afterwards, or, where that cannot be done, as they were.

    It is done of arrays in the memory of a processor, whole pages at a time.
    """
    if sys.platform == "linux":
        _advise(arrays, mmap.MADV_DONTNEED)


def give_back_freed() -> None:
    """Have what Python frees of large arrays handed back at once, of which the GNU C library else keeps most."""
    if sys.platform == "linux" and (option := getattr(ctypes.CDLL(None), "mallopt", None)):
        option(M_MMAP_THRESHOLD, LARGE)


def _advise(arrays: tuple[ti.Ndarray, ...], advice: int) -> None:
    """Tell the system something of the whole pages in which arrays lie."""
    if NAME != "taichi" or not runtime.is_cpu():
        return
    program, system = ti.lang.impl.get_runtime().prog, ctypes.CDLL(None)
    for array in arrays:
        begin = program.get_ndarray_data_ptr_as_int(array.arr)
        end = begin + array.arr.element_size() * array.arr.nelement()
        first, last = -(-begin // PAGE) * PAGE, end // PAGE * PAGE
        if last > first:
            system.madvise(ctypes.c_void_p(first), ctypes.c_size_t(last - first), advice)

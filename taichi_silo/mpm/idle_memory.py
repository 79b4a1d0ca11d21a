"""Memory of arrays that hold nothing of worth, handed back to the system until they are used again."""

import ctypes
import mmap
import sys

from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import NAME, ti

PAGE = mmap.PAGESIZE


def give_back(*arrays: ti.Ndarray) -> None:
    """Hand the memory of arrays back: they are zero afterwards, or, where that cannot be done, as they were.

    It is done on Linux, of arrays in the memory of a processor, whole pages at a time.
    """
    if sys.platform != "linux" or NAME != "taichi" or not runtime.is_cpu():
        return
    program, system = ti.lang.impl.get_runtime().prog, ctypes.CDLL(None)
    for array in arrays:
        begin = program.get_ndarray_data_ptr_as_int(array.arr)
        end = begin + array.arr.element_size() * array.arr.nelement()
        first, last = -(-begin // PAGE) * PAGE, end // PAGE * PAGE
        if last > first:
            system.madvise(ctypes.c_void_p(first), ctypes.c_size_t(last - first), mmap.MADV_DONTNEED)

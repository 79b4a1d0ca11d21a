"""Fields read and written from Python: on a processor through the memory in which they lie, without a kernel.

Taichi copies a field by a kernel of its own for each field and direction, which takes 20 ms at every start, and 50 us a
call. Here one kernel for each tree of fields says where the tree lies; the places within it are known.
"""

import ctypes

import numpy as np
from numpy.typing import ArrayLike

from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import NAME, ti

OWN = __name__.rsplit(".", 1)[0]  # of whose objects fields are sought


def values(field: ti.Field, end: int | None = None, begin: int = 0) -> np.ndarray:
    """A copy of a field, whose last axis is that of its vectors; or of entries `begin` to `end`."""
    part = present(field, end, begin)
    return part if view(field) is None else part.copy()


def present(field: ti.Field, end: int | None = None, begin: int = 0) -> np.ndarray:
    """As `values`, but the field itself where that can be had: to be used before anything else happens to it."""
    seen = view(field)
    whole = field.to_numpy() if seen is None else seen
    return whole if end is None else whole[begin:end]


def put(field: ti.Field, given: ArrayLike, end: int | None = None, begin: int = 0) -> None:
    """Set a field to values that can be broadcast to its shape; or entries `begin` to `end`, and those after to 0."""
    seen = view(field)
    whole = np.zeros(_shape(field), ti.lang.util.to_numpy_type(field.dtype)) if seen is None else seen
    if seen is None and begin:
        whole = field.to_numpy()
    if end is None:
        whole[...] = given
    else:
        whole[begin:end], whole[end:] = given, 0
    if seen is None:
        field.from_numpy(whole)


def view(field: ti.Field) -> np.ndarray | None:
    """The field itself as an array, which must not outlive the running Taichi; None where its memory is another's.

    That is on a GPU, in the fork of Taichi, and in trees with more than one level.
    """
    seen = _known("views")
    if id(field) not in seen:
        seen[id(field)] = field, _seen(field)
    return seen[id(field)][1]


def trees(*owners: object) -> set[int]:
    """Numbers of the trees in which the fields of some objects lie, and of all that these hold."""
    found, waiting, seen = set(), list(owners), set()
    while waiting:
        one = waiting.pop()
        if id(one) in seen:
            continue
        seen.add(id(one))
        if isinstance(one, ti.Field):
            first = one.get_scalar_field(0) if isinstance(one, ti.MatrixField) else one
            found.add(first.snode._snode_tree_id)
        elif isinstance(one, dict | list | tuple | set):
            waiting += one.values() if isinstance(one, dict) else one
        elif type(one).__module__.startswith(OWN):
            waiting += vars(one).values()
    return found


def _known(what: str) -> dict:
    """What is known of fields until Taichi is started anew."""
    return vars(ti.lang.impl.get_runtime()).setdefault(what, {})


def _seen(field: ti.Field) -> np.ndarray | None:
    branch = field.parent()
    if NAME != "taichi" or not runtime.is_cpu() or branch.parent().parent() is not None:
        return None
    first = field.get_scalar_field(0) if isinstance(field, ti.MatrixField) else field
    shape, kind = _shape(field), np.dtype(ti.lang.util.to_numpy_type(field.dtype))
    cell, begin = branch._cell_size_bytes, first.snode._offset_bytes_in_parent_cell
    strides = [cell * int(np.prod(field.shape[n + 1 :])) for n in range(len(field.shape))]
    strides += [kind.itemsize] * (len(shape) - len(strides))  # components of a vector lie side by side
    bytes_of_all = cell * int(np.prod(field.shape))
    memory = (ctypes.c_char * bytes_of_all).from_address(_begin(first) + branch._offset_bytes_in_parent_cell)
    return np.ndarray(shape, kind, memory, begin, strides)


def _shape(field: ti.Field) -> tuple[int, ...]:
    return tuple(field.shape) + ((field.n,) if isinstance(field, ti.MatrixField) else ())


def _begin(field: ti.Field) -> int:
    """Address of the tree of a field."""
    known, tree = _known("begins_of_trees"), field.snode._snode_tree_id
    if tree not in known:
        known[tree] = _address(field) - sum(
            place._offset_bytes_in_parent_cell for place in (field.snode, field.parent())
        )
    return known[tree]


@ti.kernel
def _address(field: ti.template()) -> ti.u64:
    return ti.get_addr(field, ti.static([0] * len(field.shape)))

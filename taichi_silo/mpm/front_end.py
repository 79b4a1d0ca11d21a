"""The front end of the language, which reads the kernels' sources, in a third of its time.

For every expression of every function that a kernel calls, Taichi composes anew where it stands, for messages of errors
that hardly ever come; for every function that is decorated it searches all modules for the one that holds it. Here
each text is composed, and each source read, once. What is compiled is the same.
"""

import contextlib
import functools
import importlib
import inspect
import linecache
import re
import sys
import textwrap
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

from taichi_silo.mpm.launches import Launch, Launches

MODULES = {  # that find whether a function is one of a class, read sources, wrap lines
    "taichi": ("kernel_impl", "kernel_impl", "kernel_impl"),
    "quadrants": ("kernel_impl", "_wrap_inspect", "_func_base"),
}
HEADS = re.compile(r"@(\w+\.)?data_oriented|class ")  # of a class's text
LAUNCHES = "_launches"  # attribute of an object
OWN = __name__.split(".")[0] + "."  # whose kernels are launched without being looked up
remember = functools.lru_cache(1 << 16)


@contextlib.contextmanager
def frames_by_file() -> Iterator[None]:
    """While the language is imported, which decorates functions of its own, lines of frames are looked up by file."""
    usual = inspect.getframeinfo
    inspect.getframeinfo = lambda frame, context=1: ("", 0, "", [line_of(frame)], 0)  # type: ignore[assignment, return-value]
    try:
        yield
    finally:
        inspect.getframeinfo = usual


def line_of(frame: Any) -> str:
    """The line of the source at which a frame is."""
    return linecache.getline(frame.f_code.co_filename, frame.f_lineno)


def speed_up(name: str) -> None:
    """Let the language of a name, taichi or quadrants, remember what it looks up, if it looks it up as it does now."""
    with contextlib.suppress(ImportError, AttributeError):
        _speed_up(name)


def _speed_up(name: str) -> None:
    deciding, reading, wrapping = (importlib.import_module(f"{name}.lang.{module}") for module in MODULES[name])
    deciding._inside_class = inside_class
    reading.getsourcelines, reading.getsourcefile = remember(reading.getsourcelines), remember(reading.getsourcefile)
    wrapping.textwrap = SimpleNamespace(fill=remember(textwrap.fill), dedent=remember(textwrap.dedent))
    if name == "taichi":  # the fork remembers positions and finds kernels itself
        deciding.data_oriented = importlib.import_module("taichi").data_oriented = functools.partial(
            data_oriented, deciding._BoundedDifferentiableMethod, deciding.data_oriented
        )
        context = importlib.import_module("taichi.lang.ast.ast_transformer_utils").ASTTransformerContext
        context.get_pos_info = position


def inside_class(level_of_class_stackframe: int) -> bool:
    """Whether the statement that runs so many frames above is a class: a function is then decorated as its own."""
    try:
        frame = sys._getframe(level_of_class_stackframe)
    except ValueError:  # it is in the first line of a program
        return False
    return HEADS.match(line_of(frame).strip()) is not None


def position(context: Any, node: Any) -> str:
    """The text of a place in a source: file, line, function, and what stands there."""
    line, name = node.lineno + context.lineno_offset, context.func.func.__name__
    return f'File "{context.file}", line {line}, in {name}:\n{context.src[node.lineno - 1]}\n'


class BoundKernel:
    """A kernel among the attributes of a class: an object's own when it is asked for.

    Taichi looks for kernels whenever any attribute of such an object is asked for, in each of its functions.
    """

    def __init__(self, bind: Callable, kernel: Any):
        self.bind, self.kernel = bind, kernel
        kernel._is_staticmethod = False

    def __get__(self, owner: Any, kind: type | None = None) -> Any:
        if owner is None:
            return self.kernel
        if not type(owner).__module__.startswith(OWN):
            return self._bound(owner)
        launches = vars(owner).get(LAUNCHES)
        if launches is None or launches.owner != id(owner):  # the object is new, or a copy
            launches = vars(owner)[LAUNCHES] = Launches(id(owner))
        if self not in launches.known:
            launches.known[self] = Launch(self._bound(owner), sys.modules["taichi"])
        return launches.known[self]

    def _bound(self, owner: Any) -> Any:
        bound = self.bind(owner, self.kernel)
        bound.__name__ = self.kernel.__name__
        return bound


def data_oriented(bind: Callable, usual: Callable, kind: type) -> type:
    """A class whose functions may be kernels; `usual` is Taichi's decorator, for what is no plain function."""
    if any(isinstance(one, property | staticmethod) and _holds_kernel(one) for one in vars(kind).values()):
        return usual(kind)
    for name, one in list(vars(kind).items()):
        if hasattr(one, "_is_wrapped_kernel"):
            setattr(kind, name, BoundKernel(bind, one))
    kind._data_oriented = True  # type: ignore[attr-defined]
    return kind


def _holds_kernel(one: Any) -> bool:
    return hasattr(one.fget if isinstance(one, property) else one.__func__, "_is_wrapped_kernel")

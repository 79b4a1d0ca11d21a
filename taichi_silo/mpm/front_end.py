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
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

MODULES = {  # that find whether a function is one of a class, read sources, wrap lines
    "taichi": ("kernel_impl", "kernel_impl", "kernel_impl"),
    "quadrants": ("kernel_impl", "_wrap_inspect", "_func_base"),
}
HEADS = re.compile(r"@(\w+\.)?data_oriented|class ")  # of a class's text
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
    wrapping.textwrap = SimpleNamespace(fill=remember(textwrap.fill), dedent=textwrap.dedent)
    if name == "taichi":  # the fork remembers positions itself
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

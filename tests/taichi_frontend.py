"""Compile kernels in two thirds of the time: Taichi wraps the source line of each expression of each function anew.

The lines stand in its messages of errors, which stay as they are; here each is wrapped once.
"""

import functools
import importlib
import sys
import textwrap
from types import SimpleNamespace

from taichi_silo.mpm.language import NAME

wrapping, reading, compiling = (  # the module that wraps lines, that reads sources, that compiles
    importlib.import_module(f"{NAME}.lang.{module}")
    for module in (
        ("kernel_impl", "kernel_impl", "kernel_impl") if NAME == "taichi" else ("_func_base", "_wrap_inspect", "kernel")
    )
)
transforming = importlib.import_module(f"{NAME}.lang.ast.ast_transformer_utils")
remember = functools.lru_cache(1 << 16)


class Wrapper:
    """As textwrap.TextWrapper, remembering the lines."""

    def __init__(self, width: int):
        self.wrap = functools.partial(wrapped, width=width)


@remember
def wrapped(text: str, width: int) -> list[str]:
    return textwrap.wrap(text, width)


transforming.TextWrapper = Wrapper
wrapping.textwrap = SimpleNamespace(fill=remember(textwrap.fill), dedent=textwrap.dedent)
reading.getsourcelines = remember(reading.getsourcelines)
reading.getsourcefile = remember(reading.getsourcefile)


def untraced(function):
    """The function, without coverage watching: what Taichi does while it compiles is not the package's own."""

    @functools.wraps(function)
    def call(*args, **kwargs):
        trace = sys.gettrace()
        sys.settrace(None)
        try:
            return function(*args, **kwargs)
        finally:
            sys.settrace(trace)

    return call


compiling.Kernel.materialize = untraced(compiling.Kernel.materialize)

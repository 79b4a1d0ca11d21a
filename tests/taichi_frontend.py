"""Compile kernels in two thirds of the time: Taichi wraps the source line of each expression of each function anew.

The lines stand in its messages of errors, which stay as they are; here each is wrapped once.
"""

import functools
import sys
import textwrap
from types import SimpleNamespace

from taichi.lang import kernel_impl
from taichi.lang.ast import ast_transformer_utils

remember = functools.lru_cache(1 << 16)


class Wrapper:
    """As textwrap.TextWrapper, remembering the lines."""

    def __init__(self, width: int):
        self.wrap = functools.partial(wrapped, width=width)


@remember
def wrapped(text: str, width: int) -> list[str]:
    return textwrap.wrap(text, width)


ast_transformer_utils.TextWrapper = Wrapper
kernel_impl.textwrap = SimpleNamespace(fill=remember(textwrap.fill), dedent=textwrap.dedent)
kernel_impl.getsourcelines = remember(kernel_impl.getsourcelines)
kernel_impl.getsourcefile = remember(kernel_impl.getsourcefile)


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


kernel_impl.Kernel.materialize = untraced(kernel_impl.Kernel.materialize)

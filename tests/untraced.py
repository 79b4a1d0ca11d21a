"""Coverage does not watch while kernels are compiled: what the language does then is not the package's own."""

import functools
import importlib
import sys

from taichi_silo.mpm.language import NAME

compiling = importlib.import_module(f"{NAME}.lang.{'kernel_impl' if NAME == 'taichi' else 'kernel'}")


def untraced(function):
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

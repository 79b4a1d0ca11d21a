"""Kernels of objects, launched on a processor again and again without being looked up anew.

For each launch Taichi works out from all arguments which version of a kernel is meant. That takes 50 us, and three
times as long where a step has just filled the caches with its own. Which version it is only arrays and templates
decide: for the same ones as before it is known, and numbers are handed on as they are.
"""

from typing import Any

MOST = 8  # versions that are kept


class Launches:
    """Those of an object, by its kernels; a copy of the object, which has another number, begins with none."""

    def __init__(self, owner: int):
        self.owner = owner
        self.known: dict[Any, Launch] = {}

    def __reduce__(self) -> tuple:
        """Nothing of it is copied."""
        return Launches, (0,)


class Launch:
    """A kernel of an object, as `usual` (Taichi's own) launches it.

    Parameters
    ----------
    usual : the kernel bound to the object.
    language : `taichi`.

    """

    def __init__(self, usual: Any, language: Any):
        self.usual, self.language = usual, language
        self.__name__ = usual.__name__
        self.number = -1  # of the arguments, once it is known,
        self.deciding: list[int] = []  # and which of them are no numbers
        self.versions: dict[tuple[int, ...], Version] = {}

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Launch it."""
        if len(given) == self.number and not named:
            version = self.versions.get(tuple(id(given[n]) for n in self.deciding))
            if version is not None and version.runtime is self.language.lang.impl.get_runtime():
                return version.launch(given)
        result = self.usual(*given, **named)
        if not named:
            self._keep(given)
        return result

    def _keep(self, given: tuple[Any, ...]) -> None:
        """Keep the version that has just run, if it is one of a processor and of arrays of Taichi's own."""
        config, core = self.language.lang.impl.current_cfg(), self.language._lib.core
        kernel, scalars = self.usual._primal, self.language.types.primitive_types
        kinds = [id(one.annotation) for one in kernel.arguments[1:]]
        numbers = {*scalars.real_type_ids, id(self.language.i32)}
        deciding = [n for n, kind in enumerate(kinds) if kind not in numbers]
        known = all(
            isinstance(given[n], self.language.Ndarray)
            or isinstance(kernel.arguments[n + 1].annotation, self.language.template)
            for n in deciding
        )
        plain = not kernel.has_print and (kernel.return_type is None or len(kernel.return_type) == 1)
        if len(given) == len(kinds) and known and plain and config.arch in (core.x64, core.arm64):
            if len(self.versions) >= MOST:
                self.versions.clear()
            self.number, self.deciding = len(given), deciding
            key = tuple(id(given[n]) for n in deciding)
            self.versions[key] = Version(self.language, kernel, self.usual._kernel_owner, given)


class Version:
    """A compiled kernel and its arrays, which it keeps: what else has their place in memory is none of them.

    Of a Taichi that has ended it keeps nothing: neither the program nor the memory of arrays, which would take from the
    next one what they hand back.
    """

    def __init__(self, language: Any, kernel: Any, owner: Any, given: tuple[Any, ...]):
        scalars = language.types.primitive_types
        self.kernel, self.given = kernel, given
        self.runtime = language.lang.impl.get_runtime()
        program = self.runtime.prog
        number, _ = kernel.mapper.lookup((owner, *given))
        self.made = kernel.compiled_kernels[kernel.func, number, kernel.autodiff_mode]
        self.code = program.compile_kernel(program.config(), program.get_device_caps(), self.made)
        self.arrays, self.reals, self.whole = [], [], []  # slots, and the array or the number of the argument
        slot = 0
        for n, one in enumerate(kernel.arguments[1:]):
            if isinstance(one.annotation, language.template):
                continue
            if id(one.annotation) in scalars.real_type_ids:
                self.reals.append(((slot,), n))
            elif one.annotation is language.i32:
                self.whole.append(((slot,), n))
            else:
                self.arrays.append(((slot,), given[n]))
            slot += 1

    def launch(self, given: tuple[Any, ...]) -> Any:
        """Launch it with these arguments, of which numbers may be others than before."""
        context = self.made.make_launch_context()
        for slot, array in self.arrays:
            context.set_arg_ndarray(slot, array.arr)
        for slot, n in self.reals:
            context.set_arg_float(slot, float(given[n]))
        for slot, n in self.whole:
            context.set_arg_int(slot, int(given[n]))
        self.runtime.prog.launch_kernel(self.code, context)
        if self.kernel.return_type is None:
            return None
        (kind,) = self.kernel.return_type
        return self.kernel.construct_kernel_ret(context, kind, (0,))

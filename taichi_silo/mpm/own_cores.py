"""A core for each thread of a step, where the threads are as many as the cores.

Threads that share a step wait for each other some times in it. When a launch begins, the system may put two of them on
one core, where they wait for the end of a time slice, and for milliseconds nothing goes on. Which threads of the
process they are Taichi does not say: they are those that work while a launch runs.
"""

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path

TASKS = Path("/proc/self/task")
LONG_S = 0.003  # launches that are over sooner do not tell who worked
TRIALS = 20
WORKS = 0.2  # of its time: others may want the cores, too


class OwnCores:
    """Gives the threads of launches their cores, once; nothing where there are more cores, or no Linux."""

    def __init__(self, threads: int):
        cores = os.sched_getaffinity(0) if hasattr(os, "sched_setaffinity") and TASKS.is_dir() else set()
        self.cores, self.trials = sorted(cores), TRIALS if threads > 1 and threads == len(cores) else 0

    @contextlib.contextmanager
    def of_launch(self) -> Iterator[None]:
        """While a launch runs; afterwards those that worked have their cores."""
        if not self.trials:
            yield
            return
        before, begun = self._worked(), time.perf_counter()
        yield
        took = time.perf_counter() - begun
        if took < LONG_S:
            return
        self.trials -= 1
        after = self._worked()
        busy = sorted(number for number, spent in after.items() if spent - before.get(number, spent) > WORKS * took)
        if len(busy) == len(self.cores):
            self.trials = 0
            for number, core in zip(busy, self.cores, strict=True):
                with contextlib.suppress(OSError):
                    os.sched_setaffinity(number, {core})

    @staticmethod
    def _worked() -> dict[int, float]:
        """Seconds that each other thread of this process has worked."""
        found = {}
        for task in TASKS.iterdir():
            with contextlib.suppress(OSError, ValueError, IndexError):
                if int(task.name) != os.getpid():
                    found[int(task.name)] = 1e-9 * int((task / "schedstat").read_text().split()[0])
        return found

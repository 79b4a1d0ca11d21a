"""Parts of a study, each in a process of its own, as many at a time as there are cores."""

import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed

from taichi_silo.scene.scene import cores


def in_parallel(function: Callable[..., str], arguments: dict[str, tuple], costs: dict[str, float]) -> dict[str, str]:
    """Call a function once for each named tuple of arguments; print what it returns, and how long the rest takes.

    Parameters
    ----------
    function : of a module, so that another process finds it; returns a few words on what it found.
    arguments : by the names of the parts.
    costs : of each part, in any unit; the longest is begun first, so that no core waits for it at the end.

    Returns
    -------
    The errors of parts that failed, by their names.

    """
    begun, done, whole, failures = time.monotonic(), 0.0, sum(costs[name] for name in arguments), {}
    with ProcessPoolExecutor(max(1, min(len(arguments), cores())), max_tasks_per_child=1) as workers:
        order = sorted(arguments, key=lambda name: -costs[name])
        jobs = {workers.submit(function, *arguments[name]): name for name in order}
        for job in as_completed(jobs):
            name, error = jobs[job], job.exception()
            if error is not None:
                failures[name] = str(error)
            done += costs[name]
            left = (time.monotonic() - begun) * (whole - done) / done
            words = failures.get(name) or job.result()
            print(f"{100 * done / whole:5.1f} %  {name:24s} {words:32s} {left / 60:5.1f} min left", flush=True)
    return failures

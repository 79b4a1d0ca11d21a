"""Many scenes at once, for studies written in Python: each in a process of its own, finished ones kept."""

from pathlib import Path

from taichi_silo.errors import RunFailed
from taichi_silo.runs.run_folder import writable
from taichi_silo.scene.scene import cores
from taichi_silo.studies.sweep.processes import simulate
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.utils.messages import counted


def run_all(runs: dict[str, Run], output: Path) -> None:
    """Run the scenes that have no finished run yet, as many at a time as there are cores, and say how far they are.

    Raises BadInput if the folder cannot be written; RunFailed if some fail, after all have ended; it names the first.
    """
    missing = {name: run for name, run in runs.items() if not run.finished}
    for name in runs:
        if name not in missing:
            print(f"{name:20s} kept", flush=True)
    writable(output)
    failures = simulate(missing, cores())
    for name, why in failures.items():
        raise RunFailed(f"in {len(failures)} of {counted(len(runs), 'run')}, the first of them '{name}': {why}")

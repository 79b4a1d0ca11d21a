"""One run of a sweep, as a program: it reads scene, folder and film from its input and says which part is done."""

import sys

from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.runs.observers import Observer
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.utils.child_process import SAID_NO, STOPPED, given
from taichi_silo.utils.machine_faults import of_machine

SAID_EVERY = 0.01  # of the run


class Part(Observer):
    """Says which part of the expected steps is done."""

    def __init__(self, steps: int):
        self.steps, self.said = steps, 0.0

    def begin(self, simulation) -> None:
        """Keep what counts the steps."""
        self.simulation = simulation

    def observe(self, record) -> None:
        """Say it, if it has grown."""
        part = min(self.simulation.clock.steps / self.steps, 0.99)
        if part >= self.said + SAID_EVERY:
            self.said = part
            print(f"{part:.3f}", flush=True)


def main() -> None:
    """Simulate; a run that fails says so in one sentence."""
    run, steps = Run.from_json(given())
    try:
        run.attempt((Part(steps),) if steps else ())
    except (BadInput, RunFailed) as error:
        print(error, file=sys.stderr)
        sys.exit(SAID_NO)
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        sys.exit(STOPPED)
    except Exception as error:
        fault = of_machine(error)
        if fault is None:
            raise
        print("; ".join(fault), file=sys.stderr)
        sys.exit(SAID_NO)


if __name__ == "__main__":
    main()

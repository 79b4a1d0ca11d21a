"""One run of a batch, as a program: it reads scene, folder and film from its input and says which part is done."""

import json
import sys
from pathlib import Path

from taichi_silo.faults import BadInput, RunFailed
from taichi_silo.observers import Observer
from taichi_silo.one_run import run
from taichi_silo.processes import given
from taichi_silo.scene import Scene

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
        part = min(self.simulation.steps / self.steps, 0.99)
        if part >= self.said + SAID_EVERY:
            self.said = part
            print(f"{part:.3f}", flush=True)


def main() -> None:
    """Simulate; a run that fails says so in one sentence."""
    wanted = json.loads(given())
    extra = (Part(wanted["steps"]),) if wanted["steps"] else ()
    scene, folder = Scene.model_validate(wanted["scene"]), Path(wanted["folder"])
    try:
        run(scene, folder, overwrite=True, film=wanted["film"], extra=extra)
    except (BadInput, RunFailed) as error:
        print(error, file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()

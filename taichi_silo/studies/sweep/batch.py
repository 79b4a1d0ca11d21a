"""Runs that one process does: one, or on a graphics card several of one kind, whose steps the same launches do."""

import functools
import json
import traceback
from collections.abc import Callable, Mapping

from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.mpm import one_taichi
from taichi_silo.mpm.crew import Crew
from taichi_silo.runs.observers import Observer
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.utils.machine_faults import of_machine
from taichi_silo.utils.process_pool import STOPPED
from taichi_silo.utils.signals import heard

MOST = 8  # runs together: the formulas of each are compiled
SAID_EVERY = 0.01  # of all runs


class Part(Observer):
    """Says which part of the expected steps of all runs is done; `done` holds that of each run, by its number."""

    def __init__(self, number: int, steps: int, all_steps: int, done: dict[int, float]):
        self.number, self.steps, self.all_steps, self.done = number, steps, all_steps, done

    def begin(self, simulation) -> None:
        """Keep what counts the steps."""
        self.simulation = simulation

    def observe(self, record) -> None:
        """Say it, if it has grown."""
        own = min(self.simulation.clock.steps, 0.99 * self.steps) / self.all_steps
        if own >= self.done.get(self.number, 0.0) + SAID_EVERY:
            self.done[self.number] = own
            print(f"{sum(self.done.values()):.3f}", flush=True)


def lines(runs: Mapping[str, Run], steps: Mapping[str, int]) -> str:
    """The line of input for the program that makes these runs, of so many expected steps each."""
    return json.dumps([run.to_json(steps.get(name, 0)) for name, run in runs.items()])


def attempt(line: str) -> list[str]:
    """Do what a line of `lines` asks for; returns for each run the sentence that says why it failed, or nothing."""
    runs = [Run.from_json(one) for one in json.loads(line)]
    all_steps = sum(steps for _, steps in runs)
    done: dict[int, float] = {}
    failures = [""] * len(runs)

    def one(number: int) -> None:
        run, steps = runs[number]
        observers = (Part(number, steps, all_steps, done),) if steps else ()
        failures[number] = _failure(lambda: run.attempt(observers))

    if len(runs) == 1:
        one(0)
        return failures
    with one_taichi.held(), heard():
        runs[0][0].scene.machine.start()
        Crew([functools.partial(one, number) for number in range(len(runs))]).work()
    return failures


def _failure(work: Callable[[], None]) -> str:
    """Why it failed, in one sentence; empty if it did not."""
    try:
        work()
    except (BadInput, RunFailed) as error:
        return str(error)
    except KeyboardInterrupt:
        return STOPPED
    except Exception as error:  # noqa: BLE001 - the other runs go on
        if fault := of_machine(error):
            return "; ".join(fault)
        traceback.print_exc()
        return f"{type(error).__name__}: {error}"
    return ""


def alike(runs: Mapping[str, Run]) -> list[list[str]]:
    """Names of runs that one process does: each alone, but on a graphics card those of one kind, `MOST` at a time."""
    kinds: dict[tuple, list[str]] = {}
    for name, run in runs.items():
        on_card = run.scene.machine.arch != "cpu"
        kinds.setdefault((run.scene.machine, *run.formulas) if on_card else (name,), []).append(name)
    return [names[n : n + MOST] for names in kinds.values() for n in range(0, len(names), MOST)]

"""Leads the workers of a sweep: hands out the runs, hears how far they are, and keeps what they bring."""

import contextlib
import time
import uuid
from collections.abc import Callable

from taichi_silo.runs.cost_estimate import Cost
from taichi_silo.studies.sweep.runs import PROGRAM, Run
from taichi_silo.studies.sweep.work import STOPPED, Crashed, stop, work
from taichi_silo.utils.child_process import GRACE_S

ASKED_EVERY_S = 0.3
SEEN_S = 60.0  # after which a file system shows what another machine has written


class Crew:
    """The workers behind a client of dask.

    Parameters
    ----------
    client : of `distributed`.
    retries : how often a run is begun again whose process crashed; deaths of workers are counted by their scheduler.
    heard : hears the name of a run, the part of it that is done, and the process of its worker.
    program : that makes a run.

    """

    def __init__(self, client, retries: int, heard: Callable[[str, float, int], None], program=PROGRAM):
        self.client, self.retries, self.heard, self.program = client, retries, heard, program
        self.sweep = f"taichi-silo-{uuid.uuid4().hex}"

    def run(self, runs: dict[str, Run], expected: dict[str, Cost], ended: Callable[[str, str], None]) -> None:
        """Do all, the longest first; one that fails stops no other.

        Parameters
        ----------
        runs : by their names.
        expected : their costs, as far as they are known.
        ended : hears the name of each that has ended, and its trouble, a sentence, or nothing.

        """
        from distributed import as_completed

        self.client.subscribe_topic(self.sweep, self._hear)
        futures = {}
        seconds = {name: expected[name].core_seconds if name in expected else 0.0 for name in runs}
        for name in sorted(runs, key=lambda name: -seconds[name]):  # idle workers begin with what comes first
            run, cost = runs[name], expected.get(name)
            future = self.client.submit(
                work, name, run.order(cost.steps if cost else 0), self.sweep, self.program, pure=False,
                key=(self.sweep, name), retries=self.retries, priority=seconds[name],
            )  # fmt: skip
            futures[future.key] = (name, future)
        unseen = []
        try:
            waiting = [one for _, one in futures.values()]
            for future, result in as_completed(waiting, self.client.loop, with_results=True, raise_errors=False):
                name, _ = futures.pop(future.key)  # whose end keeps it from being done again with its worker's death
                trouble = self._trouble(future, result)
                future.release()
                if not trouble and not runs[name].finished:
                    unseen.append(name)
                    continue
                ended(name, trouble)
            for name in unseen:
                ended(name, self._seen(runs[name]))
        except BaseException:
            self._stop([one for _, one in futures.values()])
            raise
        finally:
            with contextlib.suppress(Exception):  # a scheduler that is gone
                self.client.unsubscribe_topic(self.sweep)

    def _hear(self, event: tuple) -> None:
        _, message = event
        self.heard(message["run"], message["part"], message["pid"])

    def _trouble(self, future, result) -> str:
        if future.status == "finished":
            return result
        if future.status != "error":
            return STOPPED
        _, error, _ = result
        if isinstance(error, Crashed):
            return f"{error}, {self.retries + 1} times"
        if type(error).__name__ == "KilledWorker":
            return f"{error.allowed_failures + 1} workers died while they ran it"
        return f"{type(error).__name__} on a worker: {error}"

    def _seen(self, run: Run) -> str:
        """Wait until this machine sees a run that its worker has finished."""
        end = time.monotonic() + SEEN_S
        while not run.finished and time.monotonic() < end:
            time.sleep(ASKED_EVERY_S)
        return "" if run.finished else f"its worker finished it, but {run.folder} is not shared with this machine"

    def _stop(self, futures: list) -> None:
        """Let no other run begin, and give those that run the time to put their files in order."""
        with contextlib.suppress(Exception):  # workers that are gone have stopped
            self.client.cancel(futures)
            end = time.monotonic() + GRACE_S
            while sum(self.client.run(stop, self.sweep, on_error="ignore").values()) and time.monotonic() < end:
                time.sleep(ASKED_EVERY_S)

"""Tasks, each in a process of its own: a crash costs one task, and nothing is left of it in memory."""

import contextlib
import threading
import time
import uuid
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field

from taichi_silo.utils.child_process import GRACE_S, Child
from taichi_silo.utils.console import Console
from taichi_silo.utils.progress import Progress

STOPPED = "stopped"
SAID_EVERY_S = 1.0  # of a task that tells how far it is
ASKED_EVERY_S = 0.1  # whether all have stopped
_children: dict[str, set[Child]] = {}  # of this process, by the pool that wants them
_stopped: set[str] = set()  # pools
_lock = threading.Lock()  # a task begins either before its pool is stopped, or not at all


@dataclass(frozen=True)
class Task:
    """A module to run as a program, with its arguments, its line of input, and its expected seconds on one core.

    Of the lines that it prints, a number says which part of it is done, between 0 and 1.
    """

    name: str
    program: tuple[str, ...]
    line: str = ""
    environment: dict[str, str] = field(default_factory=dict)
    seconds: float = 1.0


class ProcessPool:
    """As many tasks at a time as `jobs`, on this machine; one whose process crashes is begun again, `retries` times."""

    def __init__(self, jobs: int, retries: int = 0):
        self.jobs, self.retries, self.key = jobs, retries, f"taichi-silo-{uuid.uuid4().hex}"

    def run(
        self,
        tasks: Iterable[Task],
        console: Console = Console(quiet=True),  # noqa: B008 - it is frozen
        ended: Callable[[str, str], str] = lambda name, failure: failure or "done",
    ) -> dict[str, str]:
        """Run all, the longest first; one that fails stops no other. An interrupt stops all, and begins no other.

        Parameters
        ----------
        tasks : what to run; names are unique.
        console : where to say how far they are.
        ended : hears, in the calling thread, the name of a task that is over and why it failed, in a sentence, or
            nothing; returns the words for it.

        Returns
        -------
        Why tasks failed, by their names.

        """
        tasks, failures = sorted(tasks, key=lambda task: -task.seconds), {}
        with (
            Progress(console.terminal, {task.name: task.seconds for task in tasks}, self.jobs) as progress,
            self._workers(progress.heard) as submit,
        ):
            waiting = {submit(task): task.name for task in tasks}
            try:
                for future in as_completed(list(waiting)):
                    name, failure = waiting.pop(future), self._failure(future)
                    if failure:
                        failures[name] = failure
                    progress.ended(name, ended(name, failure))
            except BaseException:
                for future in waiting:
                    future.cancel()
                last = time.monotonic() + GRACE_S
                try:
                    while self._stop() and time.monotonic() < last:
                        time.sleep(ASKED_EVERY_S)
                finally:  # also when asked once more
                    self._stop(kill=True)
                raise
        return failures

    @contextlib.contextmanager
    def _workers(self, heard: Callable[[str, float], None]) -> Iterator[Callable[[Task], Future]]:
        """A function that submits a task; `heard` hears names of tasks and their parts that are done."""
        with ThreadPoolExecutor(self.jobs) as executor:
            yield lambda task: executor.submit(run_task, task, self.key, self.retries, heard)

    def _stop(self, kill: bool = False) -> int:
        """Ask all tasks to stop, or kill them; returns how many there still are."""
        return stop_tasks(self.key, kill)

    def _failure(self, future: Future) -> str:
        """Why a task failed; empty if it did not."""
        try:
            return future.result()
        except CancelledError:
            return STOPPED
        except Exception as error:  # noqa: BLE001 - it is told, and stops no other task
            return f"{type(error).__name__}: {error}"


def run_task(task: Task, pool: str, retries: int, heard: Callable[[str, float], None]) -> str:
    """Run a task in a process, again if that crashes; returns why it failed, in a sentence, or nothing."""
    for _ in range(retries + 1):
        with _lock:
            if pool in _stopped:
                return STOPPED
            child = Child(task.program, task.line, task.environment)
            _children.setdefault(pool, set()).add(child)
        try:
            _follow(child, lambda part: heard(task.name, part))
        finally:
            with _lock:
                _children[pool].discard(child)
        if not child.crashed:
            return child.trouble
    return f"{child.trouble}, {retries + 1} times" if retries else child.trouble


def _follow(child: Child, heard: Callable[[float], None]) -> None:
    """Hear what a child says until it ends."""
    heard(0.0)
    last = -SAID_EVERY_S
    for line in child.lines():
        try:
            part = float(line)
        except ValueError:
            child.keep(line)
            continue
        if time.monotonic() > last + SAID_EVERY_S:
            last = time.monotonic()
            heard(part)


def stop_tasks(pool: str, kill: bool = False) -> int:
    """Ask all tasks that a pool has in this process to stop, now and later; returns how many there still are."""
    with _lock:
        _stopped.add(pool)
        children = list(_children.get(pool, ()))
    for child in children:
        with contextlib.suppress(OSError):
            child.process.kill() if kill else child.interrupt()
    return len(children)

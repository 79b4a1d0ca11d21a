"""Tasks, each in a process of its own, as many at a time as there are cores; how far they are, and their end."""

import threading
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field

from taichi_silo.utils.child_process import GRACE_S, Child, end
from taichi_silo.utils.time_left import Tally

SAID_EVERY = 0.05  # of the whole work, between two tasks' ends


@dataclass(frozen=True)
class Task:
    """A module to run as a program, with its arguments, its line of input, and its expected seconds on one core."""

    name: str
    program: tuple[str, ...]
    line: str = ""
    environment: dict = field(default_factory=dict)
    seconds: float = 1.0


class Processes:
    """As many tasks at a time as `jobs`, the longest first; `say` hears a sentence when one ends and in between."""

    def __init__(self, jobs: int, say=print):
        self.jobs, self.say = jobs, say
        self.children, self.lock, self.stopped = set(), threading.Lock(), False

    def run(self, tasks: list[Task], heard=lambda task, line: None, ended=lambda task, trouble: trouble or "done"):
        """Run all; one that fails stops no other.

        Parameters
        ----------
        tasks : what to run; names are unique.
        heard : hears each line that a task puts out, and returns the part of it that is done, between 0 and 1, or None
            if the line does not say.
        ended : hears, in the calling thread, when a task is over and its trouble, a sentence, or nothing; returns the
            words for it.

        Returns
        -------
        The troubles by the tasks' names.

        """
        self.said, self.heard = 0.0, heard
        self.tally = Tally({task.name: task.seconds for task in tasks}, self.jobs)
        troubles = {}
        workers = ThreadPoolExecutor(self.jobs)
        try:
            waiting = sorted(tasks, key=lambda task: -task.seconds)
            jobs = {workers.submit(self._one, task): task for task in waiting}
            for job in as_completed(jobs):
                task, trouble = jobs[job], job.result()
                if trouble:
                    troubles[task.name] = trouble
                words = ended(task, trouble)
                self._advance(task, 1.0, words)
        except BaseException:
            self._stop()
            raise
        finally:
            workers.shutdown(wait=True, cancel_futures=True)
        return troubles

    def _advance(self, task: Task, part: float, words: str = "") -> None:
        """Say how far the whole is, now that this part of a task is done; without words only now and then."""
        share = self.tally.advance(task.name, part)
        with self.lock:
            if not words and share < self.said + SAID_EVERY:
                return
            self.said = share
        words = words or f"{100 * part:.0f} %"
        self.say(f"{100 * share:5.1f} %  {task.name:60s} {words:24s} {self.tally.left_s / 60:5.1f} min left")

    def _one(self, task: Task) -> str:
        """Run a task; returns why it failed, or nothing."""
        with self.lock:
            if self.stopped:
                return "stopped"
            child = Child(task.program, task.line, task.environment)
            self.children.add(child)
        try:
            for line in child.lines():
                part = self.heard(task, line)
                if part is None:
                    child.keep(line)
                else:
                    self._advance(task, part)
        except BaseException:  # whoever listens asked to stop: this worker must not begin the next task
            with self.lock:
                self.stopped = True
            raise
        with self.lock:
            self.children.discard(child)
        return child.trouble

    def _stop(self) -> None:
        """Stop all children."""
        with self.lock:
            self.stopped = True
            children = list(self.children)
        end(children, GRACE_S)

"""Tasks, each in a process of its own, as many at a time as there are cores for them; how far they are, and their end.

A task is given one line on its input, which then stays open: a task that reads it by `given` is interrupted, as by
Ctrl-C, when whoever started it stops it or is gone. No task outlives its parent for longer than it needs to put
its files in order.
"""

import _thread
import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field

GRACE_S = 20.0  # for a task that is stopped: it ends its interval and leaves its files
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
        self.begun, self.said, self.heard = time.monotonic(), 0.0, heard
        self.whole, self.done = sum(task.seconds for task in tasks), {task.name: 0.0 for task in tasks}
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
        with self.lock:
            self.done[task.name] = part * task.seconds
            share = sum(self.done.values()) / self.whole
            if not words and share < self.said + SAID_EVERY:
                return
            self.said = share
        left = (time.monotonic() - self.begun) * (1.0 - share) / max(share, 1e-9)
        words = words or f"{100 * part:.0f} %"
        self.say(f"{100 * share:5.1f} %  {task.name:60s} {words:24s} {left / 60:5.1f} min left")

    def _one(self, task: Task) -> str:
        """Run a task; returns why it failed, or nothing."""
        command = [sys.executable, "-m", *task.program]
        with tempfile.TemporaryFile("w+", encoding="utf-8") as errors:  # a pipe that nobody reads in time would fill up
            with self.lock:
                if self.stopped:
                    return "stopped"
                child = subprocess.Popen(
                    command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True,
                    env=os.environ | task.environment, start_new_session=True,
                )  # fmt: skip
                self.children.add(child)
            try:
                rest = self._talk(child, task)
            except BaseException:  # whoever listens asked to stop: this worker must not begin the next task
                with self.lock:
                    self.stopped = True
                raise
            with self.lock:
                self.children.discard(child)
            if child.returncode == 0:
                return ""
            errors.seek(0)
            lines = errors.read().strip().splitlines() or rest
        return lines[-1] if lines else f"ended with code {child.returncode}"

    def _talk(self, child, task: Task) -> list[str]:
        """Give the child its line, and listen until it ends; returns what it said beside how far it is."""
        with contextlib.suppress(BrokenPipeError):  # it ended at once, and says why
            child.stdin.write(task.line + "\n")
            child.stdin.flush()
        rest = []
        for line in child.stdout:
            part = self.heard(task, line)
            if part is None:
                rest.append(line.strip())
            else:
                self._advance(task, part)
        child.wait()
        with contextlib.suppress(BrokenPipeError):
            child.stdin.close()
        return rest

    def _stop(self) -> None:
        """Interrupt all children, and kill those that do not end."""
        with self.lock:
            self.stopped = True
            children = list(self.children)
        for child in children:
            with contextlib.suppress(BrokenPipeError):
                child.stdin.close()
        end = time.monotonic() + GRACE_S
        try:
            for child in children:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    child.wait(max(0.0, end - time.monotonic()))
        finally:  # also when asked once more
            for child in children:
                child.kill()


def given() -> str:
    """The line that a task was given; from now on the end of its input interrupts it."""
    line = sys.stdin.readline()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a parent in the background may ignore it

    def watch() -> None:
        while os.read(sys.stdin.fileno(), 1):  # past Python's own buffer, which a waiting thread would lock
            pass
        if os.name == "nt":  # where signals to a process only end it
            _thread.interrupt_main()
        else:
            os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=watch, daemon=True).start()
    return line

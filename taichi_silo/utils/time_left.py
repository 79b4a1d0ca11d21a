"""How far a work of many tasks is, and the time that is left of it."""

import threading
import time


class Tally:
    """The parts of tasks that are done, weighted by their expected seconds; it may be told by many threads.

    Parameters
    ----------
    seconds : expected, on one core, by the tasks' names.
    jobs : tasks at a time.

    """

    def __init__(self, seconds: dict[str, float], jobs: int = 1):
        self.seconds, self.jobs, self.parts = seconds, jobs, dict.fromkeys(seconds, 0.0)
        self.whole = max(sum(seconds.values()), 1e-9)
        self.begun, self.lock = time.monotonic(), threading.Lock()

    def advance(self, name: str, part: float) -> float:
        """Now this part of a task is done (less than before, if it was begun again); returns the share of the whole."""
        with self.lock:
            self.parts[name] = part
            return self.share

    @property
    def share(self) -> float:
        """Of the whole that is done."""
        return sum(part * self.seconds[name] for name, part in self.parts.items()) / self.whole

    @property
    def left_s(self) -> float:
        """Seconds until the end: at the pace so far, and no less than the longest task still needs at that pace."""
        rest = [(1.0 - part) * self.seconds[name] for name, part in self.parts.items()]
        passed, done = time.monotonic() - self.begun, self.whole - sum(rest)
        if done <= 0.0:
            return max(sum(rest) / self.jobs, max(rest))
        slowness = min(self.jobs, len(rest)) * passed / done  # of a core, against what was expected
        return max(passed / done * sum(rest), slowness * max(rest))

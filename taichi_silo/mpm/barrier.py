"""Where the threads of one launch wait for each other."""

import taichi as ti

SPIN_LIMIT = 500_000_000  # turns of a waiting thread before it gives up (some seconds)
LOST = 32  # slot of `arrivals` that says that one did
MOST_ARRIVALS = 1_000_000_000  # counted before they start anew


@ti.data_oriented
class Barrier:
    """Counts the arrivals of all threads; the host hands each launch the number that have been counted before it."""

    def __init__(self, threads: int):
        self.threads = threads
        self.arrivals = ti.field(ti.i32, shape=64)
        self.passed = 0

    def reserve(self, waits: int) -> int:
        """Arrivals before a launch in which each thread waits so many times."""
        if self.passed > MOST_ARRIVALS:
            self.arrivals.fill(0)
            self.passed = 0
        before = self.passed
        self.passed += waits * self.threads
        return before

    def lost(self) -> bool:
        """Whether a thread waited in vain for the others."""
        return self.threads > 1 and bool(self.arrivals[LOST])

    @ti.func
    def wait(self, before, number):
        """Wait until all threads have come here for the `number`th time (0, 1, ...) in a launch."""
        if ti.static(self.threads > 1):
            enough = before + (number + 1) * self.threads
            ti.atomic_add(self.arrivals[0], 1)
            turns = 0
            while ti.atomic_max(self.arrivals[0], -1) < enough and turns < SPIN_LIMIT and self.arrivals[LOST] == 0:
                turns += 1  # the maximum with -1 is an atomic load
            if turns >= SPIN_LIMIT:
                self.arrivals[LOST] = 1

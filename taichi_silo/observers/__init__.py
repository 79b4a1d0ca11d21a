"""What looks at a run while it goes on.

The simulation neither prints nor writes; observers do, each on a schedule of its own.
"""


class Observer:
    """Looks, and never touches."""

    def begin(self, simulation) -> None:
        """Before the first interval."""

    def observe(self, record) -> None:
        """After each interval."""

    def filled(self) -> None:
        """Between filling and flow."""

    def end(self) -> None:
        """After the last interval, or the failed one."""

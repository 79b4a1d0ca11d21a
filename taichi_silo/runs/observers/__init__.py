"""What looks at a run while it goes on.

The simulation neither prints nor writes; observers do, each on a schedule of its own.
"""


class Observer:
    """Looks at a simulation after each interval and changes nothing in it.

    A run that was left goes on in another process: there `restore` takes the place of `begin`, with what `state` gave
    at the last checkpoint. One that keeps nothing between two records needs neither.
    """

    def joins(self, kept: dict | None) -> bool:
        """Whether it takes part in a run that goes on; asked before any work.

        Parameters
        ----------
        kept : its state at the checkpoint; None if the run had no such observer.

        Raises
        ------
        BadInput
            if the run must not go on without it, and it cannot begin midway.

        """
        return True

    def prepare(self, simulation) -> None:
        """Before a new run writes anything: whatever is raised here leaves none."""

    def begin(self, simulation) -> None:
        """Before the first interval."""

    def observe(self, record) -> None:
        """After each interval."""

    def filled(self) -> None:
        """Between filling and flow."""

    def failed(self, why: str) -> None:
        """The run has ended before its time; `end` comes next."""

    def end(self) -> None:
        """After the last interval, or the failed one."""

    def state(self) -> dict:
        """What it needs to go on after the last record: numbers, words, arrays, dictionaries of them.

        What it has put into files up to then is on the disk when this returns.
        """
        return {}

    def restore(self, simulation, kept: dict) -> None:
        """Go on from a state; `kept` is empty if it was not there before."""
        self.begin(simulation)


REGISTERED: dict[str, type[Observer]] = {}  # by plugins: every run gets one of each

"""Standard output and error that end no run: nobody may listen, the disk may be full, a code page may lack a letter."""

import contextlib
import os
import sys
from typing import Any


class Lasting:
    """A stream that goes on in silence once it cannot be written any more.

    Attributes
    ----------
    lost : why it cannot be written; None while it can.

    """

    def __init__(self, stream: Any):
        self.stream, self.lost = stream, None
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="backslashreplace")

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        """Write, or forget."""
        with self._noted():
            self.stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write what is held back, or forget it."""
        with self._noted():
            self.stream.flush()

    @contextlib.contextmanager
    def _noted(self):
        try:
            yield
        except (OSError, ValueError) as error:  # a ValueError of a closed stream
            if self.lost is None:
                self.lost = error
                self._to_nowhere()

    def _to_nowhere(self) -> None:
        """What is still held back must not fail anew when the process ends."""
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.stream.fileno())
            os.close(nowhere)


def last() -> None:
    """Make the streams of this process last."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed before the process began
            stream = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 (for as long as the process lives)
        if not isinstance(stream, Lasting):
            setattr(sys, name, Lasting(stream))


def heard() -> None:
    """Raise the error with which standard output was lost, for a command whose result is what it prints.

    A listener that went away on purpose, as `head` does, is none.
    """
    sys.stdout.flush()
    lost = getattr(sys.stdout, "lost", None)
    if isinstance(lost, OSError) and not isinstance(lost, BrokenPipeError):
        raise lost

"""A program in a process of its own that stops when its parent does.

The parent writes one line to its input, which then stays open. The program reads it by `given`, and from then on the
end of its input interrupts it as Ctrl-C would: when the parent stops it, or is gone. So it has time to put its files in
order, and no more.
"""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator

GRACE_S = 20.0  # for a program that is stopped: it ends its interval and leaves its files
DONE, SAID_NO, STOPPED = 0, 1, 130  # exit codes of a program that has not crashed


class Child:
    """A module that runs as a program, with arguments, a line of input, and variables beside those of this process."""

    def __init__(self, program: tuple[str, ...], line: str = "", environment: dict | None = None):
        self.line = line
        self.rest: list[str] = []  # lines of its output that no one has understood
        self.errors = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115 - it fills no pipe
        process = subprocess.Popen(
            [sys.executable, "-m", *program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.errors,
            text=True, encoding="utf-8", errors="replace", start_new_session=True,
            env=os.environ | {"PYTHONIOENCODING": "utf-8"} | (environment or {}),
        )  # fmt: skip
        assert process.stdin and process.stdout
        self.process, self.input, self.output = process, process.stdin, process.stdout

    def lines(self) -> Iterator[str]:
        """Write its input line, and return the lines of its output until it ends."""
        with contextlib.suppress(BrokenPipeError, ValueError):  # it ended at once, and says why; or is stopped already
            self.input.write(self.line + "\n")
            self.input.flush()
        yield from self.output
        self.process.wait()
        self.interrupt()
        self.output.close()

    def keep(self, line: str) -> None:
        """Keep a line of its output; the last one says why it failed if its stderr does not."""
        self.rest.append(line.strip())

    def interrupt(self) -> None:
        """Ask it to stop."""
        with contextlib.suppress(BrokenPipeError):
            self.input.close()

    @property
    def crashed(self) -> bool:
        """Whether it ended with none of its exit codes."""
        return self.process.returncode not in (DONE, SAID_NO, STOPPED)

    @property
    def trouble(self) -> str:
        """Why it failed, in a sentence; empty if it did not."""
        code = self.process.returncode
        if code == DONE:
            return ""
        if code < 0:
            name = signal.Signals(-code).name
            return f"its process was ended by {name}" + (", as when memory runs out" if name == "SIGKILL" else "")
        self.errors.seek(0)
        lines = self.errors.read().strip().splitlines() or self.rest
        return lines[-1] if lines else f"ended with code {code}"


def given() -> str:
    """The first line of this program's input; from now on the end of the input interrupts it."""
    line = sys.stdin.readline()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a parent in the background may ignore it

    def watch() -> None:
        while os.read(sys.stdin.fileno(), 1):  # past Python's own buffer, which a waiting thread would lock
            pass
        signal.raise_signal(signal.SIGINT)

    threading.Thread(target=watch, daemon=True).start()
    return line

"""The errors that every part of the program may raise: bad input, a failed run, a failed machine, a stop."""

from typing import Any, NamedTuple


class Way(NamedTuple):
    """A way out of an error, in the words of Python and of the command line; a sentence that names it holds the former.

    >>> f"{way('overwrite')}, {way('frame', 10)}", way("frame", 10).command_line
    ('overwrite=True, frame=10', '--frame 10')
    """

    python: str
    command_line: str

    def __str__(self) -> str:
        return self.python

    def __format__(self, _: str) -> str:
        return self.python


def way(parameter: str, value: Any = True) -> Way:
    """The way of giving a parameter a value; True is a flag without one."""
    flag = f"--{parameter.replace('_', '-')}"
    return Way(f"{parameter}={value!r}", flag if value is True else f"{flag} {value}")


class BadInput(ValueError):
    """What the user asked for is not possible; nothing has been done or written.

    Parameters
    ----------
    sentence : what is wrong, and what would be right.
    ways : those that it names, which a command line has other words for.

    """

    def __init__(self, sentence: str, *ways: Way):
        super().__init__(sentence)
        self.ways = ways

    @property
    def on_command_line(self) -> str:
        """The sentence in the words of the command line."""
        sentence = str(self)
        for one in self.ways:
            sentence = sentence.replace(one.python, one.command_line)
        return sentence


class RunFailed(RuntimeError):
    """The run went wrong; everything up to then is kept."""


class MachineFailed(RunFailed):
    """The machine could not do what the run needed: no space, no memory, a folder that is gone; says how to go on."""


class Stopped(KeyboardInterrupt):
    """Somebody asked the run to stop, by Ctrl-C or a signal; it did so between two intervals, and can go on from there.

    Attributes
    ----------
    code : exit code of the process, 128 and the signal's number.

    """

    def __init__(self, sentence: str, code: int):
        super().__init__(sentence)
        self.code = code

"""The ways in which a run says no, or that it was told to stop."""

from taichi_silo.quoting import sentence


class BadInput(ValueError):
    """What the user asked for is not possible; nothing has been done or written. It is said on one short line."""

    def __init__(self, words: str):
        super().__init__(sentence(words))


class RunFailed(RuntimeError):
    """The run went wrong; everything up to then is kept."""


class Stopped(KeyboardInterrupt):
    """Somebody asked the run to stop, by Ctrl-C or a signal; it did so between two intervals, and can go on from there.

    Attributes
    ----------
    code : exit code of the process, 128 and the signal's number.

    """

    def __init__(self, sentence: str, code: int):
        super().__init__(sentence)
        self.code = code

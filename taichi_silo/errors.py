"""The errors that every part of the program may raise: bad input, a failed run, a failed machine, a stop."""


class BadInput(ValueError):
    """What the user asked for is not possible; nothing has been done or written."""


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

"""The ways in which a run says no, or that it was told to stop; and what the machine is to blame for, in words."""

import errno
import os
from pathlib import Path

from taichi_silo.quoting import sentence

REMEDIES = {
    errno.ENOSPC: "free some space",
    errno.EDQUOT: "free some of the space that you may use",
    errno.EFBIG: "raise the limit of a file's size",
    errno.EROFS: "let it be written to",
    errno.EACCES: "let it be written to",
    errno.EPERM: "let it be written to",
    errno.ENOENT: "put it back where it was",
    errno.ENOMEM: "leave it more memory",
    errno.EMFILE: "let the process open more files",
}
MEMORY_WORDS = ("out of memory", "bad_alloc", "failed to map segment", "cannot allocate memory")  # of libraries
NO_MEMORY = ("memory has run out", "leave it more memory, or give it larger cells")


class BadInput(ValueError):
    """What the user asked for is not possible; nothing has been done or written. It is said on one short line."""

    def __init__(self, words: str):
        super().__init__(sentence(words))


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


def of_file(error: OSError, file: Path) -> OSError:
    """The same error, of this file."""
    if error.errno is None:  # of a library that gives no number
        return OSError(errno.EIO, str(error), str(file))
    return OSError(error.errno, error.strerror or os.strerror(error.errno), str(file))


def of_machine(error: BaseException) -> tuple[str, str] | None:
    """What the machine could not do, and what to do about that; None of errors that it is not to blame for."""
    if isinstance(error, MemoryError) or any(words in str(error).lower() for words in MEMORY_WORDS):
        return NO_MEMORY
    if not isinstance(error, OSError):
        return None
    where = "a file" if error.filename is None else error.filename
    words = f"{where} cannot be written: {error.strerror or error}"
    return words, REMEDIES.get(error.errno, "see to that")

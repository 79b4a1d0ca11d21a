"""Errors of the machine (disk, memory, permissions) as sentences, each with a remedy."""

import errno
import os
from pathlib import Path

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


def of_file(error: OSError, file: Path) -> OSError:
    """The same error, with the name of the file that it is about."""
    if error.errno is None:  # of a library that gives no number
        return OSError(errno.EIO, str(error), str(file))
    return OSError(error.errno, error.strerror or os.strerror(error.errno), str(file))


def of_machine(error: BaseException) -> tuple[str, str] | None:
    """What the machine could not do and the remedy; None for an error that is not the machine's."""
    if isinstance(error, MemoryError) or any(words in str(error).lower() for words in MEMORY_WORDS):
        return NO_MEMORY
    if not isinstance(error, OSError):
        return None
    where = "a file" if error.filename is None else error.filename
    words = f"{where} cannot be written: {error.strerror or error}"
    return words, REMEDIES.get(error.errno or 0, "see to that")

"""A home for processes that have none: Taichi ends a process without the variable HOME."""

import os
import tempfile
from pathlib import Path


def ensure() -> None:
    """Set HOME, to the user's folder or to that of temporary files, if it is not set."""
    if os.name == "posix" and not os.environ.get("HOME"):
        try:
            os.environ["HOME"] = str(Path.home())
        except RuntimeError:  # the system does not know the user either
            os.environ["HOME"] = tempfile.gettempdir()

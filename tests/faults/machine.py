"""Real failures of the kernel, for a while: files that must not grow, a disk of some kilobytes, no right to write."""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from taichi_silo.cli import app


@contextlib.contextmanager
def files_end_at(size: int):
    """Within, no file grows beyond so many bytes: EFBIG, after what still fits was written."""
    resource = pytest.importorskip("resource")  # Windows has no such limit
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, usual[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)


class Disk:
    """A file system in memory."""

    def __init__(self, place: Path, size: int):
        self.place = place
        place.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "silo", place], capture_output=True)
        if done.returncode:
            pytest.skip("it takes the right to mount a file system")

    def become(self, *options: str) -> None:
        subprocess.run(["mount", "-o", f"remount,{','.join(options)}", self.place], check=True)

    def __enter__(self) -> "Disk":
        return self

    def __exit__(self, *_) -> None:
        subprocess.run(["umount", "-l", self.place], check=True)


@contextlib.contextmanager
def nobody():
    """Within, this process has no more rights to files than any user."""
    if not hasattr(os, "geteuid"):
        pytest.skip("Windows keeps rights in other ways")
    own = os.geteuid()
    if own == 0:
        os.seteuid(65534)
    try:
        yield
    finally:
        if own == 0:
            os.seteuid(0)


def command(patch, capsys, *words):
    """Exit code and stderr, on one line, of `taichi-silo`; no traceback."""
    capsys.readouterr()
    patch.setattr(sys, "argv", ["taichi-silo", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        app.main()
    err = " ".join(capsys.readouterr().err.split())
    assert "Traceback" not in err
    return ended.value.code, err[err.rfind("Error: ") :]

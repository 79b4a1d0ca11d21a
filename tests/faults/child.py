"""A run in a process of its own, begun or gone on with, that dies where it is told (see `harness.child`).

`dies` is [what, count, delay]: at the count-th write of a file whose name holds `what` (of a row of a table, within
it), or, if it is "time", at once; and so many seconds later.
"""

import json
import os
import signal
import sys
import threading
import time
from pathlib import Path

from taichi_silo import Scene
from taichi_silo.cli.command_line import command
from taichi_silo.runs import session
from taichi_silo.runs.observers import checkpoint, forces
from taichi_silo.show.film import movie

given = json.loads(sys.argv.pop(1))
folder = Path(given["folder"])
what, count, delay = given.get("dies", ["", 0, 0.0])
movie.FILLING_FRAMES, movie.FLOW_FRAMES = 10, 30
written, write = 0, forces.Table._write


def die() -> None:
    time.sleep(delay)
    os.kill(os.getpid(), signal.SIGKILL)


def counted(file: str) -> bool:
    global written
    written += str(folder) in file and what in file[len(str(folder)) :]
    return written == count


def hook(event: str, words: tuple) -> None:
    """Before each change of a file."""
    file = str(words[0]) if words else ""
    changes = event in ("os.rename", "os.remove", "os.truncate", "shutil.copyfile")
    changes |= event == "open" and ((words[2] or 0) & (os.O_WRONLY | os.O_RDWR)) != 0
    if changes and counted(file):
        threading.Thread(target=die).start() if delay else die()


def torn(self, cells) -> None:
    if counted(str(self.file)):
        self.stream.write(b"0.0123,filling,0.0")
        die()
    write(self, cells)


def go() -> None:
    if checkpoint.is_there(folder):
        session.resume(folder)
    else:
        scene = Scene.model_validate(given["scene"])
        session.run(scene, folder, overwrite=True, film=given.get("film", False))


if not given.get("figures", False):
    session._Session._draw = lambda self: None
if what == "time":
    threading.Thread(target=die, daemon=True).start()
elif what.endswith(".csv") and count > 1:
    forces.Table._write = torn
elif what:
    sys.addaudithook(hook)
command(go)

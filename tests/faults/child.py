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

from taichi_silo import Scene, api
from taichi_silo.cli.command_line import command
from taichi_silo.runs.observers import checkpoint, film_recorder
from taichi_silo.show.run_end import draw_film
from taichi_silo.utils.appended_file import AppendedFile

given = json.loads(sys.argv.pop(1))
folder = Path(given["folder"])
what, count, delay = given.get("dies", ["", 0, 0.0])
film_recorder.FRAMES.update(filling=10, flow=30)
APPENDED = ("forces.csv", "balance.csv", "film_states.bin")
written, append = 0, AppendedFile.append


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


def torn(self, piece: bytes) -> None:
    if counted(str(self.file)):
        append(self, piece[: len(piece) // 2])
        die()
    append(self, piece)


def go() -> None:
    if checkpoint.is_there(folder):
        api.resume(folder, progress=False)
    else:
        scene = Scene.model_validate(given["scene"])
        api.run(scene, folder, overwrite=True, film=given.get("film", False), progress=False)


if not given.get("figures", False):
    api.DRAWING = (draw_film,)
if what == "time":
    threading.Thread(target=die, daemon=True).start()
elif what in APPENDED and count > 1:
    AppendedFile.append = torn
elif what:
    sys.addaudithook(hook)
command(go)

"""What tests of bad input share: how a refusal must look, what lies in a folder, and files that are none."""

import copy
import math
import os
import re
import resource
import socket
import time

from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.utils.messages import LONGEST
from taichi_silo.utils.schema import one_sentence
from tests.faults.harness import command

JARGON = re.compile(
    r"Value error|instance of|Input |dictionary|\btuple|pydantic|validat|<object|Traceback|Error: .*Error|codec"
)
SECONDS, ROOM_KB = 5.0, 1 << 20


def refusal(make):
    """The sentence with which something is refused, in seconds and without much memory; None if it is not."""
    begun, room = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        make()
    except BadInput as error:
        words = str(error)
    except ValidationError as error:
        words = one_sentence(error)
    else:
        words = None
    assert time.process_time() - begun < SECONDS
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - room < ROOM_KB
    if words is not None:
        assert 0 < len(words) <= LONGEST and words.isprintable() and not JARGON.search(words), words
    return words


def refused(monkeypatch, capsys, *words):
    """The one sentence on stderr."""
    begun = time.process_time()
    code, err = command(monkeypatch, capsys, *words)
    assert time.process_time() - begun < 2 * SECONDS
    assert code == 2, err
    assert err.startswith("Error: ") and err.count("\n") == 1 and len(err) < LONGEST + 10, err
    assert not JARGON.search(err), err
    return err


def no_file(place):
    pass


def folder(place):
    place.mkdir()


def pipe(place):
    os.mkfifo(place)


def plug(place):
    with socket.socket(socket.AF_UNIX) as found:
        here = os.getcwd()
        os.chdir(place.parent)  # names of sockets are short
        found.bind(place.name)
        os.chdir(here)


def zeros(place):
    place.symlink_to("/dev/zero")


def broken_link(place):
    place.symlink_to(place.parent / "gone")


def circle(place):
    place.symlink_to(place)


def large(place):
    with open(place, "wb") as stream:
        stream.truncate(100_000_000)


def holding(content):
    return lambda place: place.write_bytes(content)


def turned(corners, about=(0.1, 0.2), size=0.04):
    return [[about[0] + size * x, about[1] + size * y] for x, y in corners]


SQUARE = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
CIRCLE = [(math.cos(0.002 * math.pi * k), math.sin(0.002 * math.pi * k)) for k in range(1000)]


def changed(tables: dict, changes: dict) -> dict:
    """A copy of a scene's tables with values at dotted paths, whose tables are made where they are not there."""
    found = copy.deepcopy(tables)
    for path, value in changes.items():
        *names, last = path.split(".")
        table = found
        for name in names:
            table = table.setdefault(name, {})
        table[last] = value
    return found

"""Files of every kind that are not what they should be: refused in one short sentence, soon, and nothing is written."""

import ast
import io
import json
import os
import re
import resource
import shutil
import socket
import sys
import time
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from taichi_silo import Flow, Machine, Mesh, Method, Result, Scene, Silo, app, archive, one_run, sands, snapshot
from taichi_silo.compare.measured import read as read_measured
from taichi_silo.drawing import read_silo
from taichi_silo.faults import BadInput
from taichi_silo.observers.checkpoint import NAME, PREVIOUS
from taichi_silo.observers.segments import Segments
from taichi_silo.one_run import resume, run
from taichi_silo.quoting import LONGEST
from taichi_silo.scene_file import read_scene
from taichi_silo.sweep.file import read as read_sweep

PACKAGE = Path(__file__).parents[2] / "taichi_silo"
JARGON = re.compile(r"Value error|instance of|Input |pydantic|<object|Traceback|Error: .*Error|codec|NoneType")
SECONDS, ROOM_KB = 5.0, 1 << 20
SCENE = Scene(
    silo=Silo(height_m=0.4), grid=Mesh(cell_size_m=0.05), flow=Flow(speed_m_per_s=0.02, displacement_m=0.004),
    method=Method(filling_time_s=0.1, longest_settling_s=0.0), machine=Machine(threads=1, lanes=False),
)  # fmt: skip


def refusal(make):
    """The sentence with which something is refused, in seconds and without much memory; None if it is not."""
    begun, room = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        make()
    except BadInput as error:
        words = str(error)
    else:
        words = None
    assert time.monotonic() - begun < SECONDS
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - room < ROOM_KB
    if words is not None:
        assert 0 < len(words) <= LONGEST and words.isprintable() and not JARGON.search(words), words
    return words


def contents(folder):
    """What there is below a folder, links not followed."""
    return {
        str(file.relative_to(folder)): os.readlink(file) if file.is_symlink() else file.read_bytes()
        for file in folder.rglob("*") if file.is_symlink() or file.is_file()
    }  # fmt: skip


def command(monkeypatch, capsys, *words):
    """Exit code and stderr of the program."""
    monkeypatch.setattr(sys, "argv", ["taichi-silo", *map(str, words)])
    begun = time.monotonic()
    with pytest.raises(SystemExit) as ended:
        app.main()
    assert time.monotonic() - begun < 2 * SECONDS
    return ended.value.code, capsys.readouterr().err


def refused(monkeypatch, capsys, *words):
    """The one sentence on stderr."""
    code, err = command(monkeypatch, capsys, *words)
    assert code == 2, err
    assert err.startswith("Error: ") and err.count("\n") == 1 and len(err) < LONGEST + 10, err
    assert "Traceback" not in err and not JARGON.search(err), err
    return err


# --- what every reader refuses ----------------------------------------------------------------------------------------

READERS = {
    "a scene": (read_scene, ".toml"),
    "a sweep": (read_sweep, ".toml"),
    "a sand": (lambda file: sands.sand(file, 0.6), ".toml"),
    "a drawing": (read_silo, ".dxf"),
    "a table of measurements": (read_measured, ".csv"),
    "a snapshot": (snapshot.read, ".vtu"),
}


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


RNG = np.random.default_rng(5)
KINDS = {
    "nothing": no_file, "a folder": folder, "a pipe": pipe, "a socket": plug, "a device": zeros,
    "a link to nothing": broken_link, "a link to itself": circle, "100 MB": large,
    "noise": holding(RNG.bytes(10_000)), "NUL bytes": holding(b"\0" * 1000), "a picture": holding(b"\x89PNG\r\n\x1a\n" * 9),
    "UTF-16": holding("[flow]\nspeed_m_per_s = 1\n".encode("utf-16")), "one bad byte": holding(b"[flow]\nspeed = '\xff'\n"),
    "a page": holding(b"<!DOCTYPE html><html><body>404</body></html>"),
    "entities": holding(b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "b"><!ENTITY c "&b;&b;&b;&b;">]><VTKFile>&c;</VTKFile>'),
    "a long line": holding(b"a" * 900_000), "brackets": holding(b"x = " + b"[" * 100_000),
    "a pickle": holding(b"\x80\x04\x95\x17\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x94\x8c\x06system\x94\x93\x94."),
}  # fmt: skip


@pytest.mark.skipif(os.name == "nt", reason="pipes, devices and links of Unix")
@pytest.mark.parametrize("reader", READERS)
def test_what_cannot_be_read_is_refused(reader, tmp_path, tried):
    read, suffix = READERS[reader]
    for number, (kind, make) in enumerate(KINDS.items()):
        file = tmp_path / f"{number}{suffix}"
        make(file)
        words = refusal(lambda file=file: read(file))
        assert words is not None and str(file) in words, kind
    tried("inputs refused", f"a file that is not {reader}", len(KINDS))


# --- scenes -----------------------------------------------------------------------------------------------------------

TOML = {
    "brackets in brackets": "x = " + "[" * 100_000 + "]" * 100_000,
    "tables in tables": "x = " + "{a=" * 50_000 + "1" + "}" * 50_000,
    "a name of many parts": ".".join("a" * 200_000) + " = 1",
    "a table's name of many parts": "[" + ".".join("a" * 200_000) + "]\nx = 1",
    "a quoted name of many parts": ".".join(['"a"'] * 100_000) + " = 1",
    "many tables": "".join(f"[a{k}]\n" for k in range(100_000)),
    "many values": "".join(f"a{k} = 1\n" for k in range(80_000)),
    "many inserts": "[[silo.inserts]]\n" * 50_000,
    "a million digits": "flow.speed_m_per_s = " + "1" * 900_000,
    "a million hexadecimal digits": "flow.speed_m_per_s = 0x" + "f" * 900_000,
    "a million decimals": "flow.speed_m_per_s = 5." + "1" * 900_000,
    "an exponent": "flow.speed_m_per_s = 1e999999999",
    "a long text": 'walls.kind = "' + "a" * 900_000 + '"',
    "a long name": "a" * 900_000 + " = 1",
    "a table twice": "[flow]\n[flow]\n",
    "a value twice": "[flow]\nspeed_m_per_s = 1\nspeed_m_per_s = 2\n",
    "a value that is a table": "flow = 3",
    "tables that are a value": "[[flow]]\n",
    "a machine that is a word": 'machine = "fast"',
    "sand that is a list": "sand = [1, 2]",
    "sand with a list as its name": "[sand]\nname = [1]\n",
    "sand with a table as its name": "[sand.name]\nx = 1\n",
    "sand with a number as its name": "[sand]\nname = 0x" + "f" * 5000,
    "no end": "[flow\n",
    "no value": "[flow]\nspeed_m_per_s =\n",
    "JSON": '{"flow": {"speed_m_per_s": 1}}',
    "YAML": "flow:\n  speed_m_per_s: 1\n",
    "a date": "flow.speed_m_per_s = 2020-01-01",
    "a time": "silo.width_m = 12:00:00",
    "a corner too many": "silo.outline_m = [" + "[0.0, 0.1]," * 60_000 + "]",
}


@pytest.mark.parametrize("kind", TOML)
def test_a_scene_file_that_is_a_trap_is_refused(kind, tmp_path, tried):
    file = tmp_path / "scene.toml"
    file.write_text(TOML[kind])
    assert refusal(lambda: read_scene(file, threads=1)) is not None
    assert refusal(lambda: read_sweep(file)) is not None
    assert list(tmp_path.iterdir()) == [file]
    tried("inputs refused", "a scene or sweep file that is a trap", 2)


def test_a_scene_with_a_byte_order_mark_or_windows_line_ends_is_read(tmp_path):
    (tmp_path / "scene.toml").write_bytes("\ufeff[flow]\r\nspeed_m_per_s = 0.005\r\n".encode())
    assert read_scene(tmp_path / "scene.toml").flow.speed_m_per_s == 0.005


SET = [
    "", "=", "x", "flow", "flow=", "flow=1", ".=1", "flow.=1", ".flow=1", "flow..speed_m_per_s=1", "flow.speed=1",
    "flow.speed_m_per_s=", "flow.speed_m_per_s=fast", "flow.speed_m_per_s=-1", "flow.speed_m_per_s=nan", "silo.²=1",
    "flow.speed_m_per_s=[1]", "flow.speed_m_per_s={a=1}", "flow.speed_m_per_s=true", "flow.speed_m_per_s.x=1",
    "silo.outline_m.0.1=3", "silo.outline_m.0=3", "silo.outline_m=3", "silo.outline_m=[[0,0]]", "silo.inserts.0=3",
    "silo.inserts.0.width_m=1", "silo.inserts=[1]", "silo.inserts=[{}]", "silo.inserts.²=1", "silo.inserts.-1.width_m=1",
    "silo.inserts.99999999999999999999.width_m=1", f"{'1' * 5000}=1", f"flow.speed_m_per_s={'1' * 5000}",
    f"flow.speed_m_per_s={'[' * 5000}", f"{'a.' * 1000}a=1", f"{'a' * 1_000_000}=1", "flow.speed_m_per_s=1\n[sand]",
    "sand.name=../../x", "sand.name=\x1b[31mred", "walls.kind=\u202eevil", "machine=1", "machine.threads=0",
    "machine.threads=1.5", "grid.points_per_cell=0x" + "f" * 5000, "__class__=1", "silo.__init__=1", "sand=1", "sand.name=[]",
]  # fmt: skip


def test_a_change_of_a_scene_that_makes_no_sense_is_refused(tmp_path, tried):
    file = tmp_path / "scene.toml"
    file.write_text("silo.outline_m = [[0, 0], [0.2, 0], [0.2, 0.5], [0, 0.5]]\n")
    for change in SET:
        assert refusal(lambda change=change: read_scene(file, [change])) is not None, change[:80]
    tried("inputs refused", "a --set that makes no sense", len(SET))


def test_random_text_is_no_scene_and_no_change_of_one(tmp_path_factory, tried):
    file, count = tmp_path_factory.mktemp("scenes") / "scene.toml", 0

    @settings(max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
    @given(st.binary(max_size=60) | st.text(alphabet='[]{}=.,"\'#\n\\abx01 ', max_size=60).map(str.encode),
           st.text(max_size=20))  # fmt: skip
    def attempt(data, text):
        nonlocal count
        file.write_bytes(data)
        count += refusal(lambda: read_scene(file)) is not None
        file.write_text("")
        count += refusal(lambda: read_scene(file, [text])) is not None
        count += refusal(lambda: read_scene(file, [f"flow.speed_m_per_s={text}"])) is not None

    attempt()
    assert count > 200
    tried("inputs refused", "random text as a scene or a change of one", count)


SWEEPS = [
    "grid = 3", "latin_hypercube = []", "response = 'x'", "cluster = 1", "[cluster]\nkind = []", "[cluster]\nkind = 'pbs'",
    "scene = 3", "scene = [3]", "scene = ''", "scene = '\\u0000'", "scene = ['none.toml']", "[grid]", "[grid]\nx = 1",
    "[grid]\n'flow.speed_m_per_s' = 1", "[grid]\n'flow.speed_m_per_s' = []", "[grid]\n'flow.speed_m_per_s' = [[]]",
    "[grid]\n'flow.speed_m_per_s' = [nan]", "[grid]\n'flow.speed_m_per_s' = [true]", "[grid]\nsand = [3, []]",
    f"[grid]\n'flow.speed_m_per_s' = [0x{'f' * 5000}]", f"[grid]\nsand = [0x{'f' * 5000}]", "[grid]\nsand = ['../x.toml']",
    f"[grid]\n'flow.speed_m_per_s' = {[0.001 + 1e-7 * k for k in range(20_000)]}",
    f"[grid]\n'flow.speed_m_per_s' = {[0.001 + 1e-5 * k for k in range(200)]}\n'sand.n' = {[0.3 + 1e-4 * k for k in range(200)]}",
    "[grid]\n'silo.inserts.0' = [1]", "[grid]\n'silo.inserts.99999.width_m' = [1]", "[grid]\n'silo.inserts.²' = [1]",
    "[latin_hypercube]\nruns = 1000000000\nbetween.'flow.speed_m_per_s' = [0.001, 0.002]",
    "[latin_hypercube]\nruns = 2\nbetween.'flow.speed_m_per_s' = [0.002, 0.001]",
    "[latin_hypercube]\nruns = 2\nbetween.'flow.speed_m_per_s' = [-inf, inf]",
    "[latin_hypercube]\nruns = 2\nbetween.'flow.speed_m_per_s' = {low = 0.001, high = 0.002, step = 0}",
    "[latin_hypercube]\nruns = 2\nbetween.'flow.speed_m_per_s' = {low = 0.001, high = 0.002, step = nan}",
    "[latin_hypercube]\nruns = 2\nbetween.'walls.kind' = {choices = []}", "[latin_hypercube]\nruns = 2\nbetween = 3",
    "[latin_hypercube]\nruns = 2\nseed = -1\nbetween.'flow.speed_m_per_s' = [0.001, 0.002]", "retries = 1e9\n[grid]\n",
    "fidelity = 'none'\n[grid]\n'walls.kind' = ['smooth']", "film = 'perhaps'", "nonsense = 1", "[response]\ny = 3",
    "[grid]\n'walls.kind' = ['smooth', 'smooth']", "[grid]\n'machine.threads' = [1, 2]", "[grid]\n'sand.name' = ['a', 'b']",
]  # fmt: skip


def test_a_sweep_that_makes_no_sense_is_refused(tmp_path, tried):
    file = tmp_path / "sweep.toml"
    for text in SWEEPS:
        file.write_text(text, encoding="utf-8")
        assert refusal(lambda: read_sweep(file).scenes()) is not None, text[:200]
    assert list(tmp_path.iterdir()) == [file]
    tried("inputs refused", "a sweep that makes no sense", len(SWEEPS))


def test_runs_of_a_sweep_never_leave_its_folder(tmp_path):
    for name in ("...toml", ".hidden.toml", "a b.toml", "-x.toml"):
        (tmp_path / name).write_text("")
    names = [tmp_path / name for name in ("...toml", ".hidden.toml", "a b.toml", "-x.toml")]
    file = tmp_path / "sweep.toml"
    values = ["../../x", "/etc", "..", ".", "a\\\\b", "\\u0007", "C:x"]
    file.write_text(f"scene = {json.dumps([str(one) for one in names])}\n[grid]\n'walls.kind' = ['smooth']\n")
    found = read_sweep(file).scenes()
    assert len(found) == 4
    for name in found:
        assert Path(name).name == name and name not in (".", "..") and name.isprintable() and not name.startswith(".")
    for value in values:
        file.write_text(f"[grid]\n'walls.kind' = [\"{value}\", 'smooth']\n")
        assert refusal(lambda: read_sweep(file).scenes()) is not None


SANDS = ["x = 1", "n = 0.5", "", "[sand]\nn = 1", "name = []"]


def test_a_sand_that_is_none_is_refused(tmp_path, tried):
    file, whole = tmp_path / "mine.toml", dict(sands.published()["karlsruhe"])
    texts = list(SANDS)
    for name in whole:
        if name not in sands.NOTES:
            texts += ["".join(f"{key} = {value if key != name else one}\n" for key, value in whole.items()
                              if key not in sands.NOTES) for one in ("nan", "-1", "[]", "true", "0x" + "f" * 5000, "'x'")]  # fmt: skip
    for text in texts:
        file.write_text(text)
        assert refusal(lambda: sands.sand(file, 0.6)) is not None, text[:300]
    names = ["", "../karlsruhe", "a" * 1_000_000, "\x00", "karlsruh", "/etc/passwd", 3, None, 16**6000]
    for name in names:
        assert refusal(lambda name=name: sands.sand(name, 0.6)) is not None
    tried("inputs refused", "a sand that is none", len(texts) + len(names))


# --- measurements and drawings ----------------------------------------------------------------------------------------

HEAD = b"displacement_mm,P_kN_per_m\n"
TABLES = {
    "nothing": b"", "blank lines": b"\n\n\n", "remarks only": b"# a\n# b\n", "no rows": HEAD, "no head": b"1,2\n3,4\n",
    "a wrong column": b"displacement_mm,force\n1,2\n", "one column": b"displacement_mm\n1\n", "a column twice": HEAD.replace(b"\n", b",P_N_per_m\n") + b"1,2,3\n",
    "words": HEAD + b"a,b\n", "a word": HEAD + b"1,2\n3,four\n", "nan": HEAD + b"1,nan\n", "inf": HEAD + b"1,inf\n", "1e999": HEAD + b"1,1e999\n",
    "too few": HEAD + b"1\n", "too many": HEAD + b"1,2,3\n", "no place": HEAD + b",2\n", "quotes": HEAD + b'1,"2\n3"\n',
    "an open quote": HEAD + b'1,"2\n3,4\n' * 50, "UTF-16": (HEAD + b"1,2\n").decode().encode("utf-16"), "UTF-32": (HEAD + b"1,2\n").decode().encode("utf-32"),
    "NUL": HEAD + b"1,\x002\n", "a million columns": b",".join([b"P_kN_per_m"] * 80_000) + b"\n1,2\n", "a million words": b"displacement_mm,x\n" + b"1," + b"a" * 900_000,
    "a spreadsheet": b"PK\x03\x04" + RNG.bytes(500), "binary": RNG.bytes(1000), "JSON": b'{"a": [1, 2]}', "a page": b"<html><body>1,2</body></html>",
    "a field of 200 kB": HEAD + b'1,"' + b"2" * 200_000 + b'"\n', "other separators": b"displacement_mm|P_kN_per_m\n1|2\n", "mixed": b"displacement_mm,normal_stress_Pa\n1,2\n",
    "a control sign": b"displacement_mm,\x1b[31mP\n1,2\n", "right to left": "displacement_mm,\u202eP\n1,2\n".encode(),
}  # fmt: skip


def test_measurements_that_are_none_are_refused(tmp_path, tried):
    file = tmp_path / "measured.csv"
    for kind, data in TABLES.items():
        file.write_bytes(data)
        assert refusal(lambda: read_measured(file)) is not None, kind
    tried("inputs refused", "a table of measurements that is none", len(TABLES))


def test_measurements_with_a_byte_order_mark_are_read(tmp_path):
    (tmp_path / "measured.csv").write_bytes(b"\xef\xbb\xbf" + HEAD + b"1,2\n")
    assert read_measured(tmp_path / "measured.csv").table.P.tolist() == [2000.0]


def line(*places, closed=True):
    def draw(space):
        space.add_lwpolyline(places, close=closed)

    return draw


BOX = line((0, 0), (200, 0), (200, 500), (0, 500))
DRAWINGS = {
    "nothing": (),
    "an open line": (line((0, 0), (1, 0), (1, 1), closed=False),),
    "a line that crosses itself": (line((0, 0), (200, 500), (200, 0), (0, 500)),),
    "a point": (line((0, 0), (0, 0), (0, 0)),),
    "two corners": (line((0, 0), (200, 0)),),
    "no floor": (line((100, 0), (200, 500), (0, 500)),),
    "a place that is none": (line((0, 0), (float("nan"), 0), (200, 500)),),
    "no end": (line((0, 0), (float("inf"), 0), (200, 500)),),
    "larger than the earth": (line((0, 0), (1e12, 0), (1e12, 1e12), (0, 1e12)),),
    "too many corners": (line(*[(np.cos(k / 400), np.sin(k / 400)) for k in range(2500)]),),
    "a circle without size": (lambda space: space.add_circle((0, 0), 0),),
    "a circle without end": (lambda space: space.add_circle((0, 0), float("inf")),),
    "a circle that is none": (lambda space: space.add_circle((0, 0), float("nan")),),
    "a very large circle": (lambda space: space.add_circle((0, 0), 1e12),),
    "a body outside": (BOX, line((900, 0), (950, 0), (950, 50), (900, 50))),
    "a body in a wall": (BOX, line((-20, 100), (50, 100), (50, 150), (-20, 150))),
    "bodies in one place": (BOX, *[lambda space: space.add_circle((100, 200), 30)] * 2),
    "too many bodies": (BOX, *[lambda space: space.add_circle((100, 200), 1)] * 60),
    "words": (lambda space: space.add_text("a silo"),),
}


def test_drawings_that_are_no_silo_are_refused(tmp_path, tried, monkeypatch, capsys):
    ezdxf = pytest.importorskip("ezdxf")
    file = tmp_path / "silo.dxf"
    for kind, marks in DRAWINGS.items():
        drawing = ezdxf.new(units=4)
        for mark in marks:
            mark(drawing.modelspace())
        drawing.saveas(file)
        monkeypatch.chdir(tmp_path)
        assert refused(monkeypatch, capsys, "drawing", file, "--output", "out.toml"), kind
    whole = file.read_bytes()
    for cut in (0, 10, 100, 1000, len(whole) // 2, len(whole) - 10):
        file.write_bytes(whole[:cut])
        assert refused(monkeypatch, capsys, "drawing", file, "--output", "out.toml"), cut
    assert not (tmp_path / "out.toml").exists()
    tried("inputs refused", "a drawing that is no silo", len(DRAWINGS) + 6)


# --- checkpoints ------------------------------------------------------------------------------------------------------

TREE = {"clock": {"time": 0.1}, "points": {"position": np.zeros((50, 2)), "mass": np.ones(50)}}


def npy(values="<f8", shape=(3,), data=b"\0" * 24):
    """A member in numpy's form, which may say more than it holds."""
    header = repr({"descr": values, "fortran_order": False, "shape": shape}).encode()
    header += b" " * (64 - (len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + data


def zipped(members, packed=False):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED) as file:
        for name, data in members.items():
            file.writestr(name, data)
    return stream.getvalue()


def words(text):
    stream = io.BytesIO()
    np.save(stream, np.array(text))
    return stream.getvalue()


def crafted(tree):
    """A checkpoint with a valid checksum."""
    file = io.BytesIO()
    arrays = {}
    content = json.dumps(archive._without_arrays(tree, "", arrays), default=lambda value: value.item())
    header = {"format": archive.FORMAT, "taichi_silo": "0", "sha256": archive._checksum(content, arrays)}
    np.savez(file, header=json.dumps(header), content=content, **arrays)
    return file.getvalue()


GOOD = {"header.npy": words(json.dumps({"format": archive.FORMAT, "sha256": ""})), "content.npy": words("{}")}
ARCHIVES = {
    "nothing": b"", "noise": RNG.bytes(5000), "a zip": zipped({"a.txt": b"hello"}), "an empty zip": zipped({}),
    "another program's": zipped({"arr_0.npy": words("a")}), "text": b"checkpoint", "a pickle": b"\x80\x04N.",
    "packed zeros": zipped({**GOOD, "x.npy": b"\0" * 300_000_000}, packed=True),
    "more than there is": zipped({**GOOD, "x.npy": npy(shape=(10**12,))}),
    "a word of 10^12 letters": zipped({**GOOD, "x.npy": npy("<U1000000000", ())}),
    "a negative size": zipped({**GOOD, "x.npy": npy(shape=(-3,))}), "more than counts": zipped({**GOOD, "x.npy": npy(shape=(2**62, 4))}),
    "an object": zipped({**GOOD, "x.npy": npy("|O", (1,), b"\x80\x04N.")}), "a form of its own": zipped({**GOOD, "x.npy": npy([("a", "|O")], (1,))}),
    "code for a shape": zipped({**GOOD, "x.npy": npy(shape=(3,)).replace(b"(3,)", b"f(3)")}),
    "a header that is none": zipped({"header.npy": words("[1, 2"), "content.npy": words("{}")}),
    "a header that is a number": zipped({"header.npy": words("3"), "content.npy": words("{}")}),
    "a deep header": zipped({"header.npy": words("[" * 100_000), "content.npy": words("{}")}),
    "a deep content": crafted({"x": 1}).replace(b"x", b"["), "no content": zipped({"header.npy": GOOD["header.npy"]}),
    "names that lead nowhere": crafted({"a": {"b": np.zeros(2)}}).replace(b"a/b.npy", b"c/d.npy"),
}  # fmt: skip


def test_foreign_and_crafted_checkpoints_are_damaged_and_run_no_code(tmp_path, tried):
    file = tmp_path / NAME
    for kind, data in ARCHIVES.items():
        file.write_bytes(data)
        begun, room = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with pytest.raises((archive.Damaged, BadInput)):
            archive.read(file)
        assert time.monotonic() - begun < SECONDS, kind
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - room < ROOM_KB, kind
        words = refusal(lambda: resume(tmp_path))
        assert words is not None, kind
        assert [one.name for one in tmp_path.iterdir()] == [NAME], kind
    tried("inputs refused", "a checkpoint that is none", len(ARCHIVES))


@pytest.mark.skipif(os.name == "nt", reason="pipes, devices and links of Unix")
def test_a_checkpoint_that_is_no_file_is_refused(tmp_path, tried):
    for kind, make in (("a folder", folder), ("a pipe", pipe), ("a device", zeros), ("a link to nothing", broken_link)):
        place = tmp_path / kind
        place.mkdir()
        make(place / NAME)
        assert refusal(lambda place=place: resume(place)) is not None, kind
    tried("inputs refused", "a checkpoint that is none", 4)


@pytest.fixture(scope="module")
def bare():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(one_run._Session, "_draw", lambda self: None)
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory, bare):
    """The folder of a run, without figures."""
    return run(SCENE, tmp_path_factory.mktemp("runs") / "whole", film=False)


@pytest.fixture
def left(whole, tmp_path):
    """A copy of it, in which it is not finished."""
    place = Path(shutil.copytree(whole, tmp_path / "left"))
    made = place / "run.toml"
    made.write_text(made.read_text().replace("finished = true", "finished = false"))
    return place


def test_a_checkpoint_of_another_run_is_refused(left, tried):
    header, kept = archive.read(left / NAME)
    kept["scene"]["flow"]["displacement_m"] = 0.01
    (left / NAME).write_bytes(crafted(kept))
    before = contents(left)
    assert "checkpoint is of another run, with flow.displacement_m = 0.01 instead of 0.004" in refusal(
        lambda: resume(left)
    )
    assert contents(left) == before
    tried("inputs refused", "a checkpoint of another run")


SPOILS = {
    "no clock": lambda kept: kept["simulation"].pop("clock"),
    "no time": lambda kept: kept["simulation"]["clock"].pop("time"),
    "no scene": lambda kept: kept.pop("scene"),
    "a scene that is none": lambda kept: kept.update(scene=3),
    "a scene that is impossible": lambda kept: kept["scene"]["silo"].update(width_m=-1),
    "no simulation": lambda kept: kept.pop("simulation"),
    "no observers": lambda kept: kept.pop("observers"),
    "observers that are a list": lambda kept: kept.update(observers=[]),
    "no run": lambda kept: kept.pop("run"),
}


@pytest.mark.parametrize("kind", SPOILS)
def test_a_checkpoint_that_is_whole_but_holds_something_else_is_refused(kind, left, tried):
    header, kept = archive.read(left / NAME)
    SPOILS[kind](kept)
    for name in (NAME, PREVIOUS):
        (left / name).write_bytes(crafted(kept))
    before = contents(left)
    assert refusal(lambda: resume(left)) is not None
    assert contents(left) == before
    tried("inputs refused", "a checkpoint that holds something else")


def test_names_in_a_checkpoint_never_lead_out_of_its_folder(left, tmp_path, tried):
    (tmp_path / "precious.mp4").write_bytes(b"precious")
    (tmp_path / "precious.vtu").write_bytes(b"precious")
    names = ["../precious.mp4", str(tmp_path / "precious.mp4"), "..", ".", "", "precious.mp4", "run.toml"]
    film = Segments(left / "void_ratio.mp4", None)
    for name in names:
        before = contents(left)
        assert refusal(lambda name=name: film.go_on([name])) is not None, name
        assert contents(left) == before
    header, kept = archive.read(left / NAME)
    kept["observers"]["film"] = {"curves": np.zeros((0, 4)), "drawn": {}, "pieces": names[:1]}
    row = {"file": "../../precious.vtu", "stage": "x", "time_s": 0, "displacement_m": 0}
    kept["observers"]["snapshots"]["rows"] = [row]
    (left / NAME).write_bytes(crafted(kept))
    with pytest.raises(BadInput):
        resume(left)
    assert (tmp_path / "precious.mp4").read_bytes() == (tmp_path / "precious.vtu").read_bytes() == b"precious"
    assert sorted(one.name for one in tmp_path.iterdir()) == ["left", "precious.mp4", "precious.vtu"]
    assert (left / "run.toml").exists()
    tried("inputs refused", "a checkpoint whose names lead out of its folder", len(names))


# --- folders of runs --------------------------------------------------------------------------------------------------


def damage(name, content):
    def do(place):
        (place / name).write_bytes(content)

    return do


def without(name):
    return lambda place: shutil.rmtree(place / name) if (place / name).is_dir() else (place / name).unlink()


def cut(name):
    return lambda place: (place / name).write_bytes((place / name).read_bytes()[:-200])


def column(name, replace):
    return lambda place: (place / name).write_text((place / name).read_text().replace(*replace))


FORCES = b"time_s,stage,displacement_m,bottom_force_N_per_m,left_normal_N_per_m,left_shear_N_per_m,right_normal_N_per_m,right_shear_N_per_m,wall_friction_angle_deg,weight_N_per_m\n"
DAMAGES = {
    "run.toml is noise": damage("run.toml", RNG.bytes(500)), "run.toml is empty": damage("run.toml", b""),
    "run.toml is of something else": damage("run.toml", b"[tool]\nname = 'x'\n"), "run.toml is brackets": damage("run.toml", b"x = " + b"[" * 50_000),
    "run.toml has values for tables": damage("run.toml", b"silo = 1\nwalls = 2\nsand = 3\nflow = 4\nprogram = 5\n"),
    "run.toml has words for numbers": column("run.toml", ("void_ratio = 0.6", 'void_ratio = "dense"')),
    "run.toml has a silo of another kind": column("run.toml", ("width_m = 0.2", "width_m = -1")),
    "summary.json is noise": damage("summary.json", RNG.bytes(500)), "summary.json is a list": damage("summary.json", b"[1, 2]"),
    "summary.json is brackets": damage("summary.json", b"[" * 200_000), "summary.json has values for tables": damage("summary.json", b'{"finished": "x", "residual": 3, "peak": [], "filling": "y", "warnings": 4, "cost": [], "certificate": 1, "janssen": "k", "parts": 3}'),
    "summary.json has words for numbers": damage("summary.json", b'{"finished": true, "residual": {"bottom_N_per_m": "much"}, "certificate": {"mass": "x"}, "weight_N_per_m": "heavy"}'),
    "forces.csv is empty": damage("forces.csv", b""), "forces.csv has no rows": damage("forces.csv", FORCES), "forces.csv is noise": damage("forces.csv", RNG.bytes(3000)),
    "forces.csv has wrong columns": damage("forces.csv", b"a,b,c\n1,2,3\n"), "forces.csv has words": damage("forces.csv", FORCES + b"a,b,c,d,e,f,g,h,i,j\n" * 5),
    "forces.csv is ragged": damage("forces.csv", FORCES + b"1,flow\n1,flow,2,3,4,5,6,7,8,9,10,11,12\n" * 5), "forces.csv has a mark": damage("forces.csv", b"\xef\xbb\xbf" + FORCES),
    "forces.csv is UTF-16": damage("forces.csv", FORCES.decode().encode("utf-16")), "forces.csv has a million columns": damage("forces.csv", b"a," * 1_000_000 + b"\n" + b"1," * 1_000_000),
    "forces.csv has huge numbers": damage("forces.csv", FORCES + b"1e400,flow,1e308,1e308,-1e308,nan,inf,1e308,1e308,1e308\n" * 5), "forces.csv is cut off": cut("forces.csv"),
    "walls.csv is noise": damage("walls.csv", RNG.bytes(3000)), "walls.csv has words": damage("walls.csv", b"state,wall,height_m,normal_stress_Pa,shear_stress_Pa\nx,y,z,a,b\n"), "walls.csv is missing": without("walls.csv"),
    "index.csv is noise": damage("snapshots/index.csv", RNG.bytes(500)), "index.csv is empty": damage("snapshots/index.csv", b""),
    "index.csv has wrong columns": damage("snapshots/index.csv", b"a,b\n1,2\n"), "index.csv leads out": damage("snapshots/index.csv", b"file,stage,time_s,displacement_m\n../../../etc/passwd,flow,1,1\n/etc/passwd,filling,0,0\n"),
    "index.csv has words": damage("snapshots/index.csv", b"file,stage,time_s,displacement_m\nstart.vtu,filling,soon,none\n"),
    "a snapshot is empty": damage("snapshots/start.vtu", b""), "a snapshot is noise": damage("snapshots/start.vtu", RNG.bytes(3000)), "a snapshot is cut off": cut("snapshots/start.vtu"),
    "a snapshot is a page": damage("snapshots/start.vtu", b"<html></html>"), "snapshots are missing": without("snapshots"), "a snapshot is missing": without("snapshots/start.vtu"),
    "all is missing but run.toml": lambda place: [without(one.name)(place) for one in place.iterdir() if one.name != "run.toml"],
}  # fmt: skip


def commands(place, out):
    """Every command that is given the folder of a run, as it is, by one who writes elsewhere."""
    yield "report", place, "--output", out / "report.html"
    yield "render", place, "--frame", "1", "--size", "320x180", "--output", out / "picture.png"
    yield "export", place, "--output", out / "silo.vtkhdf"
    yield "export", place, "--format", "csv", "--output", out / "csv"
    yield "compare", place, "--janssen", "--paper", "--output", out / "compare"
    yield "gallery", place, "--output", out / "page"


DRAWN = ("forces.csv has words", "index.csv leads out")  # all damages are with `long`


@pytest.mark.parametrize("kind", DAMAGES)
def test_a_run_with_damaged_files_is_shown_or_refused_in_a_sentence(kind, whole, tmp_path, monkeypatch, capsys, tried):
    place, out = Path(shutil.copytree(whole, tmp_path / "run")), tmp_path / "out"
    if kind not in DRAWN:
        (place / "figures").mkdir()
        (place / "figures" / "void_ratio.png").write_bytes(b"")
    wanted = list(commands(place, out))
    DAMAGES[kind](place)
    every = kind in SHOWN_BY_ALL
    shown_or_refused(place, out, wanted if every else [wanted[0], wanted[3]], monkeypatch, capsys, tried)


@pytest.mark.long
@pytest.mark.parametrize("kind", DAMAGES)
def test_a_run_with_damaged_files_is_drawn_or_refused_in_a_sentence(kind, whole, tmp_path, monkeypatch, capsys, tried):
    place, out = Path(shutil.copytree(whole, tmp_path / "run")), tmp_path / "out"
    DAMAGES[kind](place)
    shown_or_refused(place, out, commands(place, out), monkeypatch, capsys, tried)


def shown_or_refused(place, out, chosen, monkeypatch, capsys, tried):
    count, chosen = 0, list(chosen)
    for command_words in chosen:
        shutil.rmtree(out, ignore_errors=True)
        code, err = command(monkeypatch, capsys, *command_words, "--quiet")
        assert "Traceback" not in err and code in (0, 2), (command_words, err)
        if code:
            assert (
                err.startswith("Error: ")
                and err.count("\n") == 1
                and len(err) < LONGEST + 10
                and not JARGON.search(err)
            ), err
            assert not list(out.rglob("*.*")), command_words
            count += 1
    words = refusal(
        lambda: [
            getattr(Result(place), name) for name in ("scene", "program", "summary", "forces", "walls", "snapshots")
        ]
    )
    tried("inputs refused", "a run with damaged files", count + (words is not None))
    tried("inputs run", "a command on a run with damaged files", len(chosen) - count)


SHOWN_BY_ALL = ("run.toml has values for tables", "summary.json has values for tables")


def test_a_folder_that_holds_no_run_is_refused_by_every_command(tmp_path, monkeypatch, capsys, tried):
    places, out, count = (
        {"none": no_file, "empty": folder, "file": holding(b"x"), "loop": circle, "x" * 300: no_file},
        tmp_path / "out",
        0,
    )
    for name, make in places.items():
        make(tmp_path / name)
        for command_words in (*commands(tmp_path / name, out), ("resume", tmp_path / name), ("run", tmp_path / name)):
            refused(monkeypatch, capsys, *command_words)
            count += 1
    assert not out.exists()
    tried("inputs refused", "a folder without a run", count)


def bomb(points=10, raw=20_000_000):
    """A snapshot whose array unpacks to far more than its points need."""
    import base64

    packed = zlib.compress(b"\0" * raw)
    data = base64.b64encode(np.array([1, raw, 0, len(packed)], np.uint32).tobytes()) + base64.b64encode(packed)
    array = b'<DataArray type="Float64" Name="%s" NumberOfComponents="3" format="binary">' + data + b"</DataArray>"
    body = b"<Points>" + array % b"Points" + b"</Points><PointData>" + array % b"velocity" + b"</PointData>"
    return (b'<VTKFile><UnstructuredGrid><Piece NumberOfPoints="%d" NumberOfCells="%d">' % (points, points) + body
            + b"</Piece></UnstructuredGrid></VTKFile>")  # fmt: skip


def test_a_snapshot_that_unpacks_without_end_is_refused(tmp_path, tried):
    file = tmp_path / "start.vtu"
    for points in (10, -1, 10**12, 10**30):
        file.write_bytes(bomb(points))
        assert "damaged" in refusal(lambda: snapshot.read(file))
    tried("inputs refused", "a snapshot that unpacks without end", 4)


# --- no file runs code ------------------------------------------------------------------------------------------------

FORBIDDEN = {"pickle", "cPickle", "dill", "cloudpickle", "joblib", "marshal", "shelve", "yaml"}


def test_nothing_in_the_package_unpickles_or_evaluates_what_it_reads():
    """Scenarios of the package itself are compiled by `run`, by their names; a worker of dask is of our own making."""
    found = []
    for file in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
            found += [f"{file.name}: {name}" for name in names if name.split(".")[0] in FORBIDDEN]
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func)
                allow = any(word.arg == "allow_pickle" and ast.unparse(word.value) != "False" for word in node.keywords)
                if called in ("eval", "exec", "pd.read_pickle", "ElementTree.XMLParser") or allow:
                    found.append(f"{file.name}: {called}")
    assert found == ["run.py: exec"]

"""Files of every kind that are not what they should be: refused in one short sentence, soon, and nothing is written."""

import ast
import itertools
import json
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from taichi_silo.runs import snapshot
from taichi_silo.scene import sands
from taichi_silo.scene.dxf import read_silo
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.studies.compare.measured import read as read_measured
from taichi_silo.studies.sweep.plan import read as read_sweep
from tests.faults.bad import broken_link, circle, folder, holding, large, no_file, pipe, plug, refusal, zeros

PACKAGE = Path(__file__).parents[2] / "taichi_silo"


# --- what every reader refuses ----------------------------------------------------------------------------------------

READERS = {
    "a scene": (read_scene, ".toml"),
    "a sweep": (read_sweep, ".toml"),
    "a sand": (lambda file: sands.sand(file, 0.6), ".toml"),
    "a drawing": (read_silo, ".dxf"),
    "a table of measurements": (read_measured, ".csv"),
    "a snapshot": (snapshot.read, ".vtu"),
}


RNG = np.random.default_rng(5)
KINDS = {
    "nothing": no_file,
    "a folder": folder,
    "a pipe": pipe,
    "a socket": plug,
    "a device": zeros,
    "a link to nothing": broken_link,
    "a link to itself": circle,
    "100 MB": large,
    "noise": holding(RNG.bytes(10_000)),
    "NUL bytes": holding(b"\0" * 1000),
    "a picture": holding(b"\x89PNG\r\n\x1a\n" * 9),
    "UTF-16": holding("[flow]\nspeed_m_per_s = 1\n".encode("utf-16")),
    "one bad byte": holding(b"[flow]\nspeed = '\xff'\n"),
    "a page": holding(b"<!DOCTYPE html><html><body>404</body></html>"),
    "entities": holding(
        b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "b"><!ENTITY c "&b;&b;&b;&b;">]><VTKFile>&c;</VTKFile>'
    ),
    "a long line": holding(b"a" * 900_000),
    "brackets": holding(b"x = " + b"[" * 100_000),
    "a pickle": holding(b"\x80\x04\x95\x17\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x94\x8c\x06system\x94\x93\x94."),
}


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
    "many tables": "".join(f"[a{k}]\n" for k in range(40_000)),
    "many values": "".join(f"a{k} = 1\n" for k in range(40_000)),
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
    "silo.inserts.0.width_m=1", "silo.inserts=[1]", "silo.inserts=[{}]", "silo.inserts.²=1",
    "silo.inserts.-1.width_m=1", "silo.inserts.99999999999999999999.width_m=1", f"{'1' * 5000}=1",
    f"flow.speed_m_per_s={'1' * 5000}", f"flow.speed_m_per_s={'[' * 5000}", f"{'a.' * 1000}a=1",
    f"{'a' * 1_000_000}=1", "flow.speed_m_per_s=1\n[sand]", "sand.name=../../x", "sand.name=\x1b[31mred",
    "walls.kind=\u202eevil", "machine=1", "machine.threads=0", "machine.threads=1.5",
    "grid.points_per_cell=0x" + "f" * 5000, "__class__=1", "silo.__init__=1", "sand=1", "sand.name=[]",
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
    @given(
        st.binary(max_size=60) | st.text(alphabet="[]{}=.,\"'#\n\\abx01 ", max_size=60).map(str.encode),
        st.text(max_size=20),
    )
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
    "grid = 3",
    "latin_hypercube = []",
    "response = 'x'",
    "cluster = 1",
    "[cluster]\nkind = []",
    "[cluster]\nkind = 'pbs'",
    "scene = 3",
    "scene = [3]",
    "scene = ''",
    "scene = '\\u0000'",
    "scene = ['none.toml']",
    "[grid]",
    "[grid]\nx = 1",
    "[grid]\n'flow.speed_m_per_s' = 1",
    "[grid]\n'flow.speed_m_per_s' = []",
    "[grid]\n'flow.speed_m_per_s' = [[]]",
    "[grid]\n'flow.speed_m_per_s' = [nan]",
    "[grid]\n'flow.speed_m_per_s' = [true]",
    "[grid]\nsand = [3, []]",
    f"[grid]\n'flow.speed_m_per_s' = [0x{'f' * 5000}]",
    f"[grid]\nsand = [0x{'f' * 5000}]",
    "[grid]\nsand = ['../x.toml']",
    f"[grid]\n'flow.speed_m_per_s' = {[0.001 + 1e-7 * k for k in range(20_000)]}",
    f"[grid]\n'filling.layers' = {[*range(1, 200)]}\n'sand.n' = {[0.3 + 1e-4 * k for k in range(200)]}",
    "[grid]\n'silo.inserts.0' = [1]",
    "[grid]\n'silo.inserts.99999.width_m' = [1]",
    "[grid]\n'silo.inserts.²' = [1]",
    "[latin_hypercube]\nruns = 1000000000\nbetween.'flow.speed_m_per_s' = [0.001, 0.002]",
    "[latin_hypercube]\nruns = 2\nbetween.'flow.speed_m_per_s' = [0.002, 0.001]",
    "[latin_hypercube]\nruns = 2\nbetween.'flow.speed_m_per_s' = [-inf, inf]",
    "[latin_hypercube]\nruns = 2\nbetween.'flow.speed_m_per_s' = {low = 0.001, high = 0.002, step = 0}",
    "[latin_hypercube]\nruns = 2\nbetween.'flow.speed_m_per_s' = {low = 0.001, high = 0.002, step = nan}",
    "[latin_hypercube]\nruns = 2\nbetween.'walls.kind' = {choices = []}",
    "[latin_hypercube]\nruns = 2\nbetween = 3",
    "[latin_hypercube]\nruns = 2\nseed = -1\nbetween.'flow.speed_m_per_s' = [0.001, 0.002]",
    "retries = 1e9\n[grid]\n",
    "fidelity = 'none'\n[grid]\n'walls.kind' = ['smooth']",
    "film = 'perhaps'",
    "nonsense = 1",
    "[response]\ny = 3",
    "[grid]\n'walls.kind' = ['smooth', 'smooth']",
    "[grid]\n'machine.threads' = [1, 2]",
    "[grid]\n'sand.name' = ['a', 'b']",
]


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
    values = ["../../x", "/etc/passwd", "..", ".", "a/b", "a\\\\b", "\\u0007", "\\u202e", "C:x", "~", "-rf", "a" * 150]
    file.write_text(f"scene = {json.dumps([str(one) for one in names])}\n[grid]\n'walls.kind' = ['very-rough']\n")
    found = read_sweep(file).scenes()
    assert len(found) == 4
    for name in found:
        assert Path(name).name == name and name not in (".", "..") and name.isprintable() and not name.startswith(".")
    for key, value in itertools.product(("'walls.kind'", "sand"), values):
        file.write_text(f"[grid]\n{key} = [\"{value}\", 'smooth']\n")
        assert refusal(lambda: read_sweep(file).scenes()) is not None


# --- no file runs code ------------------------------------------------------------------------------------------------

FORBIDDEN = {"pickle", "cPickle", "dill", "cloudpickle", "joblib", "marshal", "shelve", "yaml"}


def test_nothing_in_the_package_unpickles_or_evaluates_what_it_reads():
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
    assert found == []

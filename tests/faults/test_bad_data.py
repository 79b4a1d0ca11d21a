"""Sands, measurements and drawings that are none: refused in a sentence that says what would be right."""

import numpy as np
import pytest

from taichi_silo.scene import sands
from taichi_silo.scene.published_sands import published
from taichi_silo.studies.compare.measured import read as read_measured
from tests.faults.bad import refusal, refused

RNG = np.random.default_rng(5)
SANDS = ["x = 1", "n = 0.5", "", "[sand]\nn = 1", "name = []"]


def test_a_sand_that_is_none_is_refused(tmp_path, tried):
    file, texts = tmp_path / "mine.toml", list(SANDS)
    whole = {name: value for name, value in published()["karlsruhe"].items() if name not in sands.NOTES}
    for name in whole:
        for wrong in ("nan", "-1", "[]", "true", "0x" + "f" * 5000, "'x'"):
            texts.append("".join(f"{key} = {value}\n" for key, value in (whole | {name: wrong}).items()))
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
    "nothing": b"",
    "blank lines": b"\n\n\n",
    "remarks only": b"# a\n# b\n",
    "no rows": HEAD,
    "no head": b"1,2\n3,4\n",
    "a wrong column": b"displacement_mm,force\n1,2\n",
    "one column": b"displacement_mm\n1\n",
    "a column twice": HEAD.replace(b"\n", b",P_N_per_m\n") + b"1,2,3\n",
    "words": HEAD + b"a,b\n",
    "a word": HEAD + b"1,2\n3,four\n",
    "nan": HEAD + b"1,nan\n",
    "inf": HEAD + b"1,inf\n",
    "1e999": HEAD + b"1,1e999\n",
    "too few": HEAD + b"1\n",
    "too many": HEAD + b"1,2,3\n",
    "no place": HEAD + b",2\n",
    "quotes": HEAD + b'1,"2\n3"\n',
    "an open quote": HEAD + b'1,"2\n3,4\n' * 50,
    "UTF-32": (HEAD + b"1,2\n").decode().encode("utf-32"),
    "NUL": HEAD + b"1,\x002\n",
    "a million columns": b",".join([b"P_kN_per_m"] * 80_000) + b"\n1,2\n",
    "a million words": b"displacement_mm,x\n" + b"1," + b"a" * 900_000,
    "a spreadsheet": b"PK\x03\x04" + RNG.bytes(500),
    "binary": RNG.bytes(1000),
    "JSON": b'{"a": [1, 2]}',
    "a page": b"<html><body>1,2</body></html>",
    "a field of 200 kB": HEAD + b'1,"' + b"2" * 200_000 + b'"\n',
    "other separators": b"displacement_mm|P_kN_per_m\n1|2\n",
    "mixed": b"displacement_mm,normal_stress_Pa\n1,2\n",
    "a control sign": b"displacement_mm,\x1b[31mP\n1,2\n",
    "right to left": "displacement_mm,\u202eP\n1,2\n".encode(),
}


def test_measurements_that_are_none_are_refused(tmp_path, tried):
    file = tmp_path / "measured.csv"
    for kind, data in TABLES.items():
        file.write_bytes(data)
        assert refusal(lambda: read_measured(file)) is not None, kind
    tried("inputs refused", "a table of measurements that is none", len(TABLES))


def test_measurements_with_a_byte_order_mark_are_read(tmp_path):
    for encoding in ("utf-8-sig", "utf-16"):
        (tmp_path / "measured.csv").write_bytes((HEAD + b"1,2\n").decode().encode(encoding))
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
    "too many bodies": (BOX, *[lambda space: space.add_circle((100, 200), 10)] * 60),
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

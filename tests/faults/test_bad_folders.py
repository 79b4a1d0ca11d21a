"""Folders whose files are not as a run leaves them: shown as far as they go, or refused in a sentence."""

import shutil
import zlib
from pathlib import Path

import numpy as np
import pytest

from taichi_silo import Result
from taichi_silo.runs import snapshot
from taichi_silo.runs.result import FORCES as COLUMNS
from taichi_silo.utils.messages import LONGEST
from tests.faults.bad import JARGON, circle, folder, holding, no_file, refusal, refused
from tests.faults.harness import command

RNG = np.random.default_rng(5)


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


FORCES = b",".join(name.encode() for name in COLUMNS) + b"\n"
DAMAGES = {
    "run.toml is noise": damage("run.toml", RNG.bytes(500)),
    "run.toml is empty": damage("run.toml", b""),
    "run.toml is of something else": damage("run.toml", b"[tool]\nname = 'x'\n"),
    "run.toml is brackets": damage("run.toml", b"x = " + b"[" * 50_000),
    "run.toml has values for tables": damage("run.toml", b"silo = 1\nwalls = 2\nsand = 3\nflow = 4\nprogram = 5\n"),
    "run.toml has words for numbers": column("run.toml", ("void_ratio = 0.6", 'void_ratio = "dense"')),
    "run.toml has a silo of another kind": column("run.toml", ("width_m = 0.2", "width_m = -1")),
    "summary.json is noise": damage("summary.json", RNG.bytes(500)),
    "summary.json is a list": damage("summary.json", b"[1, 2]"),
    "summary.json is brackets": damage("summary.json", b"[" * 200_000),
    "summary.json has values for tables": damage(
        "summary.json",
        b'{"finished": "x", "residual": 3, "peak": [], "filling": "y", "warnings": 4, "cost": [], "parts": 3}',
    ),
    "summary.json has words for numbers": damage(
        "summary.json",
        b'{"finished": true, "residual": {"bottom_N_per_m": "much"}, "weight_N_per_m": "heavy"}',
    ),
    "forces.csv is empty": damage("forces.csv", b""),
    "forces.csv has no rows": damage("forces.csv", FORCES),
    "forces.csv is noise": damage("forces.csv", RNG.bytes(3000)),
    "forces.csv has wrong columns": damage("forces.csv", b"a,b,c\n1,2,3\n"),
    "forces.csv has words": damage("forces.csv", FORCES + b"a,b,c,d,e,f,g,h,i,j\n" * 5),
    "forces.csv is ragged": damage("forces.csv", FORCES + b"1,flow\n1,flow,2,3,4,5,6,7,8,9,10,11,12\n" * 5),
    "forces.csv has a mark": damage("forces.csv", b"\xef\xbb\xbf" + FORCES),
    "forces.csv is UTF-16": damage("forces.csv", FORCES.decode().encode("utf-16")),
    "forces.csv has a million columns": damage("forces.csv", b"a," * 1_000_000 + b"\n" + b"1," * 1_000_000),
    "forces.csv has huge numbers": damage(
        "forces.csv", FORCES + b"1e400,flow,1e308,1e308,-1e308,nan,inf,1e308,1e308,1e308\n" * 5
    ),
    "forces.csv is cut off": cut("forces.csv"),
    "walls.csv is noise": damage("walls.csv", RNG.bytes(3000)),
    "walls.csv has words": damage("walls.csv", b"state,wall,height_m,normal_stress_Pa,shear_stress_Pa\nx,y,z,a,b\n"),
    "walls.csv is missing": without("walls.csv"),
    "index.csv is noise": damage("snapshots/index.csv", RNG.bytes(500)),
    "index.csv is empty": damage("snapshots/index.csv", b""),
    "index.csv has wrong columns": damage("snapshots/index.csv", b"a,b\n1,2\n"),
    "index.csv leads out": damage(
        "snapshots/index.csv",
        b"file,stage,time_s,displacement_m\n../../../etc/passwd,flow,1,1\n/etc/passwd,filling,0,0\n",
    ),
    "index.csv has words": damage(
        "snapshots/index.csv", b"file,stage,time_s,displacement_m\nstart.vtu,filling,soon,none\n"
    ),
    "a snapshot is empty": damage("snapshots/start.vtu", b""),
    "a snapshot is noise": damage("snapshots/start.vtu", RNG.bytes(3000)),
    "a snapshot is cut off": cut("snapshots/start.vtu"),
    "a snapshot is a page": damage("snapshots/start.vtu", b"<html></html>"),
    "snapshots are missing": without("snapshots"),
    "a snapshot is missing": without("snapshots/start.vtu"),
    "all is missing but run.toml": lambda place: [
        without(one.name)(place) for one in place.iterdir() if one.name != "run.toml"
    ],
}


def commands(place, out):
    """Every command that is given the folder of a run, as it is, by one who writes elsewhere."""
    yield "report", place, "--output", out / "report.html"
    yield "render", place, "--frame", "1", "--size", "320x180", "--output", out / "picture.png"
    yield "export", place, "--output", out / "silo.vtkhdf"
    yield "export", place, "--format", "csv", "--output", out / "csv"
    yield "compare", place, "--janssen", "--output", out / "compare"
    yield "gallery", place, "--output", out / "page"


OFTEN = (  # one of each file, for two commands, without drawing; all of them, for all commands, with `make test-long`
    "run.toml is noise", "run.toml has values for tables", "summary.json has values for tables", "forces.csv is ragged",
    "walls.csv is noise", "index.csv leads out", "a snapshot is cut off", "all is missing but run.toml",
)  # fmt: skip


@pytest.mark.parametrize("kind", OFTEN)
def test_a_run_with_damaged_files_is_shown_or_refused_in_a_sentence(kind, whole, tmp_path, monkeypatch, capsys, tried):
    place, out = Path(shutil.copytree(whole, tmp_path / "run")), tmp_path / "out"
    (place / "figures").mkdir()
    (place / "figures" / "void_ratio.png").write_bytes(b"")
    report, _, _, tables, *_ = commands(place, out)
    DAMAGES[kind](place)
    shown_or_refused(place, out, [report, tables], monkeypatch, capsys, tried)


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
    return (
        b'<VTKFile><UnstructuredGrid><Piece NumberOfPoints="%d" NumberOfCells="%d">' % (points, points)
        + body
        + b"</Piece></UnstructuredGrid></VTKFile>"
    )


def test_a_snapshot_that_unpacks_without_end_is_refused(tmp_path, tried):
    file = tmp_path / "start.vtu"
    for points in (10, -1, 10**12, 10**30):
        file.write_bytes(bomb(points))
        assert "damaged" in refusal(lambda: snapshot.read(file))
    tried("inputs refused", "a snapshot that unpacks without end", 4)

"""A run that dies at any moment, also within a write, goes on to what it would have become, and loses nothing."""

import os
import random
import shutil
import signal
import time
from collections import Counter

import pytest

from taichi_silo.runs.observers import checkpoint
from taichi_silo.runs.session import resume, run
from taichi_silo.utils import atomic_write, file_lock
from tests.faults.harness import assert_same, assert_sound, child
from tests.smallest import SMALLEST, smallest

OFTEN = smallest(output={"checkpoint_s": 0.03})


def photographed(folder, monkeypatch):
    """Run; copies of the folder as a death would leave it at chosen moments of writing, by what they are."""
    copies, counts = {}, Counter()
    moments = {  # file, what is done with it, which time
        ("checkpoint.npz", "previous", 2): "between the two names of a checkpoint",
        ("checkpoint.npz.part", "sync", 1): "before the first checkpoint has its name",
        ("checkpoint.npz.part", "sync", 3): "before the last checkpoint has its name",
        ("index.csv.part", "name", 8): "with a snapshot that is not listed",
        ("summary.json.part", "sync", 1): "before the summary has its name",
        ("run.toml.part", "sync", 2): "before the end is noted",
    }
    replace, sync = type(folder).replace, atomic_write.sync

    def seen(file, what):
        counts[file.name, what] += 1
        if name := moments.get((file.name, what, counts[file.name, what])):
            copies[name] = shutil.copytree(folder, folder.with_name(name))

    def replaced(file, target):
        if target.name == "index.csv":
            seen(file, "name")
        replace(file, target)
        if target.name == checkpoint.PREVIOUS:
            seen(file, "previous")

    with monkeypatch.context() as patch:
        patch.setattr(type(folder), "replace", replaced)
        patch.setattr(atomic_write, "sync", lambda file: (seen(file, "sync"), sync(file)))
        run(SMALLEST, folder)
    assert set(copies) == set(moments.values()), counts
    return copies


def test_whatever_write_a_death_falls_into_the_run_goes_on_to_the_same_end(quick, tmp_path, whole, monkeypatch, tried):
    copies = photographed(tmp_path / "run", monkeypatch)
    first = copies.pop("before the first checkpoint has its name")
    assert not checkpoint.is_there(first), "it had hardly begun, and begins again"
    torn = copies["before the last checkpoint has its name"]
    with open(torn / "forces.csv", "ab") as stream:
        stream.write(b"0.2222,flow,0.00")
    part = torn / "checkpoint.npz.part"
    os.truncate(part, part.stat().st_size // 2)
    for copy in copies.values():
        assert_sound(copy, whole)
        resume(copy)
        assert_same(copy, whole)
    tried("faults survived", "death of the process within a write", len(copies))


def test_a_run_that_is_killed_and_then_stopped_loses_nothing(tmp_path, whole):
    folder = tmp_path / "run"
    for number in (signal.SIGKILL, signal.SIGTERM):
        before, end = written(folder), time.monotonic() + 120.0
        process = child(folder, OFTEN)
        while written(folder) == before:  # then it steps
            assert process.poll() is None and time.monotonic() < end, process.stderr.read()
            time.sleep(0.002)
        process.send_signal(number)
        words = process.communicate(timeout=60)[1]
        assert process.returncode == (-9 if number == signal.SIGKILL else 128 + number), words
        if number != signal.SIGKILL:
            assert words.startswith("Error: stopped at t = 0.")
            assert f"`taichi-silo resume {folder}` goes on from there" in words
        assert "Traceback" not in words
        assert checkpoint.latest(folder)[1] == [], "whatever ends it leaves no damaged checkpoint"
    resume(folder)
    assert_same(folder, whole)
    assert not (folder / file_lock.NAME).exists()


def written(folder):
    """When the last checkpoint was."""
    file = folder / checkpoint.NAME
    return file.stat().st_mtime_ns if file.exists() else 0


KILLS, CHAIN = 50, 5
MIDWAY = (  # what is written, up to which time of it in one process, and whether some time later
    ("time", 1, 8.0), ("checkpoint", 60, 0.0), ("checkpoint", 12, 0.004), ("snapshots", 40, 0.0),
    ("snapshots", 30, 0.002), ("forces.csv", 150, 0.0), ("balance.csv", 150, 0.0), ("run.toml", 3, 0.0),
)  # fmt: skip
FILMED = (("film_states.bin", 40, 0.0), ("void_ratio", 1, 0.5))  # the film is drawn at the end
LATE = (("walls.csv", 1, 0.0), ("summary.json", 3, 0.0), ("figures", 8, 0.0), ("figures", 4, 0.1), ("run.toml", 5, 0.0))


@pytest.mark.long
def test_fifty_kills_at_random_moments_and_writes_lose_nothing(tmp_path_factory, tried):
    seed = random.SystemRandom().randrange(10**6)
    rng, done, wholes = random.Random(seed), Counter(), {}
    place = tmp_path_factory.mktemp("kills")
    for film in ("", "film"):
        wholes[film] = place / f"whole{film}"
        assert kill(wholes[film], film) == 0
    chain = 0
    while sum(done.values()) < KILLS:
        film, folder, told = "film" * (chain % 3 == 2), place / f"run{chain}", f"seed {seed}, chain {chain}"
        chain += 1
        wanted = [rng.choice(MIDWAY + FILMED * 2 * bool(film)) for _ in range(CHAIN - 2)]
        wanted += [rng.choice(LATE) for _ in range(2)]
        for what, most, late in wanted:
            code = kill(folder, film, what, rng.randint(2 if most > 1 and what.endswith((".csv", ".bin")) else 1, most),
                        rng.uniform(2.0 if what == "time" else 0.0, late))  # fmt: skip
            assert code in (-9, 0), told
            done[what] += code == -9
            if (folder / "forces.csv").exists():
                assert_sound(folder, wholes[film])
        code = kill(folder, film)
        assert code == 0, told
        assert_same(folder, wholes[film])
    print(f"seed {seed}: {dict(done)}")
    assert sum(done.values()) - done["time"] > 0.6 * KILLS, f"seed {seed}: too few within writes: {done}"
    tried("faults survived", "kill -9 at a random moment or within a write", sum(done.values()))


def kill(folder, film, what="", count=0, delay=0.0):
    """Run until it is killed, or ends; the exit code."""
    process = child(folder, OFTEN, film=bool(film), figures=True, dies=[what, count, delay])
    words = process.communicate(timeout=300)[1]
    assert process.returncode <= 0, words
    return process.returncode

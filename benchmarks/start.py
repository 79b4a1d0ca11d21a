"""What the program costs before it steps: processor seconds (user and system), the best of some runs.

`make start` prints the table and writes outputs/bench/start.csv.
"""

import argparse
import compileall
import csv
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

FOLDER = Path("outputs") / "bench"
COLUMNS = ("what", "processor_seconds")
SCENE = "[grid]\ncell_size_m = 0.02\n[flow]\nspeed_m_per_s = 0.01\ndisplacement_m = 0.004\n"  # 250 points, 10,000 steps
RUN = ("run", "silo.toml", "--output", "run", "--overwrite", "--quiet", "--no-film")
MEASURED = {  # words of the command
    "`taichi-silo --help`": ("--help",),
    "`taichi-silo list`": ("list",),
    "a run of 250 points": RUN,
    "the same with `--no-figures`": (*RUN, "--no-figures"),
}
FIRST = "its first run on a machine"


def processor_seconds(words: tuple[str, ...], folder: Path, cache: Path) -> float:
    """What one call of the program takes, with all processes that it starts, compiled kernels being kept in `cache`."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    root = str(Path(__file__).parents[1])
    subprocess.run(
        [sys.executable, "-m", "taichi_silo.cli.app", *words], cwd=folder, check=True, capture_output=True,
        env=os.environ | {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": root},
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(times: int) -> list[dict]:
    """Rows of the table, of a package that is compiled to bytecode, as `pip install` leaves it."""
    compileall.compile_dir(Path(__file__).parents[1] / "taichi_silo", quiet=1)
    with tempfile.TemporaryDirectory() as name:
        folder, cache = Path(name), Path(name) / "cache"
        (folder / "silo.toml").write_text(SCENE, encoding="utf-8")
        words = MEASURED["the same with `--no-figures`"]
        seconds = {FIRST + ", `--no-figures`": processor_seconds(words, folder, cache)}
        for what, words in MEASURED.items():
            seconds[what] = min(processor_seconds(words, folder, cache) for _ in range(times))
    return [dict(zip(COLUMNS, (what, round(found, 2)), strict=True)) for what, found in seconds.items()]


def main() -> None:
    """Measure, print, write."""
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--times", type=int, default=5, help="runs of each, of which the best counts")
    rows = measure(flags.parse_args().times)
    for row in rows:
        print(f"{row['what']:45s} {row['processor_seconds']:6.2f} s")
    FOLDER.mkdir(parents=True, exist_ok=True)
    with open(FOLDER / "start.csv", "w", newline="", encoding="utf-8") as stream:
        stream.write("# make start\n")
        writer = csv.DictWriter(stream, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()

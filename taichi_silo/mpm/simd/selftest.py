"""Whether the vector unit can be trusted on this machine: tried in a process of its own, and remembered.

It rests on a switch inside Taichi (`vectors.compiling_simd`), and no other processor and version than those of the
tests can be promised. So before the first use formulas of sand are tried both ways in a child process (`trial`);
whatever happens there, this process goes on, with plain loops if need be.
"""

import functools
import hashlib
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

from taichi_silo.mpm import language

PATIENCE_S = 300.0
ROOM = Path(__file__).parent
TRIED = ("trial.py", "vectors.py")  # what is tried, and the switch


def place() -> Path:
    """File of the verdicts."""
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "taichi_silo" / "lanes.json"


def circumstances() -> str:
    """What the verdict depends on: the processor and what it can do, the language, and what is tried.

    The rest of the code is not among it: whether something there has an operation that vectors do not know is the same
    on every machine, and tests find it.
    """
    sources = hashlib.sha256()
    for name in TRIED:
        sources.update((ROOM / name).read_bytes())
    about = [platform.machine(), platform.processor()]
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        about += sorted({line for line in lines if line.startswith(("model name", "flags", "CPU part", "Features"))})
    processor = hashlib.sha256("\n".join(about).encode()).hexdigest()
    return f"processor {processor} | {language.VERSION} | {sources.hexdigest()}"


@functools.cache
def failure() -> str:
    """Why the vector unit is not to be trusted here; empty if it is. Takes a second, once on a machine."""
    key, file = circumstances(), place()
    try:
        verdicts = json.loads(file.read_text())
        if verdicts["circumstances"] == key:
            return verdicts["failure"]
    except (OSError, ValueError, KeyError, TypeError):
        pass
    verdict = _try()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        temporary = file.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps({"circumstances": key, "failure": verdict}))
        temporary.replace(file)
    except OSError:
        pass  # it will be tried again
    return verdict


def _try() -> str:
    try:
        done = subprocess.run(
            [sys.executable, "-m", "taichi_silo.mpm.simd.trial"], capture_output=True, text=True, timeout=PATIENCE_S,
            cwd=ROOM.parents[2],
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"the trial did not end ({type(error).__name__})"
    if done.returncode < 0 or done.returncode > 1:
        return f"the trial ended with code {done.returncode}"
    return "" if done.returncode == 0 else (done.stdout.strip().splitlines() or ["the trial failed"])[-1]

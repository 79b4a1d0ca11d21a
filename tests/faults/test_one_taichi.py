"""One Taichi a process: threads wait for each other, a fork and a user's own fields are refused before any work."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

BEGIN = """
    import threading

    from taichi_silo import BadInput, run
    from taichi_silo.mpm.language import ti
    from tests.smallest import SMALLEST

    def attempt(name):
        try:
            run(SMALLEST, name, film=False, figures=False, progress=False)
            return "finished"
        except BadInput as error:
            return str(error)
"""


def said(folder, text):
    """Lines that a script prints, in a folder."""
    script = textwrap.dedent(BEGIN) + textwrap.dedent(text)
    given = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, env=given, capture_output=True, text=True, timeout=400
    )
    assert done.returncode == 0, done.stderr
    return [line for line in done.stdout.splitlines() if not line.startswith(("[Taichi]", "[Quadrants]"))]


def test_a_run_in_another_thread_waits_for_the_first(tmp_path):
    first, second, third = said(tmp_path, """
        said = []
        threads = [threading.Thread(target=lambda n=n: said.append(attempt(n))) for n in ("a", "b")]
        for one in threads:
            one.start()
        for one in threads:
            one.join()
        print(*said, attempt("c"), sep="\\n")
    """)  # fmt: skip
    assert first == second == third == "finished"
    assert (tmp_path / "a" / "forces.csv").read_bytes() == (tmp_path / "b" / "forces.csv").read_bytes()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_process_that_was_forked_after_a_run_says_so_instead_of_waiting_for_ever(tmp_path):
    first, forked, spawned = said(tmp_path, """
        import multiprocessing

        print(attempt("a"))
        with multiprocessing.get_context("fork").Pool(1) as pool:
            print(*pool.map(attempt, ["b"]), sep="\\n")
        print(attempt("c"))
    """)  # fmt: skip
    assert first == spawned == "finished"
    assert "was forked from one in which Taichi was running" in forked and "spawn" in forked
    assert not (tmp_path / "b").exists()


def test_fields_of_the_users_own_are_not_ended_without_a_word(tmp_path):
    """The remedy that is named helps; a Taichi without fields is nobody's loss."""
    lines = said(tmp_path, """
        ti.init(arch=ti.cpu)
        field = ti.field(ti.f64, shape=4)
        field.fill(2.0)
        print(attempt("a"), field.to_numpy().sum(), sep="\\n")
        ti.init(arch=ti.cpu)
        array = ti.ndarray(ti.f64, 4)
        array.fill(3.0)
        print(attempt("a"), array.to_numpy().sum(), sep="\\n")
        ti.reset()
        print(attempt("b"))
        field = ti.field(ti.f64, shape=4)
        field.fill(1.0)
        print(attempt("a"), field.to_numpy().sum(), sep="\\n")
        del array
        ti.init(arch=ti.cpu)
        print(attempt("c"))
    """)  # fmt: skip
    refused, two, arrays, three, begun, after, one, again = lines
    assert (two, three, one) == ("8.0", "12.0", "4.0")
    assert begun == again == "finished"
    for sentence in (refused, arrays, after):
        assert "fields of your own" in sentence and "call ti.reset()" in sentence
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b", "c"]


def test_a_run_within_a_run_is_refused(tmp_path):
    (line,) = said(tmp_path, """
        from taichi_silo.runs.observers import Observer

        class Another(Observer):
            def filled(self):
                print(attempt("b"))

        run(SMALLEST, "a", film=False, figures=False, progress=False, extra=(Another(),))
    """)  # fmt: skip
    assert "within a run" in line
    assert (tmp_path / "a" / "summary.json").exists() and not (tmp_path / "b").exists()

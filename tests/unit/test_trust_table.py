"""The table of what has been tried has what passed tests have counted, and nothing else."""

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from tests import trust_table

ROOT = Path(__file__).parents[2]
TESTS = """
    import pytest

    @pytest.fixture
    def tried(record_property):
        return lambda group, what, count=1: record_property("tried", [group, what, count])

    @pytest.fixture
    def breaks():
        yield
        raise RuntimeError("afterwards")

    @pytest.mark.parametrize("much", [1, 20])
    def test_counts(tried, much):
        tried("inputs refused", "odd, numbers", much)
        tried("of my own", "things")

    def test_counts_and_fails(tried):
        tried("inputs refused", "odd, numbers", 300)
        assert False

    def test_counts_and_fails_afterwards(tried, breaks):
        tried("faults survived", "crash", 300)

    def test_skips(tried):
        tried("faults survived", "crash", 300)
        pytest.skip("not here")

    def test_counts_thrice(tried):
        for _ in range(3):
            tried("faults survived", "kill")

    def test_counts_nothing():
        assert False, "it is not run"
"""
WANTED = """# make trust
group,what,tests,count
faults survived,kill,1,3
inputs refused,"odd, numbers",2,21
of my own,things,2,2
"""


@pytest.mark.parametrize("processes", [0, 1])
def test_it_counts_what_passed_in_one_process_as_in_several(processes, tmp_path):
    (tmp_path / "test_some.py").write_text(textwrap.dedent(TESTS))
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "tests.trust_table"]
    command += ["-n", str(processes), "--rootdir", str(tmp_path), "--trust-table", str(tmp_path / "trust.csv")]
    command.append(str(tmp_path))
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1, "some failed" + done.stdout + done.stderr
    assert (tmp_path / "trust.csv").read_text() == WANTED
    assert f"26 tries of 3 tests: {tmp_path / 'trust.csv'}" in done.stdout


def test_the_groups_that_are_known_stand_first():
    tries = {"a": [["z", "x", 1], ["loads held", "y", 1], ["inputs run", "x", 2]], "b": [["inputs run", "a", 1]]}
    assert [row[:2] for row in trust_table.table(tries)] == [
        ("loads held", "y"), ("inputs run", "a"), ("inputs run", "x"), ("z", "x"),
    ]  # fmt: skip

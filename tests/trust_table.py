"""What the tests have tried, as a table: `make trust`.

A plugin (`-p tests.trust_table --trust-table FILE`): it runs only the tests that count what they try with the fixture
`tried`, and writes group, what, how many tests, and how many things they tried; those of a test that did not pass are
left out.
"""

import csv
from collections import defaultdict
from pathlib import Path

import pytest

GROUPS = ("loads held", "faults survived", "inputs refused", "inputs run", "alarms fired")  # in this order; then others
HEADS = ("group", "what", "tests", "count")


def pytest_addoption(parser):
    parser.addoption("--trust-table", type=Path, metavar="FILE", help="run what counts its tries; write them here")


def pytest_configure(config):
    if config.getoption("--trust-table"):
        config.pluginmanager.register(Gatherer(config), "trust-table-gatherer")


class Gatherer:
    """Keeps what passed tests have tried until all are done."""

    def __init__(self, config):
        self.file = config.getoption("--trust-table")
        self.writes = not hasattr(config, "workerinput")  # of several processes, the one that starts the others
        self.passed, self.told = {}, ""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config, items):
        """Only tests that count."""
        others = [item for item in items if "tried" not in getattr(item, "fixturenames", ())]
        if others:
            config.hook.pytest_deselected(items=others)
            items[:] = [item for item in items if item not in set(others)]

    def pytest_runtest_logreport(self, report):
        """Take what a test has tried; give it back if the test did not end well."""
        if report.when == "call" and report.passed:
            self.passed[report.nodeid] = [value for name, value in report.user_properties if name == "tried"]
        elif report.failed:
            self.passed.pop(report.nodeid, None)

    def pytest_sessionfinish(self):
        """Write the table, if anything was tried."""
        if not self.writes:
            return
        rows = table(self.passed)
        if rows:
            write(self.file, rows)
        total = sum(row[-1] for row in rows)
        where = f": {self.file}" if rows else "; nothing is written"
        self.told = f"{total} tries of {len(self.passed)} tests{where}"

    def pytest_terminal_summary(self, terminalreporter):
        """Say what was written."""
        if self.told:
            terminalreporter.write_line(self.told)


def table(passed: dict[str, list]) -> list[tuple]:
    """Rows of tries by test: group, what, how many tests, how many tries."""
    tests, counts = defaultdict(set), defaultdict(int)
    for test, tries in passed.items():
        for group, what, count in tries:
            tests[group, what].add(test)
            counts[group, what] += count
    known = {group: place for place, group in enumerate(GROUPS)}
    order = sorted(counts, key=lambda one: (known.get(one[0], len(GROUPS)), *one))
    return [(*one, len(tests[one]), counts[one]) for one in order]


def write(file: Path, rows: list[tuple]) -> None:
    """The table, headed by the command that makes it."""
    with open(file, "w", encoding="utf-8", newline="") as stream:
        stream.write("# make trust\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerows([HEADS, *rows])

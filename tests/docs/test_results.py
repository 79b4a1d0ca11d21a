"""Numbers in the validation pages are read from the stored results."""

import re
import shutil
import sys

import pandas as pd
import pytest
from written import DOCS

sys.path.insert(0, str(DOCS / "hooks"))

import results  # noqa: E402
from results import rendered  # noqa: E402

PAGES = sorted((DOCS / "validation").glob("*.md"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_of_results_is_filled(page):
    found = rendered(page.read_text(encoding="utf-8"))
    assert "{{" not in found
    assert "nan" not in found.lower().replace("\n", " ").split()


def test_a_number_that_changes_in_the_results_changes_on_the_page(tmp_path, monkeypatch):
    page = (DOCS / "validation" / "speed.md").read_text(encoding="utf-8")
    before = rendered(page)
    shutil.copytree(results.GALLERY, tmp_path / "gallery")
    table = pd.read_csv(tmp_path / "gallery" / "bench.csv")
    table.loc[0, "nanoseconds_per_particle_step"] = 1234.0
    table.to_csv(tmp_path / "gallery" / "bench.csv", index=False)
    monkeypatch.setattr(results, "GALLERY", tmp_path / "gallery")
    after = rendered(page)
    assert "1234" not in before
    assert "| 4000 | 1 | 1 | 1234 |" in after


def test_the_statements_of_the_paper_are_all_there():
    counted = results.verdicts()
    assert sum(many for name, many in counted.items() if name != "all") == counted["all"]
    rows = [line for line in results.statements().splitlines() if line.startswith("| ") and line.count("|") == 7]
    heads = sum(line.startswith("| id ") for line in rows)
    assert len(rows) - heads == counted["all"]


def test_a_value_that_misses_its_bound_has_a_cross():
    found = results.pivot("stability.csv", "method", "measure", "value", "unit", "holds", mode="1 cell crossing")
    linear = next(line for line in found.splitlines() if line.startswith("| linear |"))
    assert "0.21 ✗" in linear
    assert "✗" not in next(line for line in found.splitlines() if line.startswith("| cpdi |"))


def test_what_the_results_do_not_have_is_an_error():
    with pytest.raises(ValueError, match="has no nothing.png"):
        results.figure("nothing.png", "nothing")
    with pytest.raises(ValueError, match="never"):
        results.table("bench.csv", {"a": "points"}, phase="dreaming")
    with pytest.raises(ValueError, match="must be one"):
        results.number("bench.csv", "points", phase="step")


def test_everything_that_was_tried_is_on_the_page_of_trust():
    rows = results.read("trust.csv")
    assert list(rows.columns) == ["group", "what", "tests", "count"]
    assert not rows.duplicated(["group", "what"]).any()
    page = rendered((DOCS / "validation" / "trust.md").read_text(encoding="utf-8"))
    for group, mine in rows.groupby("group"):
        assert f"## {group.capitalize()}\n" in page
        if group != "loads held":  # of which some are runs and some are steps
            assert f"**{mine['count'].astype(int).sum()}** in all" in page
        for row in mine.itertuples():
            assert f"| {row.what} | {row.tests} | {row.count} |" in page
            assert int(row.count) >= 1 <= int(row.tests)


def test_groups_and_rows_that_are_new_come_onto_the_page_of_trust(tmp_path, monkeypatch):
    tried = "# make trust\ngroup,what,tests,count\nmoons landed on,a dark one,2,7\n"
    (tmp_path / "trust.csv").write_text(tried, encoding="utf-8")
    shutil.copy(results.DATA / "endurance.csv", tmp_path)
    page = (DOCS / "validation" / "trust.md").read_text(encoding="utf-8")
    monkeypatch.setattr(results, "DATA", tmp_path)
    shown = rendered(page)
    assert "## Moons landed on\n" in shown and "| a dark one | 2 | 7 |" in shown and "**7** in all" in shown
    assert "faults survived" not in shown.lower()


def test_at_least_five_hundred_inputs_were_tried():
    rows = results.read("trust.csv")
    inputs = rows[rows.group.isin(["inputs refused", "inputs run"])]
    assert inputs["count"].astype(int).sum() >= 500


def test_fifty_deaths_were_survived_and_every_alarm_was_fired():
    rows = results.read("trust.csv")
    assert rows[rows.what.str.startswith("kill -9")]["count"].astype(int).sum() >= 50
    fired = set(rows[rows.group == "alarms fired"].what)
    alarms = (DOCS / "theory" / "alarms.md").read_text(encoding="utf-8")
    assert {name for name in re.findall(r"^\| `([a-z -]+)` \|", alarms, re.MULTILINE)} - {"name"} <= fired

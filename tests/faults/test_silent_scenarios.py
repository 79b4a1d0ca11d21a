"""No alarm sounds in any scenario of the repository, but in the one that shows what noise does."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

SCENARIOS = Path(__file__).parents[2] / "scenarios"
COARSE = ["--cell-size", "0.01", "--speed", "0.005"]
RUNS = {  # flags that keep them short: cells of 10 mm
    "mass_flow": COARSE + ["--no-film"],
    "four_cases": COARSE,
    "outlet": COARSE + ["--no-film"],
    "hopper": COARSE + ["--no-film"],
    "insert": COARSE + ["--no-film"],
    "gravity_discharge": ["--cell-size", "0.01", "--no-film"],
    "fillings": COARSE,
    "size_effect": [],
    "noise_control": COARSE,
}


@pytest.mark.long
@pytest.mark.parametrize("name", RUNS)
def test_a_scenario_raises_no_alarm(name, tmp_path, tried):
    command = [sys.executable, str(SCENARIOS / f"{name}.py"), "--output", str(tmp_path / "run"), *RUNS[name]]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=1500)
    assert done.returncode == 0, done.stderr[-1000:]
    found = {file.parent.name: json.loads(file.read_text()) for file in tmp_path.rglob("summary.json")}
    assert found and all(summary["finished"] for summary in found.values())
    alarms = {run: [a["sentence"] for a in summary["alarms"]] for run, summary in found.items() if "alarms" in summary}
    if name == "noise_control":
        assert list(alarms) == ["none"] and any("ratcheting" in words for words in alarms["none"])
    else:
        assert not alarms
    tried("loads held", "scenarios without an alarm", len(found) - len(alarms))

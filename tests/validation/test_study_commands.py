"""Each study is one command, from the module, from the plain script and under its name of old in scenarios/."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STUDIES = {  # script in scenarios/: module
    "chart": "validation.accuracy", "fillings": "validation.fillings", "four_cases": "validation.four_cases",
    "noise_control": "validation.noise_control", "paper": "validation.paper", "paper_check": "validation.paper.recheck",
    "paper_element_tests": "validation.element_tests", "plane_strain_compression": "validation.biaxial",
    "size_effect": "validation.size_effect", "stability": "validation.stability",
}  # fmt: skip
SINGLE = [file for file in (ROOT / "validation").glob("*.py") if "__main__" in file.read_text()]


@pytest.mark.parametrize("file", SINGLE, ids=lambda file: file.name)
def test_a_study_of_one_file_runs_as_a_plain_script(file):
    """`python validation/four_cases.py` with the installed package: what it imports from beside it, it finds."""
    text = file.read_text()
    modules = [node.module for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)]
    assert not [one for one in modules if one.startswith(("validation", "."))] or "sys.path.insert" in text


@pytest.mark.long
@pytest.mark.parametrize("script", STUDIES)
def test_module_and_script_say_the_same(script):
    def told(*command):
        done = subprocess.run([sys.executable, *command, "--help"], capture_output=True, text=True, cwd=ROOT)
        assert done.returncode == 0, done.stderr
        return done.stdout.split("\n", 1)[1]  # less the line with the program's name

    assert told("-m", STUDIES[script]) == told(ROOT / "scenarios" / f"{script}.py")


def test_every_script_in_scenarios_that_forwards_is_listed():
    forward = {file.stem for file in (ROOT / "scenarios").glob("*.py") if "from validation" in file.read_text()}
    assert forward == set(STUDIES)

"""Bad input is refused before any work: one clear sentence, exit code 2, nothing written."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "scenarios" / "mass_flow.py"


def refuse(folder, *flags):
    """The one sentence on stderr."""
    done = subprocess.run(
        [sys.executable, str(SCRIPT), "--output", str(folder / "run"), *flags],
        capture_output=True, text=True, cwd=folder, timeout=120,
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    assert not list(folder.rglob("*")), "something was written"
    return " ".join(done.stderr.split())


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--width", "-0.2"], ["width", "-0.2", "above 0"]),
        (["--void-ratio", "0.4"], ["void ratio", "0.4", "0.51", "1.3"]),
        (["--void-ratio", "1.4"], ["void ratio", "1.4", "0.51", "1.3"]),
        (["--void-ratio", "nan"], ["void_ratio", "nan", "finite"]),
        (["--cell-size", "0.03"], ["cell size", "0.03", "divide", "0.2"]),
        (["--speed", "0"], ["speed", "0", "above 0"]),
        (["--displacement", "0.7"], ["displacement", "0.7", "0.5"]),
        (["--points-per-cell", "3"], ["points per cell", "3", "square"]),
        (["--threads", "4000"], ["threads", "4000"]),
        (["--walls", "greasy"], ["greasy", "smooth", "very-rough"]),
        (["--walls", "smooth", "--wall-friction-angle", "95"], ["friction_angle_deg", "95", "below 90"]),
        (["--arch", "abacus"], ["abacus", "cpu", "cuda"]),
        (["--viod-ratio", "0.6"], ["--viod-ratio", "--void-ratio"]),
        (["--speed", "fast"], ["speed", "fast"]),
        (["--speed=fast"], ["speed", "fast"]),
        (["--wall-friction-angle", "25"], ["25", "very rough"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) and value[0].startswith("--") else "",
)
def test_one_sentence_names_the_value_and_what_would_be_right(tmp_path, flags, words):
    sentence = refuse(tmp_path, *flags)
    for word in words:
        assert word in sentence, sentence


def test_an_output_that_cannot_be_written_is_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("in the way")
    done = subprocess.run(
        [sys.executable, str(SCRIPT), "--output", str(file / "run")], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 2
    assert "cannot be written" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == [file]


def test_a_run_is_not_overwritten_unasked(tmp_path):
    (tmp_path / "run.toml").write_text("precious = true")
    done = subprocess.run(
        [sys.executable, str(SCRIPT), "--output", str(tmp_path)], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 2
    assert "--overwrite" in done.stderr
    assert (tmp_path / "run.toml").read_text() == "precious = true"
    assert list(tmp_path.iterdir()) == [tmp_path / "run.toml"]

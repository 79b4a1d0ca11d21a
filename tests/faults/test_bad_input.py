"""Bad input is refused before any work: one clear sentence, exit code 2, nothing written."""

import subprocess
import sys

import pytest

from tests.faults.harness import ROOT, contents, failed


@pytest.fixture
def refuse(tmp_path, monkeypatch, capsys):
    """A function: the one sentence with which a scenario refuses these flags, before anything is written."""
    monkeypatch.chdir(tmp_path)

    def sentence(scenario, *flags):
        code, err = failed(monkeypatch, capsys, "run", scenario, "--output", "run", *flags)
        assert code == 2 and err.startswith("Error: "), err
        assert not list(tmp_path.iterdir()), "something was written"
        return err

    return sentence


def test_a_script_refuses_as_the_command_does(tmp_path):
    script = ROOT / "scenarios" / "mass_flow.py"
    done = subprocess.run([sys.executable, script, "--width", "-0.2"], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.startswith("Error: ") and done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--width", "-0.2"], ["width", "-0.2", "at least 0.001 and at most 1000"]),
        (["--void-ratio", "0.4"], ["void ratio", "0.4", "0.51", "1.3"]),
        (["--void-ratio", "nan"], ["void_ratio", "nan", "finite"]),
        (["--cell-size", "0.03"], ["cell size", "0.03", "divide", "0.2"]),
        (["--speed", "0"], ["speed", "0", "at least 1e-09 and at most 1"]),
        (["--displacement", "0.7"], ["displacement", "0.7", "0.5"]),
        (["--walls", "greasy"], ["greasy", "smooth", "very-rough"]),
        (["--walls", "smooth", "--wall-friction-angle", "95"], ["friction_angle_deg", "95", "below 90"]),
        (["--arch", "abacus"], ["abacus", "cpu", "cuda"]),
        (["--viod-ratio", "0.6"], ["--viod-ratio", "--void-ratio"]),
        (["--speed", "fast"], ["speed", "fast"]),
        (["--wall-friction-angle", "25"], ["25", "very rough"]),
        (["--sand", "toyuora"], ["toyuora", "did you mean toyoura"]),
        (["--sand", "mine.toml"], ["mine.toml", "cannot be read"]),
        (["--law", "elastic"], ["elastic", "gudehus-bauer", "intergranular"]),
        (["--characteristic-length", "-0.001"], ["characteristic_length_m", "-0.001", "at least 0"]),
        (["--cell-size", "0.0005", "--characteristic-length", "0.05"], ["characteristic length", "0.05", "pairs"]),
        (["--half", "maybe"], ["half", "maybe", "auto"]),
        (["--half", "yes", "--filter", "null-space"], ["half is yes", "null-space", "auto or no"]),
        (["--weight", "box"], ["box", "gaussian", "exponential"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) and value[0].startswith("--") else "",
)
def test_one_sentence_names_the_value_and_what_would_be_right(refuse, flags, words):
    sentence = refuse("mass_flow", *flags)
    for word in words:
        assert word in sentence, sentence


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["triaxail"], ["triaxail", "triaxial"]),
        (["triaxial", "--void-ratio", "0.50"], ["void ratio", "0.5", "0.51"]),
        (["triaxial", "--sand", "hamburg", "--void-ratio", "0.94", "--pressure", "5e6"], ["0.94", "5e+06 Pa", "e_i"]),
        (["triaxial", "--pressure", "-50e3"], ["pressure_Pa", "-50000", "at least 100"]),
        (["oedometer", "--strain", "0.9"], ["strain", "0.9", "0.5"]),
        (["oedometer", "--through", "fem"], ["fem", "point", "mpm"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) and len(value) < 4 else "",
)
def test_an_impossible_element_test_is_refused(refuse, flags, words):
    sentence = refuse("element_test", *flags)
    for word in words:
        assert word in sentence, sentence


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--characteristic-length", "-0.001"], ["characteristic_length_m", "-0.001", "at least 0"]),
        (["--pressure", "0"], ["pressure_Pa", "0", "at least 100"]),
        (["--points-across", "31"], ["points across", "31", "multiple of 4"]),
        (["--void-ratio", "1.28", "--pressure", "500e3"], ["1.28", "e_i"]),
        (["--study", "everything"], ["everything", "all"]),
        (["--study", "rate", "--pressure", "200e3"], ["--study", "--output"]),
        (["--sand", "hamburg", "--void-ratio", "0.6"], ["weak void ratio", "0.91", "0.89"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) and value[0].startswith("--") else "",
)
def test_an_impossible_specimen_is_refused(refuse, flags, words):
    sentence = refuse("plane_strain_compression", *flags)
    for word in words:
        assert word in sentence, sentence


def test_an_output_that_cannot_be_written_is_refused(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("in the way")
    code, err = failed(monkeypatch, capsys, "run", "mass_flow", "--output", tmp_path / "file" / "run")
    assert code == 2 and "cannot be written" in err
    assert [file.name for file in tmp_path.iterdir()] == ["file"]


def test_a_run_is_not_overwritten_unasked(tmp_path, monkeypatch, capsys):
    (tmp_path / "run.toml").write_text("precious = true")
    code, err = failed(monkeypatch, capsys, "run", "mass_flow", "--output", tmp_path)
    assert code == 2 and "--overwrite" in err
    assert contents(tmp_path) == {"run.toml": b"precious = true"}


@pytest.mark.parametrize(
    ("script", "flags", "words"),
    [
        ("outlet", ["--outlet-width", "0.3"], ["outlet width is 0.3", "below", "0.2"]),
        ("outlet", ["--outlet-position", "top"], ["position is top", "centre"]),
        ("outlet", ["--filling", "snow"], ["snow", "gravity-ramp", "rain"]),
        ("hopper", ["--half-angle", "3"], ["half angle", "3.0 deg", "0.5"]),
        ("insert", ["--insert-width", "0.3"], ["roof", "free of the walls", "0.2"]),
        ("gravity_discharge", ["--longest", "0"], ["longest_s is 0", "at least 1e-06"]),
        ("gravity_discharge", ["--speed", "0.1"], ["--speed"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) and value[0].startswith("--") else "",
)
def test_an_impossible_silo_is_refused(refuse, script, flags, words):
    sentence = refuse(script, *flags)
    for word in words:
        assert word in sentence, sentence

"""Bad input is refused before any work: one clear sentence, exit code 2, nothing written."""

import subprocess
import sys

import pytest

from tests.faults.harness import ROOT, failed


def test_a_script_refuses_as_the_command_does(tmp_path):
    script = ROOT / "scenarios" / "mass_flow.py"
    done = subprocess.run([sys.executable, script, "--width", "-0.2"], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.startswith("Error: ") and done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


IMPOSSIBLE = [
    ("mass_flow --width -0.2", ["width", "-0.2", "at least 0.001 and at most 1000"]),
    ("mass_flow --void-ratio 0.4", ["void ratio", "0.4", "0.51", "1.3"]),
    ("mass_flow --void-ratio nan", ["void_ratio", "nan", "finite"]),
    ("mass_flow --cell-size 0.03", ["cell size", "0.03", "divide", "0.2"]),
    ("mass_flow --speed 0", ["speed", "0", "at least 1e-09 and at most 1"]),
    ("mass_flow --displacement 0.7", ["displacement", "0.7", "0.5"]),
    ("mass_flow --walls greasy", ["greasy", "smooth", "very-rough"]),
    ("mass_flow --walls smooth --wall-friction-angle 95", ["friction_angle_deg", "95", "below 90"]),
    ("mass_flow --arch abacus", ["abacus", "cpu", "cuda", "vulkan"]),
    ("mass_flow --viod-ratio 0.6", ["--viod-ratio", "--void-ratio"]),
    ("mass_flow --speed fast", ["speed", "fast"]),
    ("mass_flow --wall-friction-angle 25", ["25", "very rough"]),
    ("mass_flow --sand toyuora", ["toyuora", "did you mean toyoura"]),
    ("mass_flow --sand mine.toml", ["mine.toml", "cannot be read"]),
    ("mass_flow --law elastic", ["elastic", "gudehus-bauer", "intergranular"]),
    ("mass_flow --characteristic-length -0.001", ["characteristic_length_m", "-0.001", "at least 0"]),
    ("mass_flow --cell-size 0.0005 --characteristic-length 0.05 --averaging-means rows", ["0.05", "pairs", "grid"]),
    ("mass_flow --half maybe", ["half", "maybe", "auto"]),
    ("mass_flow --half yes --filter null-space", ["half is yes", "null-space", "auto or no"]),
    ("mass_flow --weight box", ["box", "gaussian", "exponential"]),
    ("element_test triaxail", ["triaxail", "triaxial"]),
    ("element_test triaxial --void-ratio 0.50", ["void ratio", "0.5", "0.51"]),
    ("element_test triaxial --sand hamburg --void-ratio 0.94 --pressure 5e6", ["0.94", "5e+06 Pa", "e_i"]),
    ("element_test triaxial --pressure -50e3", ["pressure_Pa", "-50000", "at least 100"]),
    ("element_test oedometer --strain 0.9", ["strain", "0.9", "0.5"]),
    ("element_test oedometer --through fem", ["fem", "point", "mpm"]),
    ("plane_strain_compression --characteristic-length -0.001", ["characteristic_length_m", "-0.001", "at least 0"]),
    ("plane_strain_compression --pressure 0", ["pressure_Pa", "0", "at least 100"]),
    ("plane_strain_compression --points-across 31", ["points across", "31", "multiple of 4"]),
    ("plane_strain_compression --void-ratio 1.28 --pressure 500e3", ["1.28", "e_i"]),
    ("plane_strain_compression --study everything", ["everything", "all"]),
    ("plane_strain_compression --study rate --pressure 200e3", ["--study", "--output"]),
    ("plane_strain_compression --sand hamburg --void-ratio 0.6", ["weak void ratio", "0.91", "0.89"]),
    ("outlet --outlet-width 0.3", ["outlet width is 0.3", "below", "0.2"]),
    ("outlet --outlet-position top", ["position is top", "centre"]),
    ("outlet --filling snow", ["snow", "gravity-ramp", "rain"]),
    ("hopper --half-angle 3", ["half angle", "3.0 deg", "0.5"]),
    ("insert --insert-width 0.3", ["roof", "free of the walls", "0.2"]),
    ("gravity_discharge --longest 0", ["longest_s is 0", "at least 1e-06"]),
    ("gravity_discharge --speed 0.1", ["--speed"]),
]


@pytest.mark.parametrize(("line", "words"), IMPOSSIBLE, ids=[line for line, _ in IMPOSSIBLE])
def test_one_sentence_names_the_value_and_what_would_be_right(line, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scenario, *flags = line.split()
    code, err = failed(monkeypatch, capsys, "run", scenario, "--output", "run", *flags)
    assert code == 2 and err.startswith("Error: "), err
    assert not list(tmp_path.iterdir()), "something was written"
    for word in words:
        assert word in err, err

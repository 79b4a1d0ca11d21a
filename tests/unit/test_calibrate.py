"""Calibration: the paths are the law's, constants come back from made-up tests, and what is open is said."""

import json
import warnings

import numpy as np
import pytest
from PIL import Image

import taichi_silo as ts
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.laws.stress_point import StressPoint
from taichi_silo.scene import sands
from taichi_silo.studies.calibrate import whole
from taichi_silo.studies.calibrate.closed_formulas import alpha_of_peak, beta_of_stiffness, compression, first_guess
from taichi_silo.studies.calibrate.constants import NAMES, how_known, unknowns_of, width
from taichi_silo.studies.calibrate.fit import fitted
from taichi_silo.studies.calibrate.knowledge import Known, _follows
from taichi_silo.studies.calibrate.lab_tests import IndexTests, Laboratory, Oedometer
from taichi_silo.studies.calibrate.model_curves import followed_oedometer, turning_points
from taichi_silo.studies.calibrate.paths import Law, oedometer, triaxial
from taichi_silo.studies.element_tests import TESTS, through_point
from validation.calibration import case, laboratory, true_constants

KARLSRUHE = true_constants(0)[1]


def reference(data, name):
    return np.genfromtxt(data / f"{name}.csv", delimiter=",", names=True)


# the paths


@pytest.mark.parametrize("name", [f"TC_e{e}" for e in ("0.55_p50", "0.60_p200", "0.75_p500", "0.90_p50")])
def test_triaxial_paths_are_the_tightly_integrated_ones_to_1e_4(data, name):
    exact = reference(data, name)
    path = triaxial(Law(), np.array([[0.0], exact["eps1_log"][-1:]]), 1e3 * exact["sig33"][:1], exact["e"][:1, None])
    stress, e = path.at(0, exact["eps1_log"])
    assert np.abs(stress[:, 0] / (1e3 * exact["sig11"]) - 1.0).max() < 1e-4
    assert np.abs(e[:, 0] - exact["e"]).max() < 1e-4


@pytest.mark.parametrize("name", [f"OED_e{e}" for e in ("0.55", "0.60", "0.75", "0.90")])
def test_oedometer_paths_are_the_tightly_integrated_ones_to_1e_4(data, name):
    exact = reference(data, name)
    control = np.log(1e3 * exact["sig11"])
    path = oedometer(Law(), control[[0, -1], None], np.ones((1, 1)), exact["e"][:1, None])
    radial, e = path.at(0, control)
    assert np.abs(radial[:, 0] / (1e3 * exact["sig22"]) - 1.0).max() < 1e-4
    assert np.abs(e[:, 0] - exact["e"]).max() < 1e-4


@pytest.mark.parametrize("number", [1, pytest.param(4, marks=pytest.mark.long)])
def test_paths_of_other_sands_are_those_of_the_packages_element_tests_to_1e_4(number):
    _, constants = true_constants(number)
    law, e0 = GudehusBauer(**constants), 0.5 * (constants["e_d0"] + constants["e_c0"])
    rows = np.array(list(through_point(TESTS["triaxial"], law, e0, 100e3, 0.1)))
    path = triaxial(Law(**constants), np.array([[0.0], [0.1]]), np.array([100e3]), np.array([[e0]]))
    stress, e = path.at(0, rows[:, 0])
    assert np.abs(stress[:, 0] / rows[:, 1] - 1.0).max() < 1e-4
    assert np.abs(e[:, 0] - rows[:, 5]).max() < 1e-4
    rows = np.array(list(through_point(TESTS["oedometer"], law, e0, 20e3, 0.01)))
    path = oedometer(Law(**constants), np.log(rows[[0, -1], 1])[:, None], np.ones((1, 1)), np.array([[e0]]))
    radial, e = path.at(0, np.log(rows[:, 1]))
    assert np.abs(radial[:, 0] / rows[:, 2] - 1.0).max() < 1e-4
    assert np.abs(e[:, 0] - rows[:, 5]).max() < 1e-4


def test_unloading_is_that_of_the_law():
    """Compression to a stress, and extension of 0.2 % from there."""
    point = StressPoint(GudehusBauer(), [-50e3, -100e3, -50e3, 0.0], 0.6)
    stresses = [100e3]
    for strain in (-5e-6, 5e-6):
        for _ in range(10):
            point.step([0.0, strain, 0.0, 0.0], count=40)
        stresses.append(-point.stress[1])
    assert stresses[2] < stresses[1]
    path = oedometer(Law(), np.log(stresses)[:, None], np.array([[0.5]]), np.array([[0.6]]))
    assert path.void_ratio[-1, 0, 0] == pytest.approx(point.void_ratio, abs=2e-6)
    assert path.stress_Pa[-1, 0, 0] == pytest.approx(-point.stress[0], rel=2e-4)


def test_a_triaxial_path_that_turns_unloads_stiffly():
    path = triaxial(Law(), np.array([[0.0], [0.02], [0.019]]), np.array([100e3]), np.array([[0.6]]))
    top, end = path.stress_Pa[np.argmax(path.control[:, 0]), 0, 0], path.stress_Pa[-1, 0, 0]
    first = path.stress_Pa[1, 0, 0] - 100e3
    assert (top - end) / 0.001 > 0.5 * first / path.control[1, 0]
    assert end < top


# closed formulas


def test_h_s_and_n_come_back_from_bauers_own_curve():
    stress = np.geomspace(10e3, 2e6, 20)
    p = stress * (1.0 + 2.0 * (1.0 - np.sin(np.radians(30.0)))) / 3.0
    test = Oedometer("a", stress, 0.9 * np.exp(-((3.0 * p / 1e9) ** 0.3)))
    found = compression(Laboratory([test], [], IndexTests()), 30.0)
    assert found["n"].value == pytest.approx(0.3, abs=1e-9)
    assert found["granular_hardness_Pa"].value == pytest.approx(1e9, rel=1e-6)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_alpha_comes_back_from_a_peak_without_noise(number):
    """Read at the highest of 45 points; beta from two stiffnesses is coarser, as K0 is not that of Jaky."""
    _, constants = true_constants(number)
    lab = laboratory(constants, 0, noise=0.0)
    assert alpha_of_peak(lab.triaxials[0], constants) == pytest.approx(constants["alpha"], rel=0.03)
    assert beta_of_stiffness(lab.oedometers, constants) == pytest.approx(constants["beta"], rel=0.4)


# the fit


@pytest.mark.parametrize("number", [4, pytest.param(0, marks=pytest.mark.long)])
def test_constants_come_back_from_tests_with_next_to_no_noise(number):
    _, constants = true_constants(number)
    lab = laboratory(constants, number, noise=0.01)
    fit = fitted(lab, first_guess(lab))
    for name, value in constants.items():
        loose = 0.1 if name in ("granular_hardness_Pa", "e_i0") else 0.01  # the two that trade off
        assert fit.constants[name] == pytest.approx(value, rel=loose), name
    assert fit.rank == 8
    assert not fit.undetermined


@pytest.mark.parametrize("number", [2, pytest.param(7, marks=pytest.mark.long)])
def test_intervals_of_noisy_tests_hold_the_constants(number):
    """40 cases: validation/calibration.py, tests/validation/test_calibration.py."""
    rows = case(number)
    assert all(row["low"] <= row["true"] <= row["high"] for row in rows)
    assert max(row["seconds"] for row in rows) < 10.0  # of one core, six tests


def test_a_search_along_a_valley_ends_where_no_measurement_could_tell():
    """Of case 20 e_i0 is not determined: the sum of squares falls by a hundred-thousandth in each of 60 evaluations."""
    lab = laboratory(true_constants(20)[1], 20)
    fit = fitted(lab, first_guess(lab))
    assert fit.settled and fit.evaluations <= 80


def test_what_oedometers_cannot_tell_is_said():
    whole = laboratory(KARLSRUHE, 3)
    fit = fitted(lab := Laboratory(whole.oedometers, [], IndexTests()), first_guess(lab))
    assert {"critical_friction_angle_deg", "alpha"} <= set(fit.undetermined)
    assert fit.rank < 8
    low, high = fit.intervals["alpha"]
    assert high / low > 50.0  # its whole range, more or less


def test_pairs_that_trade_off_are_named():
    """Of specimens of one density the stiffness tells (e_i0 / e)^beta: beta and e_i0 trade off."""
    whole = laboratory(true_constants(1)[1], 1)
    lab = Laboratory(whole.oedometers[1:], whole.triaxials[:2], whole.index)
    fit = fitted(lab, first_guess(lab))
    pairs = {frozenset((one, other)): share for one, other, share in fit.entangled}
    assert pairs[frozenset(("beta", "e_i0"))] < -0.95
    assert fit.rank < 8


PAGE = "axial stress [kPa],void ratio\n12.5,0.842\n25,0.838\n50,0.833\n100,0.826\n200,0.817\n400,0.804\n100,0.808\n"


@pytest.fixture(scope="module")
def of_one_oedometer(tmp_path_factory):
    """The calibration of the one oedometer test of docs/how-to/calibrate.md, and its folder."""
    place = tmp_path_factory.mktemp("one")
    (place / "oedometer_loose.csv").write_text(PAGE)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return ts.calibrate(place, place / "out"), place / "out"


def test_constants_that_one_oedometer_test_leaves_open_keep_their_first_values(of_one_oedometer):
    """A compression curve knows its slope and its bend: two or three directions, no friction angle and no alpha."""
    found, folder = of_one_oedometer
    fit = found.fit
    assert 1 <= fit.rank <= 3
    assert {"critical_friction_angle_deg", "alpha", "beta", "e_c0"} <= set(fit.kept) <= set(fit.undetermined)
    for name in set(fit.kept) - {"e_d0", "e_i0"}:
        assert fit.constants[name] == pytest.approx(found.guess[name].value, rel=1e-4), name
    text = (folder / "sand.toml").read_text(encoding="utf-8")
    assert "e_c0 = 0.842 # first value, loosest specimen: the tests do not determine it" in text
    assert "d50_m = 0.0005 # usual of sands: no test says it" in text
    assert sands.sand(str(folder / "sand.toml"), 0.8).e_c0 == pytest.approx(0.842)
    lines = [line for line in text.splitlines() if line.startswith("n =")]
    assert ("#" in lines[0]) == ("n" in fit.kept)


def test_the_law_with_the_kept_constants_still_follows_the_measured_curve(of_one_oedometer):
    found, _ = of_one_oedometer
    assert found.fit.noise["void ratio"] < 0.002
    assert found.fit.settled


def test_directions_are_counted_from_singular_values():
    """Of 8 constants a Jacobian that sees two: rank 2, whatever round-off makes of the others."""
    random = np.random.default_rng(2)
    seen = np.outer(random.normal(size=40), random.normal(size=8)) * 1e9
    seen += 1e9 * np.outer(random.normal(size=40), random.normal(size=8))
    known = Known.of(seen, np.zeros((0, 8)), factor=2.0)
    assert known.rank == 2
    assert (known.covariance.diagonal() > 0.0).all()


@pytest.mark.parametrize(("share", "word"), [(0.05, "yes"), (0.3, "poorly"), (1.2, "no")])
def test_known_is_said_by_the_width_of_the_interval(share, word):
    assert how_known(share) == word


def test_an_interval_over_four_decades_of_h_s_is_poor_knowledge():
    """Of a range of 5.3 decades."""
    k = NAMES.index("granular_hardness_Pa")
    covariance = np.zeros((8, 8))
    covariance[k, k] = (2.0 * np.log(10.0) / 2.0) ** 2
    assert how_known(width("granular_hardness_Pa", unknowns_of(KARLSRUHE), covariance, 2.0)) == "poorly"


def test_a_search_without_end_is_ended_and_said(monkeypatch):
    monkeypatch.setattr("taichi_silo.studies.calibrate.fit.MOST_STEPS", 300)
    whole = laboratory(KARLSRUHE, 3)
    lab = Laboratory(whole.oedometers, [], whole.index)
    fit = fitted(lab, first_guess(lab))
    assert not fit.settled
    assert fit.evaluations < 20  # some 50 without an end


def test_a_path_takes_no_more_than_so_many_steps():
    """Sand denser than e_d0 by far, of a hardness that none has."""
    wild = dict(KARLSRUHE, granular_hardness_Pa=1e6, n=0.9, e_d0=0.9, e_c0=0.95, e_i0=0.97, alpha=1.0, beta=8.0)
    path = oedometer(Law(**wild), np.log([[1e3], [1e8]]), np.ones((1, 1)), np.array([[0.2]]))
    assert len(path.control) <= 2002


def test_residuals_that_follow_each_other_count_for_less():
    """Of an autoregressive process a mean is sqrt((1 + r) / (1 - r)) times less certain; of white noise not at all."""
    random = np.random.default_rng(1)
    white = random.normal(size=(200, 400))
    assert np.mean([_follows(one) for one in white]) == pytest.approx(1.0, abs=0.02)
    process = np.zeros((400, 200))
    for k in range(1, 400):
        process[k] = 0.9 * process[k - 1] + white[:, k]
    assert np.median([_follows(one) for one in process.T]) == pytest.approx(np.sqrt(19.0), rel=0.4)


def test_turning_points_are_those_of_load_and_unload_and_not_of_noise():
    values = np.concatenate([np.linspace(0, 10, 40), np.linspace(10, 4, 20), np.linspace(4, 12, 20)])
    noisy = values + 0.05 * np.sin(100.0 * np.arange(80))
    assert turning_points(noisy) == pytest.approx([0.0, 10.0, 4.0, 12.0], abs=0.1)
    assert turning_points(np.linspace(0, 1, 5)).tolist() == [0.0, 1.0]


def test_the_curve_beside_an_oedometer_test_unloads_where_the_test_does():
    stress = np.array([50e3, 100e3, 200e3, 400e3, 200e3, 100e3])
    control, _, e = followed_oedometer(Oedometer("a", stress, np.full(6, 0.7)), KARLSRUHE, 0.7)
    top = np.argmax(control)
    assert np.exp(control[[0, top, -1]]) == pytest.approx([50e3, 400e3, 100e3])
    assert (np.diff(e[: top + 1]) <= 0.0).all()
    assert e[top] < e[-1] < 0.5 * (e[0] + e[top])  # sand regains little of what it has lost


# the command


def left(folder, few=False):
    """A folder with the files of made-up tests: all of them, or an oedometer and a triaxial test."""
    folder.mkdir()
    lab = laboratory(KARLSRUHE, 0)
    for test in lab.oedometers[: 1 if few else None]:
        rows = "".join(f"{s / 1e3:.3f},{e:.5f}\n" for s, e in zip(test.stress_Pa, test.void_ratio, strict=True))
        (folder / test.name).write_text("axial stress [kPa],void ratio\n" + rows)
    for test in lab.triaxials[: 1 if few else None]:
        percent = 100.0 * -np.expm1(-test.strain), test.deviator_Pa / 1e3, 100.0 * test.volume_strain
        rows = "".join(f"{a:.4f},{q:.3f},{v:.4f}\n" for a, q, v in zip(*percent, strict=True))
        head = f"# cell pressure = {test.cell_Pa / 1e3:g} kPa\n# e0 = {test.void_ratio:.5f}\n"
        (folder / test.name).write_text(f"{head}axial strain [%],q [kPa],volumetric strain [%]\n{rows}")
    index = lab.index
    numbers = f"{index.friction_angle_deg[0]:.2f},{index.e_min[0]:.4f},{index.e_max[0]:.4f},2.66,0.4\n"
    (folder / "index.csv").write_text("angle of repose [deg],e_min,e_max,grain density [g/cm3],d50 [mm]\n" + numbers)
    return folder


def test_the_command_leaves_a_sand_that_a_run_takes_and_all_numbers_in_one_object(tmp_path, said):
    lab, output = left(tmp_path / "quarry"), tmp_path / "out"
    code, out, shown = said("calibrate", lab, "--output", output, "--json")
    assert code == 0
    assert "Constants of quarry" in shown
    names = ["calibration.csv", "compression.png", "sand.toml", "shearing.png"]
    assert sorted(file.name for file in output.iterdir()) == names
    for name in (names[1], names[3]):
        image = np.asarray(Image.open(output / name).convert("RGB"))
        assert np.mean(np.any(image < 200, axis=2)) > 0.01
    found = json.loads(out)
    assert set(found) == {"sand", "constants", "rank", "trade_off", "noise", "void_ratios", "remarks", "files"}
    for row in found["constants"]:
        assert row["low"] <= row["value"] <= row["high"]
        assert row["value"] == pytest.approx(found["sand"][row["constant"]], rel=1e-5)
    sand = sands.sand(str(output / "sand.toml"), 0.65)
    assert (sand.grain_density_kg_per_m3, sand.d50_m) == (2660.0, pytest.approx(0.4e-3))
    assert sand.n == pytest.approx(KARLSRUHE["n"], abs=0.03)
    (lab / "index.csv").unlink()
    for file in lab.glob("triaxial*"):
        file.unlink()
    code, out, _ = said("calibrate", lab, "--output", output)
    assert code == 0
    assert "φ_c is not determined: sand.toml keeps its first value, 32 deg (usual of sands)." in out
    assert "takes it; in it φ_c, " in out and "are only typical" in out
    assert "No test gives the grain density; sand.toml has 2650." in out
    assert not (output / "shearing.png").exists()  # an earlier calibration is replaced as a whole


def test_the_sand_of_another_lab_is_replaced_only_when_asked(tmp_path, said, monkeypatch):
    """Runs take sand.toml: another sand in its place would change them without a word."""
    fits = []  # of alike tests, so that one is enough
    monkeypatch.setattr(whole, "fitted", lambda *given: fits.append(fits[0] if fits else fitted(*given)) or fits[0])
    one, other, output = left(tmp_path / "one", few=True), left(tmp_path / "other", few=True), tmp_path / "out"
    assert said("calibrate", one, "--output", output)[0] == 0
    assert said("calibrate", one, "--output", output)[0] == 0  # the same lab once more
    first = (output / "sand.toml").read_bytes()
    code, _, err = said("calibrate", other, "--output", output)
    assert code == 2 and len(fits) == 2
    assert f"output {output} holds another sand (taichi-silo calibrate {one})" in err
    assert "give another folder, or --overwrite to replace it" in err
    assert (output / "sand.toml").read_bytes() == first
    assert said("calibrate", other, "--output", output, "--overwrite")[0] == 0
    assert 'title = "other, ' in (output / "sand.toml").read_text()
    (output / "sand.toml").write_text("# mine\nn = 0.3\n")
    with pytest.raises(ts.BadInput, match=r"holds another sand \(without a source\); .* overwrite=True"):
        ts.calibrate(other, output)


def test_from_python_nothing_is_written_unless_asked(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = ts.calibrate(left(tmp_path / "lab", few=True))
    assert found.files == []
    assert [file.name for file in tmp_path.iterdir()] == ["lab"]
    assert found.table.constant.tolist()[0] == "critical_friction_angle_deg"
    assert isinstance(found, ts.Calibration)


def test_what_cannot_be_calibrated_is_refused_before_anything_is_written(tmp_path, said):
    lab, output = tmp_path / "lab", tmp_path / "out"
    for files, words in (
        (None, "there is no folder"),
        ({}, "0 tables"),
        ({"a.csv": "angle of repose [deg]\n33\n"}, "has no curve"),
        ({"a.csv": "time [s],load [N]\n1,2\n"}, "a.csv has the columns time [s], load [N]; it must have axial stress"),
    ):
        if files is not None:
            lab.mkdir(exist_ok=True)
            for name, text in files.items():
                (lab / name).write_text(text)
        code, _, err = said("calibrate", lab, "--output", output)
        assert code == 2
        assert words in err
        assert err.count("\n") == 1
        assert not output.exists()


def test_one_file_that_is_no_table_has_its_own_sentence(tmp_path, said):
    (tmp_path / "tiny.toml").write_text("[silo]\n")
    code, _, err = said("calibrate", tmp_path / "tiny.toml", "--output", tmp_path / "out")
    assert code == 2
    assert err.startswith(f"Error: lab {tmp_path / 'tiny.toml'} is not a table: it must be a file ")
    assert ".csv, .txt" in err and err.count("\n") == 1

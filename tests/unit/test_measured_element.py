"""Measured points over the curve of an element test: in its units, at its pressure, with its sign."""

import numpy as np
import pandas as pd
import pytest

import taichi_silo as ts
from taichi_silo.studies.element_tests import COLUMNS
from taichi_silo.studies.measured_element import read_measured


@pytest.fixture(scope="module")
def dense():
    """A triaxial test of dense sand."""
    return ts.element_test("triaxial", ts.Sand(void_ratio=0.58), pressure_Pa=100e3, strain=0.1)


def laboratory(file, curve, sign=-1.0, every=20):
    """The curve as a laboratory writes it: engineering strain, q in kPa, gain (or loss) of volume as positive."""
    rows, e = curve.iloc[::every], curve.void_ratio.iloc[0]
    table = pd.DataFrame({
        "axial strain [%]": 100.0 * -np.expm1(-rows.strain),
        "q [kPa]": 1e-3 * (rows.sigma_11_Pa - rows.sigma_22_Pa),
        "volumetric strain [%]": sign * 100.0 * (e - rows.void_ratio) / (1.0 + e),
    })  # fmt: skip
    file.write_text(f"# cell pressure = 100 kPa\n# e0 = {e}\n" + table.to_csv(index=False))
    return file


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_was_computed_comes_back_as_measured_whatever_the_sign_of_its_volume(dense, tmp_path, sign):
    file = laboratory(tmp_path / "dense.csv", dense.curve, sign)
    found = ts.element_test("triaxial", strain=0.1, measured=file)
    assert (found.scene.pressure_Pa, found.scene.sand.void_ratio) == (100e3, 0.58)  # those of the file
    (one,) = found.measured
    away = one.deviations(found.curve)
    assert away["friction_angle_deg"] < 0.01 and away["void_ratio"] < 1e-5
    assert one.curve.sigma_33_Pa.iloc[3] == pytest.approx(100e3)
    assert found.words[1] == (
        "dense.csv: the computed curve is off (rms) in friction angle by 0.00 deg, void ratio by 0.0000"
    )


def test_other_pressures_and_densities_are_said(dense, tmp_path):
    file = laboratory(tmp_path / "dense.csv", dense.curve)
    found = ts.element_test("triaxial", ts.Sand(void_ratio=0.7), pressure_Pa=50e3, strain=0.05, measured=[file])
    words = " ".join(found.words)
    assert "dense.csv was measured at 100 kPa, computed is 50 kPa" in words
    assert "dense.csv begins at a void ratio of 0.58, the computed one at 0.7" in words
    assert found.measured[0].deviations(found.curve)["friction_angle_deg"] > 2.0


def test_the_figure_has_the_points_over_the_curves(dense, tmp_path):
    file = laboratory(tmp_path / "dense.csv", dense.curve)
    found = ts.element_test("triaxial", strain=0.1, measured=file)
    stresses, friction, density = found.figure().axes
    for panel, column, scale in ((stresses, "sigma_11_Pa", 1e-3), (friction, "friction_angle_deg", 1.0),
                                 (density, "void_ratio", 1.0)):  # fmt: skip
        points = [line for line in panel.get_lines() if line.get_marker() == "o" and len(line.get_xdata())]
        assert points[0].get_ydata() == pytest.approx(scale * found.measured[0].curve[column].to_numpy())
        assert points[0].get_xdata() == pytest.approx(100.0 * found.measured[0].curve.strain.to_numpy())
    (legend,) = found.figure().legends
    assert [text.get_text() for text in legend.get_texts()] == ["measured: dense.csv"]


def test_an_oedometer_test_stands_where_its_void_ratios_are(tmp_path):
    computed = ts.element_test("oedometer", ts.Sand(void_ratio=0.8), strain=0.03).curve
    rows = computed.iloc[40::40]
    (tmp_path / "o.csv").write_text(
        pd.DataFrame({"axial stress [kPa]": 1e-3 * rows.sigma_11_Pa, "void ratio": rows.void_ratio}).to_csv(index=False)
    )
    one = read_measured("oedometer", tmp_path / "o.csv", 0.8)
    assert np.interp(one.curve.strain, computed.strain, computed.sigma_11_Pa) == pytest.approx(
        one.curve.sigma_11_Pa.to_numpy(), rel=1e-3
    )


def test_a_shear_test_is_read_with_the_stresses_of_its_plate(tmp_path):
    (tmp_path / "s.csv").write_text(
        "shear strain [%];shear stress [kPa];normal stress [kPa]\n1;20,5;50\n2;30;50\n4;35;50\n8;33;50\n"
    )
    one = read_measured("simple-shear", tmp_path / "s.csv", 0.6)
    assert one.curve.strain.tolist() == [0.01, 0.02, 0.04, 0.08] and one.pressure_Pa == 50e3
    assert one.curve.sigma_12_Pa.tolist() == [20.5e3, 30e3, 35e3, 33e3]
    assert list(one.curve.columns) == list(COLUMNS)


@pytest.mark.parametrize(
    ("test", "text", "words"),
    [
        ("triaxial", "strain [%],force\n1,2\n", "has no axial strain [%] with q [kPa] or sigma1 [kPa]"),
        ("simple-shear", "axial strain [%],q [kPa]\n1,2\n", "has no shear strain [%] with shear stress [kPa]"),
        (
            "simple-shear",
            "shear strain [%],shear stress [kPa]\n1,2\n",
            "has 1 points of shear; it must have at least 3",
        ),
        ("oedometer", "void ratio\n0.6\n", "has no axial stress [kPa]; an oedometer test has it, with void ratio"),
        ("triaxial-extension", "a\n1\n", "measured curves are drawn beside oedometer, triaxial, plane-strain"),
    ],
)
def test_a_file_of_another_test_is_refused_in_a_sentence(tmp_path, test, text, words):
    (tmp_path / "lab.csv").write_text(text)
    with pytest.raises(ts.BadInput) as refused:
        read_measured(test, tmp_path / "lab.csv", 0.6)
    assert words in str(refused.value)


def test_the_command_draws_them_too(said, dense, tmp_path):
    file = laboratory(tmp_path / "dense.csv", dense.curve)
    code, out, err = said("run", "element_test", "triaxial", "--measured", file, "--strain", "0.1", "--output",
                          tmp_path / "out")  # fmt: skip
    assert (code, err) == (0, "")
    assert "dense.csv: the computed curve is off (rms) in friction angle by 0.00 deg" in out
    assert (tmp_path / "out" / "figures" / "curve.png").stat().st_size > 10_000
    for asked, words in (({"test": "shear"}, "test is shear; it must be one of oedometer"),
                         ({"test": "triaxial", "strain": 0.9}, "strain is 0.9; it must be above 0 and at most 0.5"),
                         ({"test": "triaxial", "shape": "cubic"}, "shape is cubic")):  # fmt: skip
        with pytest.raises(ts.BadInput, match=words):
            ts.element_test(**asked)

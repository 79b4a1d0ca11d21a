"""Laboratory files are read as laboratories bring them, or refused with what would do."""

import numpy as np
import pytest

from taichi_silo.errors import BadInput
from taichi_silo.studies.calibrate.lab_files import read_laboratory
from taichi_silo.studies.calibrate.model_curves import with_signs
from taichi_silo.studies.measured_tables import read_table
from validation.calibration import laboratory, true_constants

OEDOMETER = "axial stress [kPa],void ratio\n50,0.80\n100,0.79\n200,0.78\n"
OEDOMETERS = {
    "plain": OEDOMETER,
    "units row": "sigma_v,e\nkPa,-\n50,0.80\n100,0.79\n200,0.78\n",
    "German": "Vertikalspannung [kN/m²];Porenzahl\r\n50;0,80\r\n100;0,79\r\n200;0,78\r\n",
    "slash": "σ_v / kPa;e\n50;0,80\n100;0,79\n200;0,78\n",
    "MPa": "vertical stress (MPa),void ratio\n0.05,0.80\n0.1,0.79\n0.2,0.78\n",
    "psi": "vertical_stress_psi,e\n7.251887,0.80\n14.503774,0.79\n29.007548,0.78\n",
    "compression negative": "axial stress [kPa],void ratio\n-50,0.80\n-100,0.79\n-200,0.78\n",
    "no values": "axial stress [kPa],void ratio\n0,0.81\n50,0.80\n80,NaN\n90,\n100,0.79\n200,0.78\n",
    "porosity": "axial stress [kPa],porosity [%]\n50,44.444444\n100,44.134078\n200,43.820225\n",
    "title and remarks": "Quarry 7, test 3\n% dry\n// by hand\naxial stress [kPa],void ratio\n50,0.80\n"
    "100,0.79\n200,0.78\n",
    "strain": "% e0: 0.80\naxial stress [kPa],axial strain [%]\n50,0\n100,0.5555556\n200,1.1111111\n",
    "settlement": "e0;0,80\nh0;20;mm\naxial stress [kPa];settlement [mm]\n50;0\n100;0,1111111\n200;0,2222222\n",
    "radial stress": "axial stress [kPa],radial stress [kPa],void ratio\n50,25,0.80\n100,50,0.79\n200,100,0.78\n",
    "other columns": "time [s],axial stress [kPa],void ratio,remark\n0,50,0.80,a\n1,100,0.79,\n2,200,0.78,b\n",
}
HEAD = "# cell pressure: 100 kPa\n# e0 = 0.60\n"
TRIAXIALS = {
    "plain": HEAD + "axial strain [%],q [kPa],volumetric strain [%]\n1,200,0.1\n2,300,-0.5\n3,350,-1.0\n",
    "fractions": HEAD + "eps_1 [-],q [MPa],eps_v [-]\n0.01,0.2,0.001\n0.02,0.3,-0.005\n0.03,0.35,-0.01\n",
    "compression negative": HEAD + "axial strain [%],q [kPa],eps_v [%]\n-1,-200,-0.1\n-2,-300,0.5\n-3,-350,1.0\n",
    "dilation": HEAD + "axial strain [%],q [kPa],dilation [%]\n1,200,-0.1\n2,300,0.5\n3,350,1.0\n",
    "columns": "axial strain [%],sigma1 [kPa],sigma3 [kPa],e0,eps_v [%]\n1,300,100,0.6,0.1\n"
    "2,400,100,0.6,-0.5\n3,450,100,0.6,-1\n",
    "p and q": "# e0 = 0.6\naxial strain [%],p [kPa],q [kPa],eps_v [%]\n1,166.6667,200,0.1\n"
    "2,200,300,-0.5\n3,216.66667,350,-1\n",
    "void ratio": "# cell pressure 100 kPa\n# e0 0.6\naxial strain [%],q [kPa],void ratio\n1,200,0.5984\n"
    "2,300,0.608\n3,350,0.616\n",
    "logarithmic": HEAD + "log axial strain [-],q [kPa],eps_v [%]\n0.01005034,200,0.1\n"
    "0.02020271,300,-0.5\n0.03045921,350,-1\n",
    "density": "# cell pressure = 100 kPa\n# dry density = 1.65625 g/cm3\n# grain density = 2.65 g/cm3\n"
    "axial strain [%],q [kPa],eps_v [%]\n1,200,0.1\n2,300,-0.5\n3,350,-1\n",
    "German": "Zelldruck;100;kPa\ne0;0,60\nAxialdehnung [%];Deviatorspannung [kPa];Volumendehnung [%]\n"
    "1;200;0,1\n2;300;-0,5\n3;350;-1\n",
}  # fmt: skip


def lab(tmp_path, text, name="a.csv", encoding="utf-8"):
    (tmp_path / name).write_bytes(text.encode(encoding))
    return read_laboratory(tmp_path)


def refusal(tmp_path, text):
    """The sentence with which it is refused."""
    with pytest.raises(BadInput) as refused:
        lab(tmp_path, text)
    return str(refused.value)


@pytest.mark.parametrize("kind", OEDOMETERS)
def test_an_oedometer_test_is_read(tmp_path, kind):
    (test,) = lab(tmp_path, OEDOMETERS[kind]).oedometers
    assert test.stress_Pa == pytest.approx([50e3, 100e3, 200e3], rel=1e-5)
    assert test.void_ratio == pytest.approx([0.80, 0.79, 0.78], abs=1e-6)


@pytest.mark.parametrize("kind", TRIAXIALS)
def test_a_triaxial_test_is_read(tmp_path, kind):
    (test,) = lab(tmp_path, TRIAXIALS[kind]).triaxials
    assert test.cell_Pa == pytest.approx(100e3, rel=1e-5)
    assert test.void_ratio == pytest.approx(0.60, abs=1e-6)
    assert test.strain == pytest.approx(-np.log([0.99, 0.98, 0.97]), rel=1e-5)
    assert test.deviator_Pa == pytest.approx([200e3, 300e3, 350e3], rel=1e-5)
    assert test.volume_strain == pytest.approx([0.001, -0.005, -0.01], abs=1e-6)


STRAINED = "# cell pressure: 100 kPa\n# e0 = 0.60\naxial strain [%],q [kPa]"
NOT_DRAINED_COMPRESSION = {
    "pore pressure": (
        STRAINED + ",pore pressure [kPa]\n1,100,30\n2,150,20\n4,200,-10\n",
        ["the pore pressure changes by 40 kPa", "undrained", "drained test in compression"],
    ),
    "u": (STRAINED + ",Δu [kPa]\n1,100,30\n2,150,20\n4,200,-10\n", ["the pore pressure changes by 40 kPa"]),
    "constant volume": (
        STRAINED + ",volumetric strain [%]\n1,100,0\n2,150,0\n4,200,0\n8,260,0\n",
        ["volume strain is 0 in every row", "is the test undrained?", "leave out its column"],
    ),
    "extension": (
        STRAINED + ",volumetric strain [%]\n-1,-40,0.1\n-2,-50,0\n-4,-60,-0.5\n",
        ["strain is negative", "cell pressure of 100 kPa is positive", "q of 60 kPa is below it", "means extension"],
    ),
    "extension by the axial stress": (
        "# e0 = 0.6\n# cell pressure: 100 kPa\naxial strain [%],sigma1 [kPa]\n-1,60\n-2,50\n-4,40\n",
        ["q of 60 kPa is below it", "means extension"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", NOT_DRAINED_COMPRESSION)
def test_undrained_and_extension_tests_are_refused_by_their_numbers(tmp_path, kind):
    text, words = NOT_DRAINED_COMPRESSION[kind]
    said = refusal(tmp_path, text)
    assert all(word in said for word in ["a.csv", *words]), said


@pytest.mark.parametrize("column", ["back pressure [kPa]", "pore pressure [kPa]", "u [mm]"])
def test_a_back_pressure_that_is_kept_is_passed_over(tmp_path, column):
    whole = lab(tmp_path, f"{STRAINED},{column}\n1,200,300\n2,300,301\n3,350,300\n")
    assert whole.triaxials[0].deviator_Pa == pytest.approx([200e3, 300e3, 350e3])
    assert whole.remarks == [f"a.csv: passed over {column}"]


def test_compression_that_is_negative_throughout_is_no_extension(tmp_path):
    text = "# e0 = 0.6\naxial strain [%],q [kPa],sigma3 [kPa]\n-1,-40,-100\n-2,-50,-100\n-4,-60,-100\n"
    assert lab(tmp_path, text).triaxials[0].deviator_Pa[-1] == 60e3


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings_of_spreadsheets_are_known(tmp_path, encoding):
    assert lab(tmp_path, OEDOMETERS["German"], "a.txt", encoding).oedometers[0].void_ratio[2] == 0.78


def test_index_tests_are_read_with_densities_as_void_ratios(tmp_path):
    text = "angle of repose [°],rho_max [g/cm3],rho_min [g/cm3],grain density [t/m3],d50 [mm]\n33,1.767,1.395,2.65,0.4"
    text += "\n34,,,,\n"
    index = lab(tmp_path, OEDOMETER, "b.csv") and lab(tmp_path, text).index
    assert index.friction_angle_deg == [33.0, 34.0]
    assert index.e_min == pytest.approx([0.49972], abs=1e-5)
    assert index.e_max == pytest.approx([0.89964], abs=1e-5)
    assert index.d50_m == pytest.approx([0.4e-3])


def test_unloading_is_read_and_told_apart(tmp_path):
    text = OEDOMETER + "100,0.782\n50,0.785\n100,0.783\n200,0.779\n400,0.76\n"
    (test,) = lab(tmp_path, text).oedometers
    assert test.loading.tolist() == [True, True, True, False, False, False, False, True]


def test_a_gain_of_volume_counted_as_positive_is_noticed_by_the_law():
    """Dense sand gains volume: with the other sign, and no word about it in the file, it would lose it."""
    _, constants = true_constants(0)
    whole = laboratory(constants, 1)
    tests = [
        type(one)(**{**vars(one), "volume_strain": -one.volume_strain, "sign_known": False}) for one in whole.triaxials
    ]
    found = with_signs(type(whole)(whole.oedometers, tests, whole.index), constants)
    for one, right in zip(found.triaxials, whole.triaxials, strict=True):
        assert one.volume_strain == pytest.approx(right.volume_strain)
    assert len(found.remarks) == len(tests)
    assert with_signs(whole, constants).triaxials[0].volume_strain is whole.triaxials[0].volume_strain


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "axial stress,void ratio\n50,0.8\n",
            ["axial stress has no unit", "Pa, kPa, MPa", "such as axial stress [Pa]"],
        ),
        ("axial stress [lb],void ratio\n50,0.8\n", ["the unit lb", "kPa"]),
        ("axial stress [kPa],void ratio\n50,0.8\n100,0.79\n", ["2 points of first loading", "at least 3"]),
        ("axial stress [kPa],void ratio\n50,80\n100,79\n200,78\n", ["void ratio is 80", "between 0.05 and 10"]),
        ("axial stress [kPa],void ratio\n50,0.8\n100,x\n", ["line 3", "void ratio is x", "number"]),
        ("axial stress [kPa],axial strain [%]\n50,0\n100,1\n200,2\n", ["no e0 (initial void ratio)", "# e0 = 0.65"]),
        (
            "# e0 = 0.6\naxial strain [%],q [kPa]\n1,2\n2,3\n3,4\n",
            ["no cell pressure [kPa]", "# cell pressure = 100 kPa"],
        ),
        ("# e0 = 0.6\n# cell pressure = 0.1\naxial strain [%],q [kPa]\n1,2\n", ["cell pressure has no unit"]),
        (HEAD + "axial strain [-],q [kPa]\n1,2\n2,3\n15,4\n", ["strain is 15", "is its unit right?"]),
        (HEAD + "axial strain [%],q [kPa]\n,2\n,3\n", ["no values of the axial strain"]),
        ("# undrained\n" + HEAD + "axial strain [%],q [kPa]\n1,2\n", ["undrained", "drained test in compression"]),
        ("# e0=0.6\naxial strain [%],q [kPa],sigma3 [kPa]\n1,2,100\n2,3,150\n3,4,200\n", ["cell pressure changes"]),
        ("rho_max [g/cm3],rho_min [g/cm3]\n1.7,1.4\n", ["no grain density"]),
        ("angle of repose [deg]\n3.3\n", ["friction angle is 3.3 deg", "between 10 and 60"]),
        (HEAD + "axial strain [%],q [kPa]\n1,0\n2,0\n3,0\n", ["deviator is 0 Pa", "is its unit right?"]),
        ("rho_max [g/cm3],rho_min [g/cm3],rho_s [g/cm3]\n0,1.4,2.65\n", ["densest is 0 kg/m3"]),
        ("load [kN],way [mm]\n1,2\n", ["load [kN], way [mm]", "axial stress [kPa] with void ratio (oedometer)"]),
        ("", ["is empty", "axial stress [kPa]"]),
    ],
)
def test_what_cannot_be_understood_is_refused_with_what_would_do(tmp_path, text, words):
    with pytest.raises(BadInput) as caught:
        lab(tmp_path, text)
    assert all(word in str(caught.value) for word in ["a.csv", *words]), caught.value
    assert not str(caught.value).endswith(".")


def test_a_spreadsheet_is_not_passed_over_in_silence(tmp_path):
    (tmp_path / "triaxial.xlsx").write_bytes(b"PK")
    assert lab(tmp_path, OEDOMETER).remarks == ["triaxial.xlsx is passed over; save it as CSV"]


def test_a_folder_that_is_none_is_refused(tmp_path):
    with pytest.raises(BadInput, match="there is no folder"):
        read_laboratory(tmp_path / "lab")
    with pytest.raises(BadInput, match="0 tables"):
        read_laboratory(tmp_path)


def test_numbers_are_stated_in_words_above_the_columns(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("# e0 = 0,65\n% Zelldruck: 1.5e2 kPa\nProbe;7\n// date 12.5.2011\na;b\n1;2\n")
    found = read_table(file).stated()
    assert found["e0"] == (0.65, "")
    assert found["Zelldruck"] == (150.0, "kPa")
    assert found["Probe"] == (7.0, "")


@pytest.mark.parametrize("text", [
    "# cell pressure = 100 kPa, e0 = 0,65, grain density = 2.65 g/cm3\na;b\n1;2\n",
    "// sample of May; cell pressure: 100 kPa; e0: 0.65; grain density: 2.65 g/cm3\na,b\n1,2\n",
])  # fmt: skip
def test_several_numbers_may_be_stated_on_one_line(tmp_path, text):
    file = tmp_path / "a.csv"
    file.write_text(text)
    found = read_table(file).stated()
    assert found["cell pressure"] == (100.0, "kPa") and found["e0"] == (0.65, "")
    assert found["grain density"] == (2.65, "g/cm3")


IMPOSSIBLE = {
    "void ratio rises": (
        "axial stress [kPa],void ratio\n100,0.6\n200,0.7\n400,0.9\n",
        "the void ratio rises from 0.6 at 100 kPa to 0.7 at 200 kPa; it must fall as the stress rises",
    ),
    "void ratio stays": (
        "axial stress [kPa],void ratio\n100,0.6\n200,0.6\n400,0.6\n",
        "the void ratio is 0.6 at 100 kPa and 0.6 at 400 kPa; it must fall",
    ),
    "one step up": ("axial stress [kPa],void ratio\n50,0.8\n100,0.7\n200,0.75\n400,0.6\n", "rises from 0.7"),
    "settlement falls": (
        "# e0 = 0.8\n# initial height = 20 mm\naxial stress [kPa],settlement [mm]\n50,1\n100,0.5\n200,0.1\n",
        "the void ratio rises",
    ),
    "q of another unit": (
        HEAD + "axial strain [%],q [MPa],eps_v [%]\n1,200,0.1\n2,300,-0.5\n3,350,-1\n",
        "a friction angle of 88 deg; it must be below 70",
    ),
    "volume of another unit": (
        HEAD + "axial strain [%],q [kPa],eps_v [-]\n1,200,0.1\n2,300,-0.5\n3,350,-1\n",
        "volume strain is 0.1 at an axial strain of 0.01",
    ),
    "limits the wrong way round": ("e_min,e_max\n0.9,0.6\n", "e_min is 0.9 and e_max 0.6; e_min must be below e_max"),
}  # fmt: skip


@pytest.mark.parametrize("kind", IMPOSSIBLE)
def test_what_no_sand_does_is_refused_before_any_fit(tmp_path, kind):
    text, words = IMPOSSIBLE[kind]
    said = refusal(tmp_path, text)
    assert words in said and "right" in said and said.endswith("?")


def test_noise_of_an_oedometer_test_is_no_rise(tmp_path):
    (test,) = lab(tmp_path, "axial stress [kPa],void ratio\n50,0.8\n60,0.803\n100,0.79\n200,0.78\n").oedometers
    assert len(test.void_ratio) == 4


def test_a_sign_does_not_hang_on_first_values_that_noise_has_led_astray(tmp_path):
    """Of five noisy points of an oedometer h_s was 100 GPa: dense sand would have lost volume then."""
    rows = [
        "0.162,44.4,0.042",
        "1.131,275.8,0.346",
        "2.090,433.1,-0.043",
        "3.072,478.3,-0.500",
        "4.012,493.3,-1.135",
        "4.944,471.8,-1.715",
        "5.897,451.3,-2.274",
        "6.810,414.4,-2.731",
        "7.744,407.4,-3.251",
        "8.639,374.9,-3.607",
        "9.525,363.5,-4.076",
        "10.432,359.4,-4.435",
        "11.301,351.9,-4.797",
        "12.190,331.0,-5.063",
    ]
    (tmp_path / "dense.csv").write_text(
        "\n".join(["# cell pressure: 100 kPa, e0: 0.66", "axial strain [%],q [kPa],volumetric strain [%]", *rows])
    )
    astray = {"critical_friction_angle_deg": 32.95, "granular_hardness_Pa": 1e11, "n": 0.1, "alpha": 0.15,
              "beta": 0.776, "e_i0": 1.081, "e_c0": 0.94, "e_d0": 0.61}  # fmt: skip
    whole = read_laboratory(tmp_path)
    assert with_signs(whole, astray).triaxials[0].volume_strain[-1] == whole.triaxials[0].volume_strain[-1] < 0.0

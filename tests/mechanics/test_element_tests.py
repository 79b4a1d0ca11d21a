"""Element tests through the whole method: one cell, real plates, a fluid's pressure; against the law alone."""

import numpy as np
import pandas as pd
import pytest

from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.scene.scene import Sand
from taichi_silo.studies import element_tests
from taichi_silo.studies.element_tests import COLUMNS, TESTS, ElementScene, curve_of

pytestmark = pytest.mark.usefixtures("afresh")
CASES = [
    ("oedometer", 0.60, 1e3, 0.04),
    ("triaxial", 0.60, 50e3, 0.2),
    ("triaxial", 0.90, 500e3, 0.2),
    ("triaxial-extension", 0.60, 50e3, 0.2),
    ("plane-strain", 0.55, 50e3, 0.2),
    ("plane-strain", 0.75, 200e3, 0.2),
    ("simple-shear", 0.60, 50e3, 0.2),
    ("simple-shear", 0.90, 200e3, 0.2),
    ("simple-shear-constant-volume", 0.75, 50e3, 0.2),
]


def curve(test, void_ratio, pressure, strain, through, stress_filter="patch", **sand):
    scene = ElementScene(
        test=test, sand=Sand(void_ratio=void_ratio, **sand), pressure_Pa=pressure, strain=strain, through=through,
        stress_filter=stress_filter,
    )  # fmt: skip
    return pd.DataFrame(curve_of(scene), columns=COLUMNS)


def error(method, exact):
    """Largest difference of a stress, over the largest stress at that strain; and of the void ratio."""
    strain = method.strain.abs()
    size = exact[[c for c in COLUMNS if c.startswith("sigma")]].abs().max(axis=1)
    worst = 0.0
    for column in COLUMNS[1:5]:
        wanted = np.interp(strain, exact.strain.abs(), exact[column])
        worst = max(worst, np.max(np.abs(method[column] - wanted) / np.interp(strain, exact.strain.abs(), size)))
    void_ratio = np.interp(strain, exact.strain.abs(), exact.void_ratio)
    return worst, np.max(np.abs(method.void_ratio - void_ratio))


OFTEN = ("oedometer", "triaxial", "plane-strain", "simple-shear")  # the others with `make test-long`
FIRST = [next(case for case in CASES if case[0] == test) for test in OFTEN]


@pytest.mark.parametrize(
    "case", [case if case in FIRST else pytest.param(case, marks=pytest.mark.long) for case in CASES],
    ids=lambda case: f"{case[0]}-e{case[1]:.2f}-{case[2] / 1e3:g}kPa",
)  # fmt: skip
def test_the_method_is_within_one_per_cent_of_the_law_up_to_20_per_cent_of_strain(case):
    worst, void_ratio = error(curve(*case, "mpm"), curve(*case, "point"))
    assert worst < 0.01
    assert void_ratio < 5e-4


@pytest.mark.parametrize(
    ("name", "test", "void_ratio", "pressure", "columns"),
    [
        ("PSC_e0.55_p50", "plane-strain", 0.55, 50e3, ("sig11", "sig33")),
        ("TC_e0.60_p500", "triaxial", 0.60, 500e3, ("sig11", "sig33")),
        ("SS_e0.60_s50", "simple-shear", 0.60, 50e3, ("sig11", "sig12")),
    ],
)
def test_the_law_alone_gives_the_reference_curve(data, name, test, void_ratio, pressure, columns):
    """The element test's own driver, row by row, against tight integration (spline between its rows)."""
    exact = np.genfromtxt(data / f"{name}.csv", delimiter=",", names=True)
    ours = curve(test, void_ratio, pressure, 0.2, "point")
    strain = exact["gamma" if TESTS[test].sheared else "eps1_log"]
    near = (strain > 0.01) & (strain < 0.2)
    size = np.maximum.reduce([exact[c] for c in columns])[near]
    for column in columns:
        found = np.interp(strain[near], ours.strain, ours[f"sigma_{column[3:]}_Pa"]) / 1e3
        assert np.abs(found - exact[column][near]).max() < 1e-3 * size.max()


@pytest.mark.parametrize("test", ["plane-strain", "simple-shear"])
def test_the_patch_filter_leaves_the_curve_of_an_element_test_alone(test):
    """Stress alike everywhere is a linear field."""
    found = [curve(test, 0.60, 50e3, 0.1, "mpm", stress_filter=name) for name in ("patch", "none")]
    size = max(found[1][column].abs().max() for column in COLUMNS if column.startswith("sigma"))
    for column in COLUMNS[1:5]:
        assert np.abs(found[0][column] - found[1][column]).max() <= 1e-4 * size


def test_intergranular_strain_goes_through_the_method_too():
    case = ("triaxial", 0.60, 50e3, 0.1)
    worst, _ = error(curve(*case, "mpm", law="intergranular"), curve(*case, "point", law="intergranular"))
    assert worst < 0.01


def test_with_more_cells_dense_sand_localises_and_is_no_element_any_more(monkeypatch):
    """Why one cell: beyond the first bifurcation homogeneous strain is not the only solution."""
    monkeypatch.setattr(element_tests, "CELLS", 4)
    monkeypatch.setattr(element_tests, "PER_AXIS", 1)
    case = ("plane-strain", 0.60, 50e3, 0.1)
    rows, exact = curve(*case, "mpm"), curve(*case, "point")
    before = rows[rows.strain < 0.01]
    assert error(before, exact)[0] < 0.01
    assert error(rows, exact)[0] > 0.1


def test_the_papers_stresses_and_what_they_cannot_be():
    """Plane strain at e0 = 0.75 has no 40 deg and at e0 = 0.90 no peak: homogeneous states bound the specimen's."""
    medium, loose = (curve("plane-strain", e, 50e3, 0.36, "point") for e in (0.75, 0.90))
    assert medium.friction_angle_deg.max() == pytest.approx(36.66, abs=0.02)
    assert loose.friction_angle_deg.idxmax() == len(loose) - 1
    assert loose.friction_angle_deg[np.searchsorted(loose.strain, -np.log(0.96))] == pytest.approx(31.0, abs=0.1)


def test_critical_friction_angles():
    """30 deg in triaxial compression and extension, 34.3 in plane strain, 29.4 on the plate of a shear box."""
    law = GudehusBauer()
    s, ends = 0.41, {}
    for name in ("triaxial", "plane-strain"):
        ends[name] = curve(name, 0.79 if name == "triaxial" else 0.785, 50e3, s, "point").friction_angle_deg.iloc[-1]
    sheared = curve("simple-shear", 0.797, 50e3, 2.0, "point").iloc[-1]
    assert ends["triaxial"] == pytest.approx(law.critical_friction_angle_deg, abs=0.2)
    assert ends["plane-strain"] == pytest.approx(34.345, abs=0.2)
    assert np.degrees(np.arctan2(sheared.sigma_12_Pa, sheared.sigma_22_Pa)) == pytest.approx(29.431, abs=0.1)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"pressure_Pa": -5e3}, "equal to 100"),
        ({"sand": {"void_ratio": 0.511}, "pressure_Pa": 1000.0}, None),
        ({"sand": {"void_ratio": 1.29}, "pressure_Pa": 500e3}, "e_i = 1.18"),
        ({"sand": {"void_ratio": 0.50}}, "e_d0"),
        ({"strain": 0.7}, "at most 0.5"),
        ({"test": "sheer"}, "triaxial-extension"),
    ],
)
def test_impossible_tests_are_refused_with_the_valid_range(change, words):
    values = {"test": "triaxial", **change}
    if words is None:
        ElementScene.model_validate(values)
        return
    with pytest.raises(ValueError, match=words):
        ElementScene.model_validate(values)

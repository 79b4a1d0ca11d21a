"""The biaxial test ends with words that a known band, peak and dilatancy make plain."""

import numpy as np
import pandas as pd
import pytest

from validation.biaxial.words import dilatancy_deg, findings, rules

PSI = 20.0  # deg


def made_up(psi_deg=PSI):
    """A curve whose specimen dilates at an angle up to a peak of 50 deg at 2 % of shortening."""
    shortening = np.linspace(0.0005, 0.05, 100)
    sine = np.sin(np.radians(psi_deg))
    swell = 2.0 * sine / (1.0 - sine) * -np.log1p(-shortening)  # -(d1 + d3) / d1 for sin psi = -(d1 + d3) / (d1 - d3)
    angle = np.where(shortening < 0.02, 50.0 * shortening / 0.02, 32.0)
    return pd.DataFrame(
        {"shortening": shortening, "friction_angle_deg": angle, "void_ratio": 1.6 * np.exp(swell) - 1.0}
    )


def summary(**changes):
    band = {"found": True, "inclination_deg": 55.4, "inclination_error_deg": 0.4}
    return {
        "peak_friction_angle_deg": 50.0, "peak_at_shortening": 0.02, "residual_friction_angle_deg": 32.0,
        "peak_is_last": False, "band": band, **changes,
    }  # fmt: skip


@pytest.mark.parametrize("psi", [-8.0, 0.0, 20.0, 35.0])
def test_the_dilatancy_of_the_specimen_is_that_of_its_strains(psi):
    assert dilatancy_deg(made_up(psi), 0.02) == pytest.approx(psi, abs=1e-6)


def test_sand_of_no_volume_change_has_roscoe_at_45_and_associated_sand_has_all_rules_alike():
    assert rules(40.0, 0.0)["Roscoe"] == 45.0
    assert set(rules(40.0, 40.0).values()) == {65.0}
    found = rules(50.0, PSI)
    assert found["Roscoe"] < found["Arthur"] < found["Coulomb"]


@pytest.mark.parametrize(("angle", "name"), [(55.4, "Roscoe"), (63.0, "Arthur"), (69.0, "Coulomb")])
def test_the_band_is_set_beside_the_three_rules_and_the_nearest_is_named(angle, name):
    band = {"found": True, "inclination_deg": angle, "inclination_error_deg": 0.4}
    words = " ".join(findings(summary(band=band), made_up()))
    assert "friction angle 50.0 deg at u/h = 2.00 %" in words and f"leans at {angle:.1f} +- 0.4 deg" in words
    assert "Roscoe 55.0, Arthur 62.5, Coulomb 70.0 deg" in words and f"nearest is {name}'s" in words


def test_a_test_without_peak_or_band_says_so():
    words = findings(summary(peak_is_last=True, band={"found": False}), made_up())
    assert words[0].startswith("No peak") and words[1].startswith("No band")
    assert "nothing to read" in findings({}, made_up().head(1))[0]

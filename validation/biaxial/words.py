"""What a biaxial test found, in words: its peak, and how its band leans against three rules.

Roscoe's angle 45 + psi/2 is that of a line which does not strain (K. H. Roscoe, Geotechnique 20 (1970) 129-170),
Coulomb's 45 + phi/2 that of the plane where shear over normal stress is greatest, and Arthur's 45 + (phi + psi)/4 their
mean (J. R. F. Arthur et al., Geotechnique 27 (1977) 53-74); all to the plane of the greatest principal stress, which is
horizontal here.
"""

import math

import numpy as np
import pandas as pd

BEFORE = 0.85  # of the shortening at the peak: from there up to it the dilatancy is taken
FEWEST = 4  # rows


def rules(friction_deg: float, dilatancy_deg: float) -> dict[str, float]:
    """Inclinations to the horizontal of a band at angles of friction and dilatancy [deg]."""
    phi, psi = friction_deg, dilatancy_deg
    return {"Roscoe": 45.0 + 0.5 * psi, "Arthur": 45.0 + 0.25 * (phi + psi), "Coulomb": 45.0 + 0.5 * phi}


def dilatancy_deg(curve: pd.DataFrame, peak_at: float) -> float | None:
    """Dilatancy angle of the specimen just before the peak [deg]: sin psi = -(d1 + d3) / (d1 - d3).

    The strains are those of the whole specimen, which is alike everywhere up to there; None of too few rows.
    """
    rows = curve[(curve.shortening >= BEFORE * peak_at) & (curve.shortening <= peak_at)]
    if len(rows) < FEWEST:
        return None
    axial, swell = -np.log1p(-rows.shortening), np.log1p(rows.void_ratio)
    per_axial = float(np.polyfit(axial, swell, 1)[0])  # growth of volume over shortening: -(d1 + d3) / d1
    return math.degrees(math.asin(per_axial / (2.0 + per_axial))) if per_axial > -1.0 else None


def findings(summary: dict, curve: pd.DataFrame) -> list[str]:
    """Sentences on a test, from its summary and its curve."""
    if "peak_friction_angle_deg" not in summary:
        return ["The test ended before it had two rows; there is nothing to read."]
    peak, at, rest = (
        summary[f"{name}"] for name in ("peak_friction_angle_deg", "peak_at_shortening", "residual_friction_angle_deg")
    )
    if summary["peak_is_last"]:
        found = [f"No peak: the friction angle still grows, or stays, at {peak:.1f} deg, u/h = {100 * at:.1f} %."]
    else:
        found = [
            f"Peak: friction angle {peak:.1f} deg at u/h = {100 * at:.2f} %; {rest:.1f} deg over the last tenth of the "
            f"shortening."
        ]
    band = summary.get("band") or {}
    if not band.get("found"):
        return [*found, "No band: the sand strains alike everywhere, or more in the middle, but in no narrow strip."]
    angle, error = band["inclination_deg"], band["inclination_error_deg"] or 0.0
    found.append(f"A band leans at {angle:.1f} +- {error:.1f} deg to the horizontal.")
    psi = dilatancy_deg(curve, at)
    if psi is None:
        return [*found, "Its dilatancy before the peak is not known, so no rule is set beside it."]
    expected = rules(peak, psi)
    near = min(expected, key=lambda name: abs(expected[name] - angle))
    told = ", ".join(f"{name} {value:.1f}" for name, value in expected.items())
    found.append(
        f"By the friction ({peak:.1f} deg) and dilatancy ({psi:.1f} deg) of the peak the rules say {told} deg; nearest "
        f"is {near}'s, {abs(expected[near] - angle):.1f} deg away."
    )
    reading = {
        "Roscoe": "The band follows the line that does not strain: kinematics of the sand beside it decide.",
        "Coulomb": "The band follows the plane of greatest shear over normal stress: strength decides.",
        "Arthur": "The band stands between kinematics (Roscoe) and strength (Coulomb), as many tests on sand do.",
    }
    return [*found, reading[near]]

"""What columns of laboratory files may be called, in the words and units of laboratories."""

import re
import unicodedata

from taichi_silo.studies.measured_tables import LENGTH, STRESS, Units

STRAIN: Units = {"%": 0.01, "-": 1.0, "1": 1.0, "m/m": 1.0, "mm/mm": 1.0, "‰": 1e-3, "percent": 0.01}
ANGLE: Units = {"deg": 1.0, "°": 1.0, "degrees": 1.0, "grad": 1.0, "rad": 57.29577951308232}
DENSITY: Units = {"kg/m3": 1.0, "kg/m³": 1.0, "g/cm3": 1e3, "g/cm³": 1e3, "t/m3": 1e3, "t/m³": 1e3, "mg/m3": 1e3}
SIZE: Units = {**LENGTH, "um": 1e-6, "µm": 1e-6, "μm": 1e-6}
NUMBER: Units = {"-": 1.0, "1": 1.0, "": 1.0}
UNITS = {"stress": STRESS, "strain": STRAIN, "angle": ANGLE, "density": DENSITY, "size": SIZE}

WORDS: dict[str, tuple[Units, str]] = {  # quantity: its units, and what it is called; a name less all but letters
    "axial_strain": (
        STRAIN, "axial strain, eps1, eps a, epsilon1, epsilon a, vertical strain, strain, axialdehnung, "
        "axiale dehnung, stauchung, axiale stauchung",
    ),
    "log_strain": (STRAIN, "log axial strain, logarithmic axial strain, true axial strain, eps1 log, axial strain log"),
    "volume_strain": (
        STRAIN, "volumetric strain, volume strain, volume change, eps v, epsilon v, eps vol, epsilon vol, "
        "volumendehnung, volumetrische dehnung",
    ),
    "dilation": (STRAIN, "dilation, dilatancy, dilative strain, dilation strain, volume increase, dilatation"),
    "deviator": (
        STRESS, "q, deviator stress, deviatoric stress, deviator, principal stress difference, sigma1-sigma3, "
        "stress difference, deviatorspannung, hauptspannungsdifferenz",
    ),
    "axial_stress": (
        STRESS, "sigma1, sigma v, sigma a, sigma axial, sig11, axial stress, vertical stress, effective axial stress, "
        "effective vertical stress, normal stress, stress, vertikalspannung, axialspannung, spannung, auflast",
    ),
    "cell_pressure": (
        STRESS, "sigma3, sig33, sigma r, cell pressure, confining pressure, confining stress, radial stress, "
        "effective confining pressure, effective cell pressure, effective confining stress, zelldruck, seitendruck",
    ),
    "pore_pressure": (
        STRESS, "u, du, delta u, pore pressure, pore water pressure, excess pore pressure, excess pore water pressure, "
        "change of pore pressure, porenwasserdruck, porendruck, porenwasserüberdruck",
    ),
    "mean_stress": (STRESS, "p, mean stress, mean effective stress, mean pressure, mittlere spannung"),
    "shear_strain": (STRAIN, "shear strain, gamma, shear distortion, scherdehnung, schubverzerrung, gleitung"),
    "shear_stress": (STRESS, "shear stress, tau, sigma12, tau xy, schubspannung, scherspannung"),
    "void_ratio": (NUMBER, "void ratio, e, voids ratio, porenzahl"),
    "porosity": ({**NUMBER, **STRAIN}, "porosity, porenanteil"),
    "first_void_ratio": (NUMBER, "e0, initial void ratio, void ratio e0, anfangsporenzahl, e initial, initial e"),
    "dry_density": (DENSITY, "dry density, rho d, initial dry density, trockendichte"),
    "settlement": (SIZE, "settlement, setzung, axial displacement, vertical displacement"),
    "first_height": (SIZE, "initial height, h0, height of the specimen, anfangshöhe, probenhöhe"),
    "friction_angle": (
        ANGLE, "angle of repose, repose angle, critical friction angle, phi c, böschungswinkel, schüttwinkel, "
        "repose",
    ),
    "e_min": (NUMBER, "e min, minimum void ratio, min void ratio, ed0"),
    "e_max": (NUMBER, "e max, maximum void ratio, max void ratio, ec0"),
    "densest": (DENSITY, "rho max, rho d max, maximum density, max density, maximum dry density, dichteste lagerung"),
    "loosest": (DENSITY, "rho min, rho d min, minimum density, min density, minimum dry density, lockerste lagerung"),
    "grain_density": (DENSITY, "grain density, particle density, solid density, rho s, korndichte"),
    "d50": (SIZE, "d50, mean grain size, mean grain diameter, mittlerer korndurchmesser"),
}  # fmt: skip
GREEK = {"ε": "eps", "σ": "sigma", "φ": "phi", "ϕ": "phi", "ρ": "rho", "τ": "tau", "γ": "gamma"}


def key(name: str) -> str:
    """A name less spaces, signs and accents, with Greek letters in words."""
    text = "".join(GREEK.get(sign, sign) for sign in name.casefold())
    return re.sub(r"[^a-z0-9äöüß]", "", unicodedata.normalize("NFKC", text))


KEYS = {key(word): quantity for quantity, (_, words) in WORDS.items() for word in words.split(", ")}


def quantity(name: str) -> str | None:
    """What a column of this name holds; None if it is not known here."""
    return KEYS.get(key(name))

"""Laboratory tests in SI units, compression positive."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Oedometer:
    """Void ratio under an axial stress; points in the order of the test, with unloading."""

    name: str  # of the file
    stress_Pa: np.ndarray
    void_ratio: np.ndarray

    @property
    def loading(self) -> np.ndarray:
        """Which points are of first loading: their stress exceeds all before."""
        return beyond_all_before(self.stress_Pa)


@dataclass(frozen=True)
class Triaxial:
    """Drained triaxial compression of a specimen; values that were not measured are nan."""

    name: str
    cell_Pa: float
    void_ratio: float  # at the begin
    strain: np.ndarray  # axial, logarithmic
    deviator_Pa: np.ndarray  # q, axial less radial stress
    volume_strain: np.ndarray  # loss of volume over the first volume
    sign_known: bool = True  # of the volume strain, by the name of its column

    @property
    def loading(self) -> np.ndarray:
        """Which points are of first loading."""
        return beyond_all_before(self.strain)

    @property
    def friction_angle_deg(self) -> np.ndarray:
        """Mobilised friction angle of each point."""
        return np.degrees(np.arcsin(self.deviator_Pa / (self.deviator_Pa + 2.0 * self.cell_Pa)))


@dataclass(frozen=True)
class IndexTests:
    """Repeated simple tests of the sand; empty where none was made."""

    friction_angle_deg: list[float] = field(default_factory=list)  # angle of repose
    e_min: list[float] = field(default_factory=list)  # void ratio of the densest and of the loosest dry state
    e_max: list[float] = field(default_factory=list)
    grain_density_kg_per_m3: list[float] = field(default_factory=list)
    d50_m: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Laboratory:
    """All tests of one sand."""

    oedometers: list[Oedometer]
    triaxials: list[Triaxial]
    index: IndexTests
    remarks: list[str] = field(default_factory=list)  # how the files were read, where that had to be decided

    @property
    def names(self) -> list[str]:
        """Names of the files with curves."""
        return [one.name for one in self.oedometers] + [one.name for one in self.triaxials]


def beyond_all_before(values: np.ndarray) -> np.ndarray:
    """Whether each value is larger than all before; the first is."""
    before = np.concatenate([[-np.inf], np.maximum.accumulate(values)[:-1]])
    return values > before

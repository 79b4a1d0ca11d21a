"""Made-up laboratory tests with noise, whose constants are known: how often a calibration's intervals hold them."""

import numpy as np
from taichi_silo.studies.calibrate.lab_tests import IndexTests, Laboratory, Oedometer, Triaxial
from taichi_silo.studies.calibrate.paths import Law, oedometer, triaxial
from taichi_silo.studies.calibrate.constants import NAMES
from taichi_silo.scene.published_sands import published

VOID, DEVIATOR, VOLUME, SPECIMEN, REPOSE_DEG, LIMIT = 0.001, 0.01, 0.0005, 0.005, 1.0, 0.02
OEDOMETERS = (0.95, 0.25)
TRIAXIALS = ((0.2, 100e3), (0.2, 400e3), (0.6, 200e3), (0.9, 100e3))


def laboratory(constants, seed):
    rng = np.random.default_rng(seed)
    law = Law(**constants)
    e_of = lambda share: constants["e_d0"] + share * (constants["e_c0"] - constants["e_d0"])
    k0 = 1.0 - np.sin(np.radians(constants["critical_friction_angle_deg"]))
    oeds, trs = [], []
    for k, share in enumerate(OEDOMETERS):
        stress = np.geomspace(10e3, 1600e3, 16)
        e0 = e_of(share)
        path = oedometer(law, np.log(stress[[0, -1]])[:, None], np.array([[k0]]), np.array([[e0]]))
        e = path.at(0, np.log(stress))[1][:, 0] + rng.normal(0, SPECIMEN) + rng.normal(0, VOID, 16)
        oeds.append(Oedometer(f"oedometer_{k}.csv", stress, e))
    for k, (share, cell) in enumerate(TRIAXIALS):
        strain = np.linspace(0.0, 0.18, 46)[1:]
        e0 = e_of(share)
        path = triaxial(law, np.array([[0.0], [strain[-1]]]), np.array([cell]), np.array([[e0]]))
        axial, e = (one[:, 0] for one in path.at(0, strain))
        q = axial - cell
        trs.append(
            Triaxial(
                f"triaxial_{k}.csv",
                cell,
                e0 + rng.normal(0, SPECIMEN),
                strain,
                q + rng.normal(0, DEVIATOR * q.max(), 45),
                1 - (1 + e) / (1 + e0) + rng.normal(0, VOLUME, 45),
            )
        )
    index = IndexTests(
        [constants["critical_friction_angle_deg"] + rng.normal(0, REPOSE_DEG)],
        [constants["e_d0"] + rng.normal(0, LIMIT)],
        [constants["e_c0"] + rng.normal(0, LIMIT)],
        [2650.0],
        [5e-4],
    )
    return Laboratory(oeds, trs, index)

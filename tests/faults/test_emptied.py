"""A silo that has lost all its sand ends as any other: figures, film, books, and it can be resumed and studied."""

import pytest

import taichi_silo as ts

PARTS = {
    "grid": {"cell_size_m": 0.0125},
    "sand": {"void_ratio": 0.8},
    "walls": {"kind": "smooth", "friction_angle_deg": 0.0},
    "method": {"filling_time_s": 0.05, "longest_settling_s": 0.0},
    "output": {"snapshots": 6, "records_per_period": 4},
    "machine": {"threads": 1},
}
HOPPER = {"width_m": 0.15, "height_m": 0.1, "hopper": {"half_angle_deg": 20, "outlet_width_m": 0.1}}
SILOS = {"hopper": HOPPER, "round hopper": HOPPER | {"section": "round"}}


def emptied(silo) -> ts.Scene:
    """A scene that lets out all its sand."""
    found = ts.Silo.model_validate(silo)
    most = 1.1 * found.area_m2 / found.outlet_share_m
    flow = {"outflow": "gravity", "longest_s": 3.0, "displacement_m": most}
    return ts.Scene.model_validate(PARTS | {"silo": silo, "flow": flow})


@pytest.mark.parametrize("name", SILOS)
def test_a_silo_that_is_empty_at_the_end_leaves_all_files_and_is_finished(tmp_path, name):
    left = ts.run(emptied(SILOS[name]), tmp_path / "run", progress=False)
    assert left.finished and left.film is not None and {"forces", "void_ratio"} <= set(left.figures)
    assert not any("could not" in one for one in left.summary.get("warnings", []))
    ledger = left.summary["ledger"]
    assert ledger["left_in_silo_kg_per_m"] < 0.01 * ledger["discharged_kg_per_m"]
    assert ledger["error_over_first_mass"] < 1e-9
    before = (left.folder / "forces.csv").read_bytes()
    assert ts.resume(left.folder).finished
    assert (left.folder / "forces.csv").read_bytes() == before

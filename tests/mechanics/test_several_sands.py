"""Sands in layers: each answers with its own law, wherever it has gone."""

import copy

import numpy as np
import pytest

from taichi_silo.mpm import runtime
from taichi_silo.mpm.laws.several import Several, laws_of
from taichi_silo.mpm.laws.stress_point import wave_speed
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation.simulation import Simulation

LANES = True
HOSTUN = {"from_m": 0.2, "void_ratio": 0.75, "name": "hostun"}


def scene(*layers, **parts):
    tables = {
        "silo": {"width_m": 0.1, "height_m": 0.4, "half": "no"}, "grid": {"cell_size_m": 0.02},
        "walls": {"kind": "smooth", "friction_angle_deg": 0.0}, "sand": {"void_ratio": 0.6, "layers": list(layers)},
        "flow": {"speed_m_per_s": 0.02, "displacement_m": 0.001}, "machine": {"threads": 1},
    }  # fmt: skip
    return Scene.model_validate(tables | parts)


def filled(what):
    what.machine.start()
    silo = Simulation(what)
    records = list(silo.fill())
    return silo, silo.points(), records[-1]


def test_a_layer_of_the_same_sand_by_name_changes_nothing():
    same = {"from_m": 0.2, "void_ratio": 0.75, "granular_hardness_Pa": 190e6}
    one, several = scene({"from_m": 0.2, "void_ratio": 0.75}), scene(same)
    assert not isinstance(one.law, Several) and isinstance(several.law, Several)
    plain, named = (filled(what)[1] for what in (one, several))
    for name in ("position", "stress", "volume"):
        assert np.abs(plain[name] - named[name]).max() <= 1e-12 * np.abs(plain[name]).max(), name


@pytest.mark.parametrize("lanes", [True, False])
def test_between_frictionless_walls_each_sand_has_the_pressure_ratio_of_its_own(lanes):
    """Uniaxial compression leads every sand to its own K0; all of the weight is on the floor."""
    what = scene(HOSTUN, machine={"threads": 1, "lanes": lanes})
    silo, points, record = filled(what)
    assert record.bottom_force_N_per_m == pytest.approx(record.weight_N_per_m, rel=2e-3)
    xx, yy = points["stress"][:, 0], points["stress"][:, 1]
    for number, (law, sand) in enumerate(zip(laws_of(what.law), what.sand.sands, strict=True)):
        own = (points["sand"] == number) & (yy < -0.2 * np.abs(yy).max())
        assert own.sum() > 20
        ratio = float((xx[own] / yy[own]).mean())
        assert ratio == pytest.approx(law.rest_pressure_ratio(sand.void_ratio, 2e3), rel=0.02), sand.name


def test_the_step_is_that_of_the_stiffest_point_in_its_own_sand():
    stiff = HOSTUN | {"granular_hardness_Pa": 1e12}
    what = scene(stiff)
    silo, points, _ = filled(what)
    h, e = what.grid.cell_size_m, points["void_ratio"]
    transits = {0: [], 1: []}
    for p, sand in enumerate(points["sand"].astype(int)):
        c = wave_speed(laws_of(what.law)[sand], points["stress"][p], float(e[p]))
        transits[sand].append(h / (c + np.hypot(*points["velocity"][p])))
    assert silo.solver.point_sums().transit == pytest.approx(min(transits[1]), rel=1e-6)
    assert min(transits[1]) < 0.8 * min(transits[0])


def test_the_upper_sand_flows_out_as_what_it_is():
    """What leaves is in the order of the layers, and the sands keep their numbers."""
    outlet = {"width_m": 0.1, "height_m": 0.4, "half": "no", "outlet": {"width_m": 0.06}}
    what = scene(HOSTUN, silo=outlet, flow={"speed_m_per_s": 0.05, "displacement_m": 0.06})
    what.machine.start()
    silo = Simulation(what)
    for _ in silo.run():
        pass
    points = silo.points()
    first = silo.model.fill()["sand"]
    assert (points["sand"] == first[points["identity"]]).all()
    assert (points["sand"] == 1).sum() == (first == 1).sum()  # the lower sand leaves first
    assert (points["sand"] == 0).sum() < (first == 0).sum()


@pytest.mark.parametrize(
    "layer, words",
    [
        ({"name": "hostum"}, "name of a layer of sand is hostum; it must be one of karlsruhe"),
        ({"void_ratio": 0.5}, "in the layer from 0.2 m the void ratio is 0.5; it must lie between e_d0 = 0.61"),
        ({"e_c0": 0.2}, "in the layer from 0.2 m the limits of the void ratio are"),
    ],
)
def test_a_layer_of_a_sand_that_cannot_be_is_refused(layer, words):
    with pytest.raises(ValueError, match=words):
        scene(HOSTUN | layer)


def test_a_checkpoint_keeps_which_sand_a_point_is_of():
    what = scene(HOSTUN)
    what.machine.start()
    silo = Simulation(what)
    for number, _ in enumerate(silo.run()):
        if number == 20:
            break
    kept = copy.deepcopy(silo.state())
    assert set(np.unique(kept["points"]["sand"])) == {0.0, 1.0}
    runtime.init()
    again = Simulation(what)
    again.restore(kept)
    assert (again.points("sand")["sand"] == kept["points"]["sand"]).all()

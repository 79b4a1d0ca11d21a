"""Fields: formulas against hand calculation, colours that everybody can tell apart, ranges that fit."""

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from taichi_silo.errors import BadInput
from taichi_silo.runs.point_fields import FIELDS, Scale, field, nice
from tests import made_up

SCENE = made_up.scene()


def of(name, **fields):
    """Of points that differ from those of the fill."""
    points = made_up.state(SCENE, 0.0) | fields
    count = len(next(iter(fields.values())))
    points = {key: values[:count] for key, values in points.items()}
    return FIELDS[name].values(points, made_up.state(SCENE, 0.0), SCENE)


def lightness(colours):
    return np.asarray(colours) @ (0.2126, 0.7152, 0.0722)


@pytest.mark.parametrize("name", FIELDS)
def test_each_field_is_a_number_for_each_point_within_its_range(name):
    points, start = made_up.state(SCENE, 0.01), made_up.state(SCENE, 0.0)
    values = field(name).values(points, start, SCENE)
    scale = field(name).scaled(SCENE, values)
    assert values.shape == points["mass"].shape
    assert np.isfinite(values).all()
    assert (values <= scale.high + 1e-12).mean() > 0.98
    assert scale.decades or (values >= scale.low - 1e-12).mean() > 0.98


@pytest.mark.parametrize(
    ("name", "field", "value", "expected"),
    [
        ("mobilised_friction", "stress", [-500.0, -1000.0, -500.0, 0.0], np.degrees(np.arcsin(1.0 / 3.0))),  # at rest
        ("mobilised_friction", "stress", [-1000.0, -500.0, -700.0, 0.0], np.degrees(np.arcsin(1.0 / 3.0))),
        ("mobilised_friction", "stress", [-1e3, -1e3, -3e3, 0.0], 30.0),  # the out-of-plane stress is the largest
        ("mobilised_friction", "stress", [-1e3, -1e3, -1e3 / 3.0, 0.0], 30.0),  # the smallest
        ("mobilised_friction", "stress", [-1e3, -1e3, -1e3, -500.0], 30.0),  # neither
        ("mobilised_friction", "stress", [-1.0, -1.0, -1.0, 0.0], np.nan),  # without stress
        ("speed", "velocity", [0.003, -0.004], 5.0),  # mm/s
        ("mean_stress", "stress", [-1e3, -2e3, -3e3, -9e3], 2.0),  # kPa
    ],
)
def test_formulas_by_hand(name, field, value, expected):
    assert of(name, **{field: np.array([value])}) == pytest.approx([expected], nan_ok=True)


def test_a_point_keeps_its_layer_wherever_it_goes():
    start = made_up.state(SCENE, 0.0)
    now = {name: values[::-1] for name, values in made_up.state(SCENE, 0.02).items()}
    now = {name: values[10:] for name, values in now.items()}  # some have left
    before, after = (FIELDS["layers"].values(points, start, SCENE) for points in (start, now))
    assert (after == before[::-1][10:]).all()
    assert set(before) == {0.0, 1.0, 2.0}


def test_layers_alternate_and_marked_columns_are_symmetric():
    start = made_up.state(SCENE, 0.0)
    rows = FIELDS["layers"].values(start, start, SCENE).reshape(-1, 10)
    assert (rows == rows[:, ::-1]).all()
    assert (rows[:, 5] == np.arange(25) // 2 % 2).all()  # two rows of 20 mm each
    assert ((rows == 2.0).sum(axis=1) == 2).all()  # of ten


def test_a_fine_silo_has_four_marked_columns_and_a_coarse_one_none():
    for cell, marked in ((0.05, 0), (0.02, 2), (0.005, 4)):
        scene = made_up.scene(cell)
        start = made_up.state(scene, 0.0)
        start["position"] *= 1.0 - 1e-12  # round-off moves no column
        rows = FIELDS["layers"].values(start, start, scene).reshape(-1, round(0.2 / cell))
        assert ((rows == 2.0).sum(axis=1) == marked).all()


def test_layers_of_a_half_are_those_of_the_whole():
    whole, half = made_up.state(SCENE, 0.0), made_up.state(SCENE, 0.0, half=True)
    order = [np.lexsort(np.round(points["position"], 6).T) for points in (whole, half)]
    found = [FIELDS["layers"].values(points, points, SCENE) for points in (whole, half)]
    assert (found[0][order[0]] == found[1][order[1]]).all()


def test_speed_is_linear_in_plug_flow_and_logarithmic_where_sand_stands_still():
    plug = FIELDS["speed"].scaled(SCENE, np.linspace(4.0, 5.0, 100))
    assert (plug.low, plug.high, plug.decades) == (0.0, 5.0, False)
    funnel = FIELDS["speed"].scaled(SCENE, np.concatenate([np.full(50, 1e-3), np.full(50, 5.0)]))
    assert (funnel.low, funnel.high, funnel.decades) == (0.05, 5.0, True)
    assert funnel.share(np.array([0.0, 0.05, 0.5, 5.0, 9.0])) == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])
    values = np.concatenate([np.full(50, 1e-3), np.full(50, 5.0)])  # a given range is kept; from 0 on it is linear
    assert not FIELDS["speed"].scaled(SCENE, values, (0.0, 3.0)).decades
    assert FIELDS["speed"].scaled(SCENE, values, (0.1, 3.0)).low == 0.1


def test_what_has_no_value_stays_without_one():
    scale = Scale("x", "viridis", 0.0, 2.0)
    assert np.isnan(scale.share(np.array([np.nan, 1.0]))).tolist() == [True, False]
    scaled = FIELDS["mean_stress"].scaled(SCENE, np.array([np.nan, 1.0, 3.9]))
    assert (scaled.low, scaled.high) == (0.0, 4.0)


@pytest.mark.parametrize("value, expected", [(0.0, 1.0), (29.0, 30.0), (30.0, 30.0), (31.0, 40.0), (0.0011, 0.0015)])
def test_ranges_end_at_round_numbers(value, expected):
    assert nice(value) == pytest.approx(expected)


@pytest.mark.parametrize("name", FIELDS)
def test_colours_differ_in_lightness_also_for_the_colour_blind(name):
    colours = FIELDS[name].scale.colours
    if isinstance(colours, tuple):
        light = np.sort(lightness([to_rgb(colour) for colour in colours]))
        assert (np.diff(light) > 0.15).all()
        return
    light = lightness(matplotlib.colormaps[colours](np.linspace(0, 1, 256))[:, :3])
    if name == "mobilised_friction":  # on both sides of the critical angle
        assert (np.diff(light[:120]) > 0).mean() > 0.95 and (np.diff(light[136:]) < 0).mean() > 0.95
    else:
        assert (np.diff(light) > 0).mean() > 0.97


def test_an_unknown_field_is_refused_with_the_known_ones():
    with pytest.raises(BadInput, match="field is colour; it must be one of void_ratio, .*layers"):
        field("colour")

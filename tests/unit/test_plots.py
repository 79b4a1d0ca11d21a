"""Figures are drawn from the files of a run, complete or not."""

import json
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from taichi_silo.errors import BadInput
from taichi_silo.runs import snapshot
from taichi_silo.runs.observers.outflow import columns_of
from taichi_silo.runs.result import Result
from taichi_silo.runs.theories import critical_simple_shear_angle_deg
from taichi_silo.scene.scene import Walls
from taichi_silo.scene.silo import Hopper, Outlet, Silo
from taichi_silo.show.figures import plot_run
from taichi_silo.show.figures.forces import run_forces_figure
from taichi_silo.show.figures.outflow import run_outflow_figure
from taichi_silo.show.figures.style import legend_below, make_logarithmic, new_figure, put_title
from taichi_silo.show.figures.void_ratio import (
    around,
    chosen_snapshots,
    color_bar,
    color_range,
    draw_field,
    limits_of,
    run_void_ratio_figure,
)
from taichi_silo.show.figures.wall_stress import run_wall_stress_figure
from taichi_silo.show.theory import janssen
from tests import made_up
from validation.case_figures import plot_cases

SMOOTH = Walls(kind="smooth", friction_angle_deg=19.0)
NAMES = ["forces.png", "wall_friction_angle.png", "void_ratio.png", "wall_stress.png"]


def left(folder, kind="smooth", void_ratio=0.6, until_mm=20):
    """A run with wall profiles and a summary; it ended at a displacement, or with 0 while the silo was being filled."""
    angle = 12.3 if void_ratio > 0.75 else 19.0
    walls = Walls(kind=kind, friction_angle_deg=angle if kind == "smooth" else None)
    made_up.leave(folder, made_up.scene(walls=walls, sand={"void_ratio": void_ratio}))
    for name in ("forces.csv", "snapshots/index.csv"):
        table = pd.read_csv(folder / name)
        table = table[table.displacement_m <= 1e-3 * until_mm + 1e-9]
        if until_mm == 0:
            table = table[table.stage == "filling"]
        elif "file" in table:  # the last state has a name, and no film's
            last = table.index[-1]
            (folder / "snapshots" / table.file[last]).replace(folder / "snapshots" / "end.vtu")
            table.loc[last, "file"] = "end.vtu"
        table.to_csv(folder / name, index=False)
    if until_mm:
        height = np.linspace(0.0, 0.5, 51)
        rows = [
            pd.DataFrame({"state": state, "wall": wall, "height_m": height, "normal_stress_Pa": factor * (0.5 - height),
                          "shear_stress_Pa": 0.3 * factor * (0.5 - height)})
            for state, factor in (("filling", 4e3), ("maximum", 6e3), ("residual", 5e3)) for wall in ("left", "right")
        ]  # fmt: skip
        pd.concat(rows).to_csv(folder / "walls.csv", index=False)
        ratios = {"pressure_ratio_K0": 0.42, "pressure_ratio_measured": 0.45}
        (folder / "summary.json").write_text(json.dumps({"janssen": ratios}))
    return folder


def assert_drawn(paths, names):
    assert [path.name for path in paths] == names
    for path in paths:
        image = np.asarray(Image.open(path).convert("RGB"))
        assert min(image.shape[:2]) > 400
        assert np.mean(np.any(image < 200, axis=2)) > 0.01  # something is there beside the paper


@pytest.mark.parametrize("reach", [0.15, 0.43], ids=["a column", "sand in a side outlet"])
def test_panels_of_void_ratio_reach_from_wall_to_wall_and_show_what_is_closed(reach):
    """Sand that has not run to the walls, or passes one, does not move the walls of the picture."""
    if reach < 0.4:
        silo = Silo(width_m=0.4, height_m=0.1, column_m=(0.0, 0.1))
    else:
        silo = Silo.model_validate({"width_m": 0.4, "height_m": 0.1,
                                    "outlet": {"width_m": 0.04, "wall": "right", "position": 0.05}})  # fmt: skip
    places = np.array([[0.005, 0.005], [reach - 0.005, 0.095]])
    field = places, np.array([0.6, 0.7]), np.full(2, 0.01)
    panel = new_figure(4.0, 4.0).subplots()
    draw_field(panel, field, color_range([field]), around(silo, limits_of([field])), silo)
    assert panel.get_xlim() == pytest.approx((0.0, max(400.0, 1e3 * reach)))
    assert panel.get_xticks().tolist() == [0.0, 200.0, 400.0]
    lines = [np.array(line.get_xydata()) for line in panel.get_lines()]
    floor = [line[:, 0].tolist() for line in lines if (line[:, 1] == 0.0).all()]
    assert floor == [[0.0, 400.0]]
    right = np.sort([line[:, 1] for line in lines if (line[:, 0] == 400.0).all()], axis=0)
    top = panel.get_ylim()[1]
    assert right == pytest.approx(np.array([[0.0, top]] if reach < 0.4 else [[0.0, 30.0], [70.0, top]]))


@pytest.mark.parametrize(("wide", "high"), [(0.6, 0.2), (2.0, 0.04)])
def test_panels_of_a_wide_silo_stand_below_each_other_no_higher_than_a_page_and_say_its_height(tmp_path, wide, high):
    silo = Silo(width_m=wide, height_m=high, outlet=Outlet(width_m=0.08))
    made_up.leave(tmp_path / "run", made_up.scene(silo=silo), states=4)
    figure = run_void_ratio_figure(Result(tmp_path / "run"))
    panels = figure.axes[:-1]
    assert len(panels) > 2 and len({panel.get_subplotspec().colspan.start for panel in panels}) == 1
    assert figure.get_figheight() < 21.0 and figure.get_figwidth() < 16.0
    unit = 1.0 if wide > 1.0 else 1e3
    assert all(panel.get_yticks()[-1] == pytest.approx(unit * high) for panel in panels)


def test_outlets_that_let_out_alike_are_both_seen_and_no_time_is_cut_off(tmp_path):
    outlets = (Outlet(width_m=0.08, position=0.1), Outlet(width_m=0.08, position=0.3))
    folder = made_up.leave(tmp_path / "run", made_up.scene(silo=Silo(width_m=0.4, height_m=0.2, outlet=outlets)))
    time = np.linspace(made_up.FILLED_S, made_up.FILLED_S + 0.3529, 40)
    each = {name: value for k in (1, 2) for name, value in zip(columns_of(k), (1.0, time, 2.0, 3.0), strict=True)}
    pd.DataFrame({"time_s": time, "stage": "flow", "displacement_m": time, **each}).to_csv(
        folder / "outflow.csv", index=False
    )
    figure = run_outflow_figure(Result(folder))
    FigureCanvasAgg(figure).draw()
    renderer = FigureCanvasAgg(figure).get_renderer()
    for panel in figure.axes:
        first, second = panel.get_lines()[0], [line for line in panel.get_lines() if line.get_color() != "white"][1]
        assert first.get_linewidth() > second.get_linewidth()
        for place, label in zip(panel.get_xticks(), panel.get_xticklabels(), strict=True):
            assert place > panel.get_xlim()[1] or label.get_window_extent(renderer).x1 < figure.bbox.x1


@pytest.mark.parametrize(
    ("silo", "metres"),
    [(Silo(), 1), (Silo(section="round"), 2), (Silo(hopper=Hopper(half_angle_deg=30.0, outlet_width_m=0.08)), 0)],
)
def test_janssen_s_force_on_the_bottom_is_drawn_where_there_is_a_floor(tmp_path, silo, metres):
    """Of a round silo for two metres of girth, as P is counted; not beside a hopper, which has no floor."""
    walls = Walls(kind="smooth", friction_angle_deg=19.0)
    made_up.leave(tmp_path / "run", made_up.scene(silo=silo, walls=walls))
    run = Result(tmp_path / "run")
    panel = run_forces_figure(run).axes[0]
    lines = [line.get_ydata()[0] for line in panel.get_lines() if line.get_label().startswith("Janssen")]
    theory = janssen(run, 0.45)
    expected = [metres * theory.bottom_force_N_per_m / 1e3] if metres else []
    assert lines == pytest.approx(expected)


def test_figures_of_a_run(tmp_path):
    paths = plot_run(left(tmp_path / "run"))
    assert_drawn(paths, NAMES)
    assert {path.parent for path in paths} == {tmp_path / "run" / "figures"}


def test_a_run_that_ended_while_filling_is_drawn(tmp_path):
    assert_drawn(plot_run(left(tmp_path / "run", until_mm=0)), NAMES[:3])


def test_the_scale_of_the_void_ratio_stands_beside_the_panels_of_a_part_of_a_figure_too():
    figure = new_figure(6.0, 8.0)
    for part in figure.subfigures(2, 1):
        color_bar(part, [part.subplots()], color_range([(None, np.array([0.6, 0.8]), None)]))
    assert len(figure.subfigs) == 2 and all(len(part.axes) == 2 for part in figure.subfigs)


def test_figures_of_several_runs(tmp_path):
    folders = {
        "dense, smooth": left(tmp_path / "a"),
        "dense, very rough": left(tmp_path / "b", "very-rough", until_mm=6),
        "loose, smooth": left(tmp_path / "c", void_ratio=0.9, until_mm=0),
    }
    assert_drawn(plot_cases(folders, tmp_path / "figures"), NAMES)


def test_a_run_that_went_wrong_is_drawn_as_far_as_it_can_be_read(tmp_path):
    folder = left(tmp_path / "run", "very-rough", until_mm=6)
    forces = pd.read_csv(folder / "forces.csv")
    forces.iloc[-3:, 3:8] = [[np.nan] * 5, [np.inf] * 5, [1e200] * 5]
    forces.to_csv(folder / "forces.csv", index=False)
    points = Result(folder).state("end")
    points["volume"][7] = -1.0
    snapshot.write(folder / "snapshots" / "end.vtu", points)
    (folder / "snapshots" / "start.vtu").unlink()
    (folder / "summary.json").unlink()
    (folder / "walls.csv").write_text("")
    assert_drawn(plot_run(folder), NAMES[:3])


def test_where_nothing_is_nothing_is_drawn(tmp_path):
    with pytest.raises(BadInput, match="holds no run.toml"):
        plot_run(tmp_path)
    folder = made_up.leave(tmp_path / "run", states=1)
    (folder / "forces.csv").unlink()
    (folder / "snapshots" / "index.csv").unlink()
    assert plot_run(folder) == plot_cases({"nothing": folder}, tmp_path / "figures") == []


@pytest.mark.parametrize("until_mm, expected", [(0, [0]), (20, [0, 2, 5, 10, 20]), (8, [0, 2, 5, 8]), (2, [0, 2])])
def test_snapshots_nearest_to_the_wanted_displacements(tmp_path, until_mm, expected):
    run = Result(left(tmp_path / "run", until_mm=until_mm))
    chosen = [1e3 * row["displacement_m"] for row in chosen_snapshots(run) if row is not None]
    assert chosen == pytest.approx(expected)


def test_critical_simple_shear_angle_of_sand():
    assert critical_simple_shear_angle_deg(30.0) == pytest.approx(29.431, abs=5e-4)


def test_a_legend_stays_within_its_figure():
    labels = ["every row", "median over 0.05 mm", "end of filling", "left wall", "right wall", "Janssen, K0 of the law"]
    for width in (4.0, 7.0, 11.0, 30.0):
        figure = new_figure(width, 4.0)
        handles = [figure.subplots().plot([0.0, 1.0], [0.0, 1.0])[0] for _ in labels]
        legend = legend_below(figure, handles, labels, 6)
        renderer = FigureCanvasAgg(figure).get_renderer()
        assert legend.get_window_extent(renderer).width < figure.bbox.width
        assert len(figure.legends) == 1
    assert legend._ncols == 6, "all beside each other where there is room"


def test_lines_of_a_title_are_about_as_long_as_each_other_and_part_no_number_from_its_sign_or_unit():
    figure = new_figure(7.0, 4.0)
    put_title(figure, "Forces: initially dense sand ($e_0$ = 0.60), smooth walls (20°), outlet of 100 mm at the right")
    first, *_, last = lines = figure.get_suptitle().split("\n")
    assert len(last) > 0.6 * len(first)
    assert any("= 0.60" in line.replace("\u00a0", " ") for line in lines)
    assert any("100 mm" in line.replace("\u00a0", " ") for line in lines)


@pytest.mark.parametrize(
    "ends", [(25, 800), (12.5, 400), (0.003, 0.9), (2, 3), (1, 9), (10, 300), (1e-4, 500), (90, 110)]
)
@pytest.mark.parametrize("name", ["xaxis", "yaxis"])
def test_numbers_on_a_logarithmic_axis_do_not_touch(ends, name):
    figure = new_figure(4.2, 3.2)
    panel = figure.subplots()
    panel.plot(ends, ends)
    axis = getattr(panel, name)
    make_logarithmic(axis)
    FigureCanvasAgg(figure).draw()
    low, high = sorted(axis.get_view_interval())
    labels = [one for one in axis.get_ticklabels() if one.get_text() and low <= _place(one, name) <= high]
    assert len(labels) >= 2 and not any("$" in one.get_text() for one in labels)
    boxes = [one.get_window_extent() for one in labels]
    assert not any(a.expanded(1.05, 1.05).overlaps(b) for a, b in pairwise(boxes)), [one.get_text() for one in labels]


def _place(label, name):
    return label.get_position()[name == "yaxis"]


BIN = [(0.04, 0), (0.16, 0), (0.2, 0.1), (0.2, 0.5), (0, 0.5), (0, 0.1)]


@pytest.mark.parametrize(
    ("corners", "lines", "words"),
    [
        (BIN, 2, "below 100 mm inclined walls over 50 mm of height"),
        (BIN[:2] + [(0.2, 0.5), (0, 0.5)], 1, "bold: mean of both inclined walls over 50 mm of height"),
    ],
    ids=["hopper", "no vertical wall"],
)  # fmt: skip
def test_each_bold_line_of_a_hopper_is_told_of_by_the_title(tmp_path, corners, lines, words):
    """One of the vertical and one of the inclined walls: each the mean of both."""
    silo = Silo.polygon(corners)
    run = Result(made_up.leave(tmp_path / "run", made_up.scene(silo=silo, walls=SMOOTH)))
    rows = [
        pd.DataFrame({"state": "filling", "wall": wall, "height_m": np.linspace(low, high, 11),
                      "normal_stress_Pa": stress, "shear_stress_Pa": stress})
        for wall, low, high, stress in (("left", 0.1, 0.5, 1e3), ("right", 0.1, 0.5, 3e3),
                                        ("hopper_left", 0.0, 0.1, 4e3), ("hopper_right", 0.0, 0.1, 8e3))
    ]  # fmt: skip
    pd.concat(rows).to_csv(run / "walls.csv", index=False)
    figure = run_wall_stress_figure(run)
    bold = [line for line in figure.axes[0].get_lines() if line.get_linewidth() == 2.0]
    assert [np.unique(line.get_xdata().round(9)).tolist() for line in bold] == [[2.0], [6.0]][-lines:]
    assert [line.get_label() for line in bold][0] == "after filling"
    assert words in " ".join(figure.get_suptitle().split())

"""Pages of any form for silos of any form: the sand fills its room, nothing lies over anything else."""

import itertools
import json

import imageio_ffmpeg
import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

import taichi_silo as ts
from taichi_silo.cli import app
from taichi_silo.errors import BadInput
from taichi_silo.mpm import runtime
from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import Flow
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.show.film import curves, force_rows, moments
from taichi_silo.show.film.between import Way, fallen
from taichi_silo.show.film.layout import SIZE, View, alone, layout
from taichi_silo.show.film.lettering import title_lines
from taichi_silo.show.film.look import COLOURS, Look
from taichi_silo.show.film.moments import Moment, Slow
from taichi_silo.show.film.picture import Picture, course_of, without_white
from taichi_silo.show.film.renderer import Pair, Renderer, scale_of
from tests import made_up

SILOS = {"standard": (0.2, 0.5), "wide": (1.2, 0.06), "flat": (2.0, 0.04), "slender": (0.08, 1.6), "square": (0.5, 0.5)}
SIZES = (SIZE, (1080, 1920), (1080, 1080), (640, 360), (960, 1080), (1600, 1200))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return made_up.leave(tmp_path_factory.mktemp("runs") / "silo")


def scene_of(name):
    width, height = SILOS[name]
    return made_up.scene(0.02, silo=Silo(width_m=width, height_m=height))


def view(name):
    width, height = SILOS[name]
    return View(0.0, -0.03, width, 1.015 * height)


def bitmap(file):
    return np.asarray(Image.open(file))


def overlap(a, b):
    return min(a.x1, b.x1) - max(a.x0, b.x0) > 1.0 and min(a.y1, b.y1) - max(a.y0, b.y0) > 1.0


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", SILOS)
def test_sand_and_curves_stand_beside_or_above_each_other_inside_the_page(name, size):
    for axes in (True, False):
        page = layout(size, view(name), axes)
        boxes = [page.panel, page.bar, page.plot]
        for box in boxes:
            assert box.left >= 0 and box.top >= 0 and box.columns > 0 and box.rows > 0
            assert box.left + box.columns <= size[0] and box.top + box.rows <= size[1]
        for a, b in itertools.combinations(boxes, 2):
            beside = a.left + a.columns <= b.left or b.left + b.columns <= a.left
            assert beside or a.top + a.rows <= b.top or b.top + b.rows <= a.top
        assert page.plot.columns >= 0.15 * size[0] and page.plot.rows >= 0.12 * size[1]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", SILOS)
def test_the_sand_is_as_wide_or_as_high_as_the_page_lets_it(name, size):
    panel = layout(size, view(name)).panel
    assert panel.columns > 0.23 * size[0] or panel.rows > 0.45 * size[1]
    if name in ("wide", "flat"):
        assert panel.columns > 0.78 * size[0]


def test_without_axes_the_sand_is_larger():
    for name in SILOS:
        assert layout(SIZE, view(name), axes=False).pixels_per_metre > layout(SIZE, view(name)).pixels_per_metre


@pytest.mark.parametrize("field", ["void_ratio", "layers", "mobilised_friction"])
@pytest.mark.parametrize("size", [SIZE, (1080, 1920), (1080, 1080), (480, 480)])
@pytest.mark.parametrize("name", SILOS)
def test_no_label_lies_over_another(name, size, field, folder):
    runtime.init("cpu", 1)
    scene, look = scene_of(name), Look(field=field, size=size)
    canvas = Picture(scene, scale_of(Result(folder), look, False), course_of(scene), look, note=force_rows.NOTE).canvas
    figure = canvas.furniture.figure
    FigureCanvasAgg(figure).draw()
    boxes = []
    for axes in figure.axes:
        texts = [*axes.texts, *(one.label1 for axis in (axes.xaxis, axes.yaxis) for one in axis.get_major_ticks())]
        texts += [one.label2 for one in axes.yaxis.get_major_ticks()] + [axes.xaxis.label, axes.yaxis.label]
        for text in texts:
            if text.get_visible() and text.get_text() and (box := text.get_window_extent()).width > 1.0:
                inside = axes.get_window_extent().y0 - 2 <= box.y0 + 0.5 * box.height <= axes.get_window_extent().y1 + 2
                if text in (*axes.texts, axes.xaxis.label) or inside:
                    boxes.append((text.get_text(), box))
    for (first, a), (second, b) in itertools.combinations(boxes, 2):
        assert not overlap(a, b), (first, second)
    for words, box in boxes:
        assert box.x0 >= -1 and box.x1 <= size[0] + 1 and box.y0 >= -1 and box.y1 <= size[1] + 1, words


@pytest.mark.parametrize("size", [(1080, 1080), (640, 360), (480, 480), (360, 640), (320, 180)])
def test_the_word_of_the_weight_stays_within_its_axes_on_small_pages(size, folder):
    """Letters of a few pixels are wider than their size says."""
    runtime.init("cpu", 1)
    scene, look = made_up.scene(0.02, silo=Silo(height_m=0.4)), Look(field="layers", size=size)
    canvas = Picture(scene, scale_of(Result(folder), look, False), course_of(scene), look).canvas
    forces = canvas.furniture.forces
    (label,) = [text for text in forces.texts if text.get_text().startswith("weight of the sand")]
    assert label.get_window_extent().width <= forces.get_window_extent().width


@pytest.mark.parametrize("size", [SIZE, (1080, 1080), (960, 540)])
def test_a_letter_leaves_the_axis_whole(size, folder):
    """The letters of forces that are all near zero stand on the axis, and their white rims would wipe it out."""
    runtime.init("cpu", 1)
    scene, look = scene_of("standard"), Look(field="void_ratio", size=size)
    canvas = Picture(scene, scale_of(Result(folder), look, False), course_of(scene), look, note=force_rows.NOTE).canvas
    own, plot = canvas.curves, canvas.curves.plot
    own.tip = np.array([[0.5 * plot.columns, plot.rows - one] for one in (1.0, 3.0, 5.0)])
    axis = plot.top + plot.rows
    frame = np.full((size[1], size[0], 3), 255, np.uint8)
    frame[axis] = 0
    own.mark_tips(frame)
    beside = (
        plot.left + round(own.tip[0, 0]) + canvas.layout.long(14)
    )  # of the dots, which stand on the axis themselves
    assert (frame[:axis, beside:] < 255).any() and not frame[axis, beside:].any()


def test_letters_of_curves_are_a_gap_apart_and_above_the_axis():
    for rows in ([10.0, 12.0, 14.0], [100.0, 498.0, 499.0], [480.0, 490.0, 500.0]):
        found = curves.apart(np.array(rows), 36.0, 486.0)
        assert (np.diff(found) >= 36.0 - 1e-9).all() and found[2] <= 486.0
    assert curves.apart(np.array([100.0, 498.0, 499.0]), 36.0, 486.0)[0] == pytest.approx(100.0, abs=18.0)


def test_a_long_title_has_two_lines_that_fit():
    words = "Karlsruhe sand, e0 = 0.60, smooth walls, outlet of 100 mm in the middle, hopper of 60 degrees, two inserts"
    lines, size = title_lines(words, 1.0, 960.0)
    assert len(lines) == 2 and " ".join(lines) == words and size > 15
    assert title_lines("x" * 200, 1.0, 960.0)[1] * 200 * 0.5 < 1100.0
    assert title_lines("", 1.0, 960.0)[0] == [""]


def test_sand_alone_fills_its_page_and_is_the_same_sand(folder, tmp_path):
    page = alone(None, view("standard"))
    assert max(page.size) == 1920 and page.panel.rows >= page.size[1] - 2
    drawn = ts.render(folder, tmp_path / "a.png", layout="sand", frame=10.0, size=(640, 640))
    image = bitmap(drawn.file)
    assert image.shape == (640, 640, 3)
    full = Renderer(Result(folder), Look(layout="sand", size=(640, 640)))
    panel = full.picture.canvas.panel
    assert panel.rows == 640 or panel.columns > 600
    assert (image[: panel.rows, : panel.left - 12] == 255).all()


def test_a_transparent_picture_on_white_is_the_opaque_one(folder, tmp_path):
    look = {"frame": 10.0, "size": (640, 360)}
    clear = bitmap(ts.render(folder, tmp_path / "clear.png", transparent=True, **look).file).astype(float)
    solid = bitmap(ts.render(folder, tmp_path / "solid.png", **look).file).astype(float)
    cover = clear[..., 3:] / 255.0
    seen = cover * clear[..., :3] + (1.0 - cover) * 255.0
    silo = Renderer(Result(folder), Look(size=(640, 360))).picture.canvas.panel
    outside = np.ones(seen.shape[:2], bool)
    outside[silo.slices] = False
    assert np.abs(seen - solid)[outside].max() <= 2.0
    inside = clear[silo.slices]
    middle = inside[inside.shape[0] // 2, inside.shape[1] // 2]
    assert middle[3] == 255 and (middle[:3] == solid[silo.slices][inside.shape[0] // 2, inside.shape[1] // 2]).all()
    assert inside[0, inside.shape[1] // 2, 3] == 0  # the air above the sand


def test_white_becomes_clear_and_black_stays():
    found = without_white(np.array([[[255, 255, 255], [0, 0, 0], [255, 128, 128]]], np.uint8))
    assert found[0, 0, 3] == 0 and tuple(found[0, 1]) == (0, 0, 0, 255)
    assert tuple(found[0, 2][:3]) == (255, 0, 0) and found[0, 2, 3] == 127


def test_a_sequence_is_numbered_pictures_and_only_such_a_folder_is_replaced(folder, tmp_path, capsys):
    target, look = tmp_path / "frames", ("--size", "320x180", "--seconds", "0.2", "--fps", "20")
    words = ["render", str(folder), "--output", str(target), *look, "--transparent", "--json"]
    app.make()(words, standalone_mode=False)
    assert json.loads(capsys.readouterr().out)["frames"] == 4
    assert [file.name for file in sorted(target.iterdir())] == [f"{k:05d}.png" for k in (1, 2, 3, 4)]
    assert Image.open(target / "00004.png").mode == "RGBA"
    with pytest.raises(BadInput, match="is there already"):
        app.make()(words, standalone_mode=False)
    (target / "thesis.tex").write_text("mine")
    with pytest.raises(BadInput, match="holds thesis.tex; it must be a new folder"):
        app.make()([*words, "--overwrite"], standalone_mode=False)
    assert (target / "thesis.tex").read_text() == "mine"


@pytest.mark.parametrize(("ending", "codec", "fps"), [(".webm", "vp9", 30), (".gif", "gif", 25)])
def test_other_films_show_the_same_frames(ending, codec, fps, folder, tmp_path):
    look = {"size": (320, 180), "seconds": 0.4, "fps": fps}
    stored = [ts.render(folder, tmp_path / f"a{kind}", **look) for kind in (".mp4", ending)]
    assert stored[0].frames == stored[1].frames
    images = []
    for one in stored:
        reader = imageio_ffmpeg.read_frames(str(one.file))
        about = next(reader)
        frames = [np.frombuffer(frame, np.uint8).reshape(180, 320, 3) for frame in reader]
        assert len(frames) == one.frames and about["fps"] == fps
        images.append(frames[-1].astype(int))
    assert about["codec"].startswith(codec)
    assert np.abs(images[0] - images[1]).mean() < 3.0
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(["a.mp4", f"a{ending}"])


def test_a_svg_has_the_sand_as_an_image_and_is_the_same_each_time(folder, tmp_path):
    for name in ("a", "b"):
        ts.render(folder, tmp_path / f"{name}.svg", frame=10.0, title="Sand & walls <1> $x")
    text = (tmp_path / "a.svg").read_text()
    assert text.startswith("<?xml") and text.count("<image") == 2  # the sand and the colours of the bar
    assert text == (tmp_path / "b.svg").read_text()


def test_a_svg_is_as_large_as_its_frame(folder, tmp_path):
    """Editors and browsers take its size from its first element."""
    ts.render(folder, tmp_path / "a.svg", frame=10.0, size=(640, 360))
    head = (tmp_path / "a.svg").read_text().split("<metadata>")[0]
    assert 'width="640" height="360"' in head and "viewBox" in head


def test_two_runs_of_one_title_are_told_apart_by_their_folders(folder, tmp_path):
    runtime.init("cpu", 1)
    other = made_up.leave(tmp_path / "again")
    runs = Result(folder), Result(other)
    titles = [[side.picture.canvas.title for side in Pair(runs, Look(size=(640, 360), title=own)).sides]
              for own in (None, "Mine")]  # fmt: skip
    assert [one.split(":")[0] for one in titles[0]] == [folder.name, "again"] and titles[1] == ["Mine", "Mine"]


def test_zoom_shows_a_part_of_the_same_picture_larger(folder, tmp_path):
    runtime.init("cpu", 1)
    history = Result(folder)
    whole, part = (Renderer(history, Look(size=(640, 360), zoom_mm=box)).picture for box in (None, (0, 0, 100, 100)))
    assert part.canvas.layout.pixels_per_metre > 2.0 * whole.canvas.layout.pixels_per_metre
    assert [bool(standing) for standing in part.canvas.walls] == [True, False]
    assert [bool(standing) for standing in whole.canvas.walls] == [True, True]
    points = made_up.state(history.scene, 0.0)
    place, values = points["position"], np.where(points["position"][:, 0] < 0.05, 0.6, 0.8)
    for picture in (whole, part):
        panel, page = picture.canvas.panel, picture.canvas.layout
        frame = picture.frame(place, values, Moment(0.0, "filling", 0.0))
        row = panel.top + round(page.pixels_per_metre * (picture.canvas.view.top - 0.05))
        here, there = (frame[row, panel.left + round(page.pixels_per_metre * x)] for x in (0.035, 0.045))
        edge = np.abs(here.astype(int) - there).max()
        assert edge > 60  # the border of both colours lies at x = 40 mm


def test_colours_by_name_are_even_in_lightness():
    """Lightness (L* of CIELAB) rises all the way, or up to the middle and falls then, so grey copies still tell."""
    for name in COLOURS:
        rgb = matplotlib.colormaps[name](np.linspace(0.0, 1.0, 64))[:, :3]
        linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        light = np.cbrt(np.maximum(linear @ (0.2126, 0.7152, 0.0722), 0.009)) * 116.0 - 16.0
        top = 63 if name in COLOURS[:6] else int(np.argmax(light))
        assert top == 63 or 24 < top < 40, name
        assert (np.diff(light[: top + 1]) > -0.6).all() and (np.diff(light[top:]) < 0.6).all(), name
        assert light[top] - light[0] > 30.0, name


def test_colours_are_those_asked_for(folder, tmp_path):
    drawn = ts.render(folder, tmp_path / "a.png", frame=10.0, size=(640, 360), colours="cividis")
    assert drawn.scale.colours == "cividis"
    assert (bitmap(drawn.file) != bitmap(ts.render(folder, tmp_path / "b.png", frame=10.0, size=(640, 360)).file)).any()


def test_a_slow_part_lasts_as_many_times_as_long_and_skips_nothing(folder):
    history = Result(folder)
    plain = moments.over(history, 100)
    slow = moments.slowed(plain, Slow(0.005, 0.010, 4.0))
    inside = [sum(0.005 < moment.progress <= 0.010 for moment in shown) for shown in (plain, slow)]
    assert inside[1] == pytest.approx(4 * inside[0], abs=5)
    assert len(slow) == pytest.approx(100 + 3 * inside[0], abs=4)
    assert slow[0] == plain[0] and slow[-1].progress == pytest.approx(plain[-1].progress)
    assert (np.diff([moment.time_s for moment in slow]) > 0.0).all()
    assert [moment.stage for moment in slow] == sorted(moment.stage for moment in slow)  # filling, then flow


def test_two_runs_have_one_clock_and_one_scale(folder, tmp_path):
    other = made_up.leave(tmp_path / "short", made_up.scene(silo=Silo(width_m=0.2, height_m=0.26)), states=20)
    shown = moments.together((Result(folder), Result(other)), 40)
    times = np.array([moment.time_s for moment in shown])
    assert (np.diff(times) > 0.0).all() and times[3] == pytest.approx(0.0) and times[-1] == pytest.approx(1.0)
    drawn = ts.render(folder, tmp_path / "a.png", beside=other, frame=0.5, size=(1280, 720))
    image = bitmap(drawn.file)
    assert image.shape == (720, 1280, 3) and drawn.size == (1280, 720)
    sides = Pair((Result(folder), Result(other)), Look(size=(1280, 720))).sides
    scales, deep = zip(
        *((p.pixels_per_metre, p.panel.rows) for p in (side.picture.canvas.layout for side in sides)), strict=True
    )
    assert scales[0] == pytest.approx(scales[1], rel=0.01)
    assert deep[0] / deep[1] == pytest.approx(0.5375 / 0.2891, rel=0.02)
    film = ts.render(folder, tmp_path / "a.mp4", beside=other, seconds=0.3, size=(640, 360))
    assert film.frames == 9
    tall = ts.render(folder, tmp_path / "b.png", beside=other, frame=0.5, size=(360, 640))
    assert bitmap(tall.file).shape == (640, 360, 3)


def test_sand_that_leaves_is_below_the_picture_by_the_next_state_and_falls_freely_at_least():
    place, speed = np.array([[0.03, 0.20], [0.10, 0.01]]), np.array([[0.0, 0.0], [0.0, -0.5]])
    way, whole = Way(0.08, 0.12, -0.02), 0.1
    paths = np.array([fallen(place, speed, t, whole, way) for t in np.linspace(0.0, whole, 21)])
    assert (np.diff(paths[..., 1], axis=0) < 0.0).all()
    assert (paths[-1, :, 1] <= -0.02 + 1e-12).all()
    assert ((paths[-1, :, 0] >= 0.08) & (paths[-1, :, 0] <= 0.12)).all()
    drop = place[1, 1] - paths[-1, 1, 1]
    assert drop >= 0.5 * whole + 0.5 * 9.81 * whole**2 - 1e-12
    assert fallen(place, speed, 0.05, whole, None) == pytest.approx(place + 0.05 * speed)


def noisy(folder, tmp_path, amplitude):
    """A run whose P, T and N swing about constant means by a share of the weight."""
    silo, flow = Silo(outlet=Outlet(width_m=0.08)), Flow(outflow="gravity", displacement_m=1.25, longest_s=9.0)
    what = made_up.scene(silo=silo, flow=flow)
    made_up.leave(folder, what)
    made_up.write_forces(folder, what, 1.5, rows=3000)
    table = Result(folder).forces
    time = table["time_s"].to_numpy()
    swing = amplitude * what.weight_N_per_m * np.sin(2.0 * np.pi * time / 0.011)
    for name in table.columns:
        if name.endswith("_N_per_m") and not name.startswith("weight"):
            table[name] += swing
    table[["time_s", "stage", "displacement_m", *[n for n in table.columns if n.endswith("_N_per_m")],
           "wall_friction_angle_deg"]].to_csv(folder / "forces.csv", index=False)  # fmt: skip
    return Result(folder)


def test_forces_that_swing_are_a_median_with_a_band_and_steady_ones_stay_as_they_are(tmp_path):
    fast = noisy(tmp_path / "fast", tmp_path, 0.2)
    found, weight = force_rows.ForceRows(fast), fast.scene.weight_N_per_m
    flow = (fast.forces["stage"] == "flow").to_numpy()
    inner = np.flatnonzero(flow)[200:-200]
    assert found.note and found.forces[inner, 0] == pytest.approx(weight / 3.0, abs=0.03 * weight)
    width = found.spread[inner, 0, 1] - found.spread[inner, 0, 0]
    assert width == pytest.approx(2.0 * 0.2 * np.sin(0.45 * np.pi) * weight, rel=0.05)  # 5 to 95 % of a sine
    still = force_rows.ForceRows(noisy(tmp_path / "still", tmp_path, 0.005))
    assert still.spread is None and not still.note
    assert (still.forces == Result(tmp_path / "still").forces[["P", "T", "N"]].to_numpy()).all()
    drawn = ts.render(fast, tmp_path / "a.png", frame=1.0, size=(1280, 720))
    assert drawn.frames == 1


def test_the_running_median_of_a_step_is_a_step():
    forces = np.where(np.arange(100) < 40, 1.0, 3.0)[:, None]
    median, spread = force_rows.running(forces, 20)
    assert (median == forces).all()
    assert (spread[..., 0] <= median).all() and (median <= spread[..., 1]).all()


def test_no_curve_leaves_the_axis_of_a_slender_silo_whose_walls_carry_more_than_the_weight(tmp_path):
    """N of one wall is above the weight where the silo is high: K0 of a tall column times its height."""
    what = made_up.scene(silo=Silo(width_m=0.2, height_m=1.0))
    history = Result(made_up.leave(tmp_path / "slender", what))
    table = history.forces
    scale = 1.4 * what.weight_N_per_m / table["N"].max()
    for name in ("left_normal_N_per_m", "right_normal_N_per_m"):
        table[name] *= scale
    table[["time_s", "stage", "displacement_m", *[n for n in table.columns if n.endswith("_N_per_m")],
           "wall_friction_angle_deg"]].to_csv(tmp_path / "slender" / "forces.csv", index=False)  # fmt: skip
    drawn = Renderer(Result(tmp_path / "slender"), Look(size=(640, 360)))
    canvas = drawn.picture.canvas
    assert drawn.forces.largest == pytest.approx(1.4 * what.weight_N_per_m, rel=1e-6)
    assert canvas.top_force == pytest.approx(1.1 * drawn.forces.largest)
    assert Renderer(history, Look(size=(640, 360))).picture.canvas.top_force == pytest.approx(1.1 * what.weight_N_per_m)
    assert canvas.furniture.forces.get_ylabel() == "force per metre run (kN/m)"

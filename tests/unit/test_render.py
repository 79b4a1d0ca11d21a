"""Films and pictures drawn afterwards: what a film of the run itself would show, of any field and size."""

import hashlib
import json
import typing

import imageio_ffmpeg
import numpy as np
import pandas as pd
import pytest
from PIL import Image

from taichi_silo.api import run
from taichi_silo.cli import app
from taichi_silo.cli.commands import render
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.runs import snapshot
from taichi_silo.runs.observers import film_recorder
from taichi_silo.runs.point_fields import FIELDS
from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import Flow, Machine, Mesh, Method, Scene
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.show.film import FilmError, encoder, films, moments, renderer
from taichi_silo.show.film.between import Between
from taichi_silo.show.film.furniture import MISSING
from taichi_silo.show.film.look import Look
from taichi_silo.show.film.point_raster import BACKGROUND, table
from tests import made_up

SMALL = (640, 360)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return made_up.leave(tmp_path_factory.mktemp("runs") / "silo")


@pytest.fixture(scope="module")
def history(folder):
    return Result(folder)


def command(*words):
    """The program with these words; what it says is for `capsys`."""
    return app.make()(list(map(str, words)), standalone_mode=False)


def picture(history, file, number=-1, **look):
    drawn = films.still(history, file, number % len(history.snapshots), Look(**{"size": SMALL} | look))
    return np.asarray(Image.open(file)), drawn.picture.canvas


def frames_of(file):
    reader = imageio_ffmpeg.read_frames(str(file))
    about = next(reader)
    return about, [np.frombuffer(frame, np.uint8).reshape(*about["size"][::-1], 3) for frame in reader]


def digests(folder):
    return {file: hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.rglob("*") if file.is_file()}


def test_a_film_has_the_size_length_and_rate_asked_for_and_disturbs_nothing(folder, capsys):
    before = digests(folder)
    command("render", folder, "--field", "layers", "--size", "640x360", "--seconds", 2, "--fps", 20, "--json")
    told = json.loads(capsys.readouterr().out)
    about, frames = frames_of(folder / "layers.mp4")
    assert (about["size"], about["fps"], len(frames)) == (SMALL, 20, 40)
    assert about["codec"] == "h264" and about["pix_fmt"].startswith("yuv420p")
    assert told["film"] == str(folder / "layers.mp4") and told["frames"] == 40 and told["size"] == [640, 360]
    after = digests(folder)
    assert set(after) - set(before) == {folder / "layers.mp4"}
    assert all(after[file] == digest for file, digest in before.items())


def test_a_film_that_is_there_is_replaced_only_if_asked(folder, tmp_path):
    file = tmp_path / "a.mp4"
    file.write_text("mine")
    words = ("render", folder, "--output", file, "--size", "320x180", "--seconds", 0.2, "--quiet")
    with pytest.raises(BadInput, match="is there already"):
        command(*words)
    assert file.read_text() == "mine"
    command(*words, "--overwrite")
    assert len(frames_of(file)[1]) == 6


def test_a_film_that_cannot_be_finished_leaves_nothing(history, tmp_path):
    def interrupted():
        yield from moments.over(history, 20)[:3]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        films.film(history, tmp_path / "a.mp4", interrupted(), Look(size=SMALL))
    assert not list(tmp_path.iterdir())


def test_the_last_frame_is_that_of_the_film_that_the_run_has_drawn(tmp_path, monkeypatch):
    monkeypatch.setitem(film_recorder.FRAMES, "flow", 8)
    monkeypatch.setitem(film_recorder.FRAMES, "filling", 2)
    scene = Scene(
        silo=Silo(width_m=0.2, height_m=0.4), grid=Mesh(cell_size_m=0.05), machine=Machine(threads=1),
        flow=Flow(speed_m_per_s=0.02, displacement_m=0.002), method=Method(filling_time_s=0.1),
    )  # fmt: skip
    run(scene, tmp_path, progress=False)
    _, frames = frames_of(tmp_path / "void_ratio.mp4")
    still, _ = picture(Result(tmp_path), tmp_path / "a.png", size=(1920, 1080))
    error = np.abs(frames[-1].astype(int) - still).max(axis=2)
    assert error.mean() < 1.5 and (error > 60).mean() < 1e-3  # the encoder's noise


@pytest.mark.parametrize("field", FIELDS)
def test_the_picture_of_a_half_is_that_of_the_whole(tmp_path, field):
    found = []
    for half in (False, True):
        left = made_up.leave(tmp_path / f"{half}", states=2, half=half)
        found.append(picture(Result(left), tmp_path / f"{half}.png", field=field)[0])
    assert (found[0] == found[1]).all(axis=2).mean() > 0.9995  # between two points equally near either may win
    assert (found[0] != found[0][0, 0]).any()


def test_sand_has_the_colour_of_its_value_and_grey_where_it_has_none(tmp_path):
    left = made_up.leave(tmp_path / "run", states=1)
    points = made_up.state(made_up.scene(), 0.02)
    core = np.abs(points["position"][:, 0] - 0.1) < 0.03
    points["stress"] = np.where(core[:, None], -1.0, points["stress"]) * (1.0, 1.0, 1.0, 0.0)
    snapshot.write(left / "snapshots" / "flow_020.000mm.vtu", points)
    image, canvas = picture(Result(left), tmp_path / "a.png", field="mobilised_friction")
    panel = image[canvas.panel.slices]
    middle = panel[panel.shape[0] // 2]
    assert tuple(middle[len(middle) // 2]) == MISSING
    ratio = np.degrees(np.arcsin((1.0 - 0.5) / 1.5))
    colour = table("coolwarm")[round((ratio - 5.0) / 50.0 * 255)]
    assert np.abs(middle[len(middle) // 10] - colour).max() <= 1
    assert tuple(panel[0, len(middle) // 2]) == BACKGROUND


def test_a_smaller_page_is_laid_out_as_the_large_one(history, tmp_path):
    (_, large), (small_image, small) = (
        picture(history, tmp_path / "a.png", size=size) for size in ((1920, 1080), SMALL)
    )
    assert small_image.shape == (360, 640, 3)
    for one, other in ((large.panel, small.panel), (large.plot, small.plot)):
        assert np.array(one) / 3.0 == pytest.approx(np.array(other), abs=1.5)


def test_points_move_on_straight_lines_and_leaving_ones_go_on(tmp_path):
    def gone(points, part):
        return (points["identity"] < 50) & (part > 0.7)

    history = Result(made_up.leave(tmp_path / "run", states=2, left=gone))
    between = Between(history, lambda points: points["void_ratio"])
    before, after = (made_up.state(history.scene, u) for u in (0.01, 0.02))
    position, values = between.at(made_up.FILLED_S + 0.75)
    assert len(position) == 250
    assert position[:200] == pytest.approx(0.5 * (before["position"] + after["position"])[50:])
    assert values[:200] == pytest.approx(0.5 * (before["void_ratio"] + after["void_ratio"])[50:], abs=1e-6)
    assert position[200:] == pytest.approx((before["position"] + 0.25 * before["velocity"])[:50])
    position, _ = between.at(made_up.FILLED_S + 1.0)  # a state
    assert position == pytest.approx(after["position"][50:])


def test_frames_are_even_in_displacement_after_a_tenth_for_the_filling(history):
    shown = moments.over(history, 100)
    filling = [moment for moment in shown if moment.stage == "filling"]
    flow = [moment for moment in shown if moment.stage == "flow"]
    assert (len(filling), len(flow)) == (10, 90)
    assert filling[-1].time_s == made_up.FILLED_S
    assert np.diff([0.0] + [moment.progress for moment in flow]) == pytest.approx(made_up.DEPTH / 90)
    assert flow[-1].progress == pytest.approx(made_up.DEPTH)


def test_a_film_at_half_speed_lasts_twice_as_long(history):
    shown = moments.at_speed(history, 0.5, 30)
    assert len(shown) == round(2.0 * 1.5 * 30)
    assert np.diff([moment.time_s for moment in shown]) == pytest.approx(1.0 / 60.0)
    assert shown[-1].progress == pytest.approx(made_up.DEPTH)


def test_free_outflow_is_shown_in_time_as_long_as_it_lasted(tmp_path):
    silo, flow = Silo(outlet=Outlet(width_m=0.08)), Flow(outflow="gravity", displacement_m=1.25, longest_s=9.0)
    history = Result(made_up.leave(tmp_path / "run", made_up.scene(silo=silo, flow=flow)))
    assert renderer.course_over(history).end == pytest.approx(1.0)
    flow = [moment.progress for moment in moments.over(history, 50) if moment.stage == "flow"]
    assert np.diff([0.0, *flow]) == pytest.approx(1.0 / len(flow))
    assert history.snapshots["file"][moments.nearest(history, 0.5)] == "flow_010.000mm.vtu"


def test_one_frame_shows_the_nearest_snapshot(folder, history, capsys):
    command("render", folder, "--field", "speed", "--frame", 4.9, "--size", "320x180", "--json")
    told = json.loads(capsys.readouterr().out)
    assert told["snapshot"] == "flow_005.000mm.vtu"
    assert Image.open(folder / "speed_4.9mm.png").size == (320, 180)
    assert history.snapshots["file"][moments.nearest(history, 0.0)] == "filled.vtu"
    with pytest.raises(BadInput, match="frame is 21 mm; it must be from 0 to 20 mm"):
        moments.nearest(history, 0.021)


def test_a_run_that_goes_on_is_drawn_as_far_as_it_has_come(tmp_path):
    left = made_up.leave(tmp_path / "run")
    index = pd.read_csv(left / "snapshots" / "index.csv")
    index.iloc[:15].to_csv(left / "snapshots" / "index.csv", index=False)
    with open(left / "forces.csv", "a") as stream:
        stream.write("1.51,flow,0.02")  # a row that is being written
    history = Result(left)
    assert moments.over(history, 100)[-1].progress == pytest.approx(0.013)
    films.film(history, tmp_path / "a.mp4", moments.over(history, 5), Look(size=(320, 180)))
    assert len(frames_of(tmp_path / "a.mp4")[1]) == 5


@pytest.mark.parametrize(
    "words, sentence",
    [
        (["--field", "colour"], "field is colour; it must be one of"),
        (["--range", "3"], "range is 3; it must be LOW,HIGH"),
        (["--range", "3,1"], "range is 3,1; it must be LOW,HIGH"),
        (["--range", "nan,1"], "range is nan,1; it must be LOW,HIGH"),
        (["--size", "1280"], "size is 1280; it must be COLUMNSxROWS"),
        (["--size", "641x360"], "size is 641x360; .* even numbers"),
        (["--size", "64x36"], "size is 64x36; .* from 320x180"),
        (["--fps", "0"], "fps is 0; it must be from 1 to 120"),
        (["--seconds", "0"], "seconds is 0; it must be from 0.1 to 600"),
        (["--speed", "-1"], "speed is -1; it must be from"),
        (["--speed", "1", "--seconds", "3"], "speed is 1; it cannot be given together"),
        (["--speed", "1e-5"], "speed is 1e-05; the film would last"),
        (["--output", "film.avi"], "output is film.avi; it must end with .mp4, .webm, .gif, or be a folder"),
        (["--output", "film.svg"], "output is film.svg; it must end with .mp4"),
        (["--output", "a.gif", "--fps", "30"], "fps is 30; of a GIF it must be one of 1, 2, 4"),
        (["--frame", "3", "--output", "a.mp4"], "output is a.mp4; it must end with .png or .svg"),
        (["--transparent", "--output", "a.mp4"], "output is a.mp4; only pictures are transparent"),
        (["--layout", "4:3"], "layout is 4:3; it must be one of 16:9, 9:16, 1:1, sand"),
        (["--layout", "9:16", "--size", "1280x720"], "size is 1280x720; of the layout 9:16 it must have that form"),
        (["--layout", "sand", "--title", "Sand"], "title is 'Sand'; the layout sand has nothing but sand"),
        (["--title", "two\nlines"], "it must be one line of at most 200 characters"),
        (["--colours", "jet"], "colours is jet; it must be one of viridis, cividis"),
        (["--colours", "cividis", "--field", "layers"], "colours is cividis; the classes of layers have colours"),
        (["--zoom", "0,0,1"], "zoom is 0,0,1; it must be LEFT,BOTTOM,RIGHT,TOP in mm: four numbers"),
        (["--zoom", "0,0,300,100"], "zoom is 0,0,300,100; .* within 0,-30,200,507.5 and at least 40 mm"),
        (["--zoom", "50,0,51,100"], "zoom is 50,0,51,100; it must be LEFT,BOTTOM,RIGHT,TOP"),
        (["--slow", "5,1,4"], "slow is 5,1,4; it must be FROM,TO,TIMES"),
        (["--slow", "0,20,1000"], "slow is 1000 times; the film would last"),
        (["--frame", "3", "--slow", "0,1,2"], "slow is 0,1,2; one picture has no slow part"),
        (["--beside", "nowhere"], "it must be that of a run"),
        (["--frame", "30"], "frame is 30 mm; it must be from 0 to 20 mm"),
        (["--frame", "3", "--seconds", "3"], "frame is 3; one picture has neither"),
    ],
)
def test_what_is_not_possible_is_refused_in_a_sentence(folder, words, sentence):
    before = digests(folder)
    with pytest.raises(BadInput, match=sentence):
        command("render", folder, *words)
    assert digests(folder) == before


def test_the_help_names_all_fields():
    parameters = typing.get_type_hints(render.command, include_extras=True)
    (option,) = parameters["field"].__metadata__
    assert option.help.split(" | ") == list(FIELDS)


def test_trouble_while_drawing_is_told_in_a_sentence(folder, tmp_path, monkeypatch):
    def broken(writer, frame, file):
        raise FilmError("ffmpeg stopped: no space left")

    monkeypatch.setattr(encoder, "_append", broken)
    with pytest.raises(RunFailed, match=r"a.mp4 could not be drawn: ffmpeg stopped: no space left; see to that"):
        command("render", folder, "--field", "speed", "--size", "320x180", "--output", tmp_path / "a.mp4")
    assert not list(tmp_path.iterdir())


def test_a_folder_without_enough_to_draw_is_refused_in_a_sentence(tmp_path):
    with pytest.raises(BadInput, match="it must be that of a run, and it holds no run.toml"):
        command("render", tmp_path)
    left = made_up.leave(tmp_path / "run", states=4)
    with pytest.raises(BadInput, match="snapshots of the flow are 4; a film needs at least 10"):
        command("render", left)
    (left / "snapshots" / "index.csv").unlink()
    with pytest.raises(BadInput, match="has no snapshots"):
        command("render", left)
    assert not list(left.glob("*.mp4"))

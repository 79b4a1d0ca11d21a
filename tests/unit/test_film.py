import imageio_ffmpeg
import matplotlib
import numpy as np
import pytest

from taichi_silo.mpm.language import ti
from taichi_silo.runs.point_fields import Scale
from taichi_silo.scene.scene import Scene
from taichi_silo.show.film.canvas import Canvas
from taichi_silo.show.film.curves import Course
from taichi_silo.show.film.encoder import encode
from taichi_silo.show.film.layout import SIZE, View, layout
from taichi_silo.show.film.lettering import INK
from taichi_silo.show.film.moments import Moment
from taichi_silo.show.film.picture import Picture, course_of
from taichi_silo.show.film.point_raster import BACKGROUND, COLOURS, SandRaster
from tests import made_up

WIDTH, HEIGHT, DISPLACEMENT, SPACING, WEIGHT = 0.2, 0.5, 0.02, 0.005, 1625.0
VOID_RATIOS = Scale("void ratio e", "viridis", 0.55, 0.85, words=("dense", "loose"))
FAR_BELOW = (-1.0, -1.1)  # plate heights that keep it out of the picture


@pytest.fixture(scope="module", autouse=True)
def taichi():
    ti.init(arch=ti.cpu, default_fp=ti.f64, cpu_max_num_threads=1, log_level=ti.ERROR)


@pytest.fixture(scope="module")
def raster():
    return SandRaster(columns=160, rows=200, pixels_per_metre=1635.0, top_m=0.1, spacing_m=SPACING)


def lattice(columns, rows):
    x, y = np.meshgrid((np.arange(columns) + 0.5) * SPACING, (np.arange(rows) + 0.5) * SPACING)
    return np.stack((x.ravel(), y.ravel()), axis=1)


def is_drawn(image):
    return (image != np.array(BACKGROUND)).any(axis=2)


def read_frames(path):
    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    return meta, [np.frombuffer(frame, np.uint8).reshape(*meta["size"][::-1], 3) for frame in reader]


def test_sheared_and_dilated_lattice_has_no_gaps(raster):
    position = lattice(60, 60)
    position[:, 1] = 1.4 * position[:, 1] - 0.8 * position[:, 0]  # shear
    position[:, 0] = 1.4 * position[:, 0] - 0.02
    position[:, 1] -= 0.1
    image = raster.draw(position, np.full(len(position), 40), *FAR_BELOW)
    colour = np.rint(255 * np.array(matplotlib.colormaps["viridis"](40 / (COLOURS - 1))[:3]))
    assert (image == colour).all(axis=2).all()


def test_pixel_has_the_colour_of_the_nearest_point(raster):
    random = np.random.default_rng(3)
    position = lattice(19, 24) + random.uniform(-0.2, 0.2, (19 * 24, 2)) * SPACING
    level = random.integers(0, COLOURS, len(position))
    image = raster.draw(position, level, *FAR_BELOW).astype(int)
    colours = np.rint(255 * matplotlib.colormaps["viridis"](np.linspace(0, 1, COLOURS))[:, :3]).astype(int)
    checked = 0
    for row, column in random.integers((8, 8), (150, 145), (400, 2)):
        pixel = np.array([column + 0.5, row + 0.5]) / 1635.0
        distances = np.sort(np.hypot(position[:, 0] - pixel[0], 0.1 - position[:, 1] - pixel[1]))
        if distances[1] - distances[0] < 2 / 1635.0:
            continue  # on a border, where a pixel mixes two points
        nearest = np.argmin(np.hypot(position[:, 0] - pixel[0], 0.1 - position[:, 1] - pixel[1]))
        assert (image[row, column] == colours[level[nearest]]).all()
        checked += 1
    assert checked > 100


def test_one_point_is_a_square_and_leaves_no_trace(raster):
    image = raster.draw(np.array([[0.05, 0.05]]), np.array([0]), *FAR_BELOW)
    rows, columns = np.nonzero(is_drawn(image))
    side = 1.5 * SPACING * 1635.0
    assert abs(np.ptp(rows) + 1 - side) < 2 and abs(np.ptp(columns) + 1 - side) < 2
    assert len(rows) == (np.ptp(rows) + 1) * (np.ptp(columns) + 1)
    assert not is_drawn(raster.draw(np.zeros((0, 2)), np.zeros(0), *FAR_BELOW)).any()


def test_film_is_h264_of_the_right_size_and_shows_what_was_drawn(tmp_path):
    path, scene = tmp_path / "void_ratio.mp4", made_up.scene(SPACING)
    picture = Picture(scene, VOID_RATIOS, course_of(scene))
    canvas, position = picture.canvas, lattice(40, 100)
    bare, panel = canvas.background.copy(), canvas.panel

    def drawn():
        for k in range(8):
            u = max(0, k - 2) / 5 * DISPLACEMENT
            canvas.add_forces(u, np.array([560.0 - 1e4 * u, 530.0, 550.0 + 2e4 * u]))
            sunk = position - (0.0, u)
            sunk[0] = np.nan  # a lost point spoils nothing
            void_ratio = np.where(np.abs(position[:, 0] - WIDTH / 2) > 0.08, 0.8, 0.6)
            yield picture.frame(sunk, void_ratio, Moment(0.1 * k, "flow" if u else "filling", u))
            assert not path.exists()

    assert encode(path, drawn()) == 8
    assert list(tmp_path.iterdir()) == [path]
    meta, frames = read_frames(path)
    assert meta["size"] == (1920, 1080) and meta["fps"] == 30 and len(frames) == 8
    assert meta["codec"] == "h264" and meta["pix_fmt"].startswith("yuv420p")
    data = path.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")  # a browser can start before it has all

    # beside the walls every frame shows the bare page, up to the encoder's noise
    rows = slice(panel.top, panel.top + panel.rows - 20)
    for columns in (slice(0, panel.left - 12), slice(panel.left + panel.columns + 12, canvas.plot.left - 20)):
        for frame in frames:
            error = np.abs(frame[rows, columns].astype(int) - bare[rows, columns])
            assert np.median(error) <= 2 and (error > 60).mean() < 1e-3
    # sand in the middle of the silo has the colour of its void ratio, 0.6
    centre = frames[-1][panel.top + panel.rows // 2, panel.left + panel.columns // 2]
    colour = 255 * np.array(matplotlib.colormaps["viridis"]((0.6 - 0.55) / 0.3)[:3])
    assert np.abs(centre - colour).max() < 12


OF_THREE = {
    "width_m": 0.4, "height_m": 0.2,
    "outlet": [{"width_m": 0.1, "position": 0.1}, {"width_m": 0.04, "position": 0.3},
               {"width_m": 0.06, "position": 0.1, "wall": "right"}],
}  # fmt: skip


def drawn_of(silo, flow, position):
    """Where the frame of a film shows the ink of walls and floor, as a function of a place [m]."""
    scene = Scene.model_validate({"silo": silo, "flow": flow, "grid": {"cell_size_m": 0.01}})
    picture = Picture(scene, VOID_RATIOS, course_of(scene))
    panel, per_m = picture.canvas.panel, picture.canvas.layout.pixels_per_metre
    frame = picture.frame(position, np.full(len(position), 0.7), Moment(0.1, "flow", 0.0))

    def is_ink(x, y):
        row, column = panel.top + (picture.canvas.view.top - y) * per_m, panel.left + x * per_m
        return bool((frame[round(row), round(column)] == INK).all())

    return is_ink


def test_a_column_stands_on_a_floor_from_wall_to_wall():
    column = {"width_m": 0.4, "height_m": 0.1, "column_m": [0.1, 0.2]}
    is_ink = drawn_of(column, {"outflow": "collapse"}, lattice(20, 20) + (0.1, 0.0))
    assert all(is_ink(x, -0.002) for x in np.linspace(0.005, 0.395, 40))
    assert not any(is_ink(x, 0.002) for x in np.linspace(0.005, 0.395, 40))


def test_floor_and_walls_are_open_at_their_outlets_only():
    is_ink = drawn_of(OF_THREE, {}, lattice(80, 40))
    floor = {x: is_ink(x, -0.002) for x in (0.03, 0.08, 0.12, 0.17, 0.27, 0.29, 0.31, 0.33)}
    assert floor == {0.03: True, 0.08: False, 0.12: False, 0.17: True, 0.27: True, 0.29: False, 0.31: False, 0.33: True}
    right = {y: is_ink(0.4025, y) for y in (0.02, 0.065, 0.08, 0.12, 0.135, 0.19)}
    assert right == {0.02: True, 0.065: True, 0.08: False, 0.12: False, 0.135: True, 0.19: True}
    assert all(is_ink(-0.0025, y) for y in (0.02, 0.1, 0.19))


def test_film_without_frames_leaves_nothing(tmp_path):
    assert encode(tmp_path / "empty.mp4", []) == 0
    assert not list(tmp_path.iterdir())


WALL = [(-np.inf, np.inf)]


def test_curves_start_with_the_flow_and_do_not_run_back():
    view = View(0.0, -DISPLACEMENT - 0.01, WIDTH, 1.015 * HEIGHT)
    canvas = Canvas(layout(SIZE, view), view, (WALL, WALL), WEIGHT, VOID_RATIOS, "", Course(DISPLACEMENT))
    bare = canvas.background.copy()
    for force in (100.0, 500.0):
        canvas.add_forces(0.0, np.full(3, force))
    assert (canvas.background == bare).all()  # filling moves the points only
    canvas.add_forces(0.01, np.array([500.0, 700.0, 900.0]))
    rows, columns = canvas.plot.slices
    changed = (canvas.background != bare).any(axis=2)
    assert changed[rows, columns].sum() == changed.sum() > 1000
    blue = canvas.background[rows, columns][round((1 - 500 / (1.1 * WEIGHT)) * 669), 200]
    assert tuple(blue) == (0, 114, 178)

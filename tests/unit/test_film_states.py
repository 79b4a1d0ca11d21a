"""The states that a film shows: small, as exact as a frame, and whole up to wherever a run that died came."""

import zlib

import numpy as np
import pytest

from taichi_silo.errors import BadInput
from taichi_silo.runs import film_states
from taichi_silo.runs.film_states import FilmStates, Packing
from tests import made_up

SCENE = made_up.scene(0.005)
COUNT, SHOWN = 60, 405 / 60


def course():
    """States of 4,000 points that sink and dilate; some leave, and the order of the others changes."""
    random = np.random.default_rng(1)
    for k in range(COUNT):
        points = made_up.state(SCENE, made_up.DEPTH * k / 405)
        points["position"] += 1e-6 * random.standard_normal(points["position"].shape)
        points["void_ratio"] += 1e-4 * random.standard_normal(len(points["mass"]))
        points["identity"] = np.where(points["identity"] % 2, points["identity"], -1 - points["identity"])
        kept = np.arange(len(points["mass"])) >= 7 * max(0, k - 30)
        order = np.argsort(random.random(kept.sum())) if k == 40 else slice(None)
        yield {name: values[kept][order] for name, values in points.items()}


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    file = tmp_path_factory.mktemp("film") / film_states.NAME
    head, units = film_states.head(SCENE.spacing_m)
    packing = Packing()
    pieces = [
        film_states.piece(packing, units, points, 0.1 * k, "flow" if k > 9 else "filling", 1e-4 * k, 1 + k % 2)
        for k, points in enumerate(course())
    ]
    file.write_bytes(head + b"".join(pieces))
    return file


@pytest.fixture
def copy(file, tmp_path):
    return tmp_path / file.name


def test_states_come_back_to_a_hundredth_of_a_pixel_in_any_order(file):
    states, wanted = FilmStates(file), list(course())
    assert len(states.index) == COUNT
    assert states.index["time_s"].to_numpy() == pytest.approx(0.1 * np.arange(COUNT))
    assert states.index["stage"].tolist() == 10 * ["filling"] + (COUNT - 10) * ["flow"]
    assert states.index["shown"].tolist() == [1, 2] * (COUNT // 2)
    pixel = SCENE.silo.height_m / 870
    for k in (0, 1, 29, 30, 31, 32, 40, 41, COUNT - 1, 5):
        found = states.state(k)
        assert (found["identity"] == wanted[k]["identity"]).all()
        assert np.abs(found["position"] - wanted[k]["position"]).max() < 0.01 * pixel
        assert np.abs(found["void_ratio"] - wanted[k]["void_ratio"]).max() < 1e-5
    velocity = states.state(20)["velocity"]
    moved = wanted[20]["position"] - wanted[19]["position"]
    assert velocity == pytest.approx(moved / 0.1, abs=3e-5)


def test_a_film_of_16000_points_takes_less_than_fifty_megabytes(file):
    points = sum(len(one["mass"]) for one in course())
    assert 450 * 16_000 * file.stat().st_size / points < 50e6


def test_points_that_are_not_finite_are_left_out(copy):
    (points, *_), (head, units) = course(), film_states.head(SCENE.spacing_m)
    points["position"][7, 0], points["void_ratio"][3], points["position"][9, 1] = np.nan, np.inf, 1e30
    copy.write_bytes(head + film_states.piece(Packing(), units, points, 0.0, "filling", 0.0, 1))
    gone = set(points["identity"]) - set(FilmStates(copy).state(0)["identity"])
    assert gone == set(points["identity"][[3, 7, 9]])


@pytest.mark.parametrize("lost", [1, 100, 5000])
def test_a_file_that_was_cut_off_holds_all_whole_states(file, copy, lost):
    copy.write_bytes(file.read_bytes()[:-lost])
    states = FilmStates(copy)
    assert len(states.index) == COUNT - 1
    assert (states.state(COUNT - 2)["position"] == FilmStates(file).state(COUNT - 2)["position"]).all()


def test_what_is_packed_after_a_break_is_what_would_have_been_packed(file, copy):
    whole, states = file.read_bytes(), FilmStates(file)
    end, (_, units) = states.pieces[20][0], film_states.head(SCENE.spacing_m)
    copy.write_bytes(whole[:end])
    packing, again = FilmStates(copy).last_packing(), whole[:end]
    for k, points in enumerate(course()):
        if k >= 20:
            stage = "flow" if k > 9 else "filling"
            again += film_states.piece(packing, units, points, 0.1 * k, stage, 1e-4 * k, 1 + k % 2)
    assert again == whole


def test_a_damaged_file_is_refused_in_a_sentence(file, copy):
    whole, random = file.read_bytes(), np.random.default_rng(2)
    for _ in range(30):
        spoiled = bytearray(whole)
        spoiled[random.integers(len(whole))] ^= 1 << random.integers(8)
        copy.write_bytes(spoiled)
        try:
            states = FilmStates(copy)
            states.state(len(states.index) - 1)
        except BadInput as error:
            assert "is damaged: " in str(error) and "films are drawn from the snapshots" in str(error)
        else:  # of the head, or lengths that hide what comes after
            assert len(states.index) <= COUNT
    copy.write_bytes(b"no film")
    with pytest.raises(BadInput, match="it begins otherwise"):
        FilmStates(copy)


def test_a_piece_that_promises_little_and_holds_much_is_not_unpacked(copy):
    head, _ = film_states.head(SCENE.spacing_m)
    packed = zlib.compress(bytes(50_000_000))
    rest = film_states.PIECE.pack(0, 0, 0.0, 0.0, 0, True, 1, 3)[8:] + packed
    copy.write_bytes(head + film_states.struct.pack("<II", len(packed), zlib.crc32(rest)) + rest)
    with pytest.raises(BadInput, match="is damaged"):
        FilmStates(copy).state(0)

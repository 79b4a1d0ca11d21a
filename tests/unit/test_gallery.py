"""The page of all runs: pictures inside, films linked, whatever state a run is in."""

import json
import re
from html.parser import HTMLParser
from urllib.parse import unquote

import pytest
from PIL import Image

from taichi_silo.cli import app
from taichi_silo.errors import BadInput
from taichi_silo.runs.result import Result
from taichi_silo.show.film import films, moments
from taichi_silo.show.film.look import Look
from tests import made_up


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """Three runs: one that has ended, with a film; one that went wrong; one that has left nothing to show."""
    place = tmp_path_factory.mktemp("all runs")
    ended = made_up.leave(place / "dense & rough", states=10)
    history = Result(ended)
    look = Look(field="layers", size=(320, 180))
    films.film(history, ended / "layers.mp4", moments.over(history, 5), look)
    (ended / "void_ratio.mp4").write_text("no film")
    forces = {"bottom_N_per_m": 365.4, "shear_N_per_m": 630.0, "normal_N_per_m": 1e3, "wall_friction_angle_deg": 32.2}
    (ended / "summary.json").write_text(json.dumps({"finished": True, "residual": forces}))
    failed = made_up.leave(place / "series" / "second", states=1)
    (failed / "summary.json").write_text(json.dumps({"finished": False, "failure": "the step was <too> long"}))
    for folder in (ended, failed):
        (folder / "figures").mkdir()
        Image.new("RGB", (1800, 600), "white").save(folder / "figures" / "forces.png")
    (failed / "figures" / "wall_stress.png").write_text("no figure")
    made_up.leave(place / "bare", states=1)
    return place


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.links, self.pictures, self.words = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag == "a":
            self.links.append(values["href"])
        if tag == "img":
            self.pictures.append(values["src"])

    def handle_data(self, data):
        self.words += data


@pytest.fixture(scope="module")
def page(root, tmp_path_factory):
    folder = tmp_path_factory.mktemp("elsewhere") / "page"
    app.make()(["gallery", str(root), "--output", str(folder), "--quiet"], standalone_mode=False)
    return folder / "index.html"


def test_the_page_shows_each_run_that_has_something_to_show(page):
    words = Page(page.read_text(encoding="utf-8")).words
    assert "dense & rough" in words and "series/second" in words and "bare" not in words
    assert "2 runs" in words
    assert "0.365 kN/m" in words and "32.2°" in words and "20 mm" in words
    assert "It went wrong: the step was <too> long." in words


def test_pictures_stand_in_the_page_and_films_are_linked(page, root):
    text = page.read_text(encoding="utf-8")
    found = Page(text)
    assert len(found.pictures) == 3  # a film and two figures; what is damaged is left out
    assert all(picture.startswith("data:image/jpeg;base64,") for picture in found.pictures)
    links = [link for link in found.links if not link.startswith("#")]
    assert {(page.parent / unquote(link)).resolve() for link in links} == {
        root / "dense & rough" / "layers.mp4", root / "dense & rough" / "figures" / "forces.png",
        root / "series" / "second" / "figures" / "forces.png",
    }  # fmt: skip
    assert not re.search(r"(https?:)?//[a-z]", re.sub(r'"data:[^"]*"', "", text))  # nothing from elsewhere


def test_the_page_is_told_and_stands_among_the_runs_unless_told_otherwise(root, capsys):
    app.make()(["gallery", str(root), "--json"], standalone_mode=False)
    told = json.loads(capsys.readouterr().out)
    assert told == {"page": str(root / "gallery_page" / "index.html"), "runs": ["dense & rough", "series/second"]}
    assert [file.name for file in (root / "gallery_page").iterdir()] == ["index.html"]


def test_a_folder_without_runs_is_refused_in_a_sentence(tmp_path):
    with pytest.raises(BadInput, match="it must be a folder that holds runs"):
        app.make()(["gallery", str(tmp_path / "none")], standalone_mode=False)
    with pytest.raises(BadInput, match="holds 0 runs"):
        app.make()(["gallery", str(tmp_path)], standalone_mode=False)
    assert not list(tmp_path.iterdir())

"""The report of a real run in a browser: everything shows, the film plays, nothing is fetched, nothing sticks out."""

import pytest

from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.show.report import page as report_page


@pytest.fixture(scope="module")
def report(small_run, tmp_path_factory):
    folder = small_run(
        tmp_path_factory.mktemp("browser") / "run", film=True, walls="very-rough", silo=Silo(outlet=Outlet(width_m=0.1))
    )
    return report_page.report(folder)


@pytest.fixture
def opened(page, report):
    page.goto(report.as_uri())
    page.wait_for_function("[...document.images].every(one => one.complete)")
    return page


def test_all_images_show_and_nothing_complains(opened, screen, tmp_path):
    shot = opened.screenshot(path=tmp_path / f"{screen}.png", full_page=True)
    assert len(shot) > 50_000
    widths = opened.evaluate("[...document.images].map(one => one.naturalWidth)")
    assert len(widths) == 5
    assert all(width > 300 for width in widths)
    assert opened.complaints == []


def test_nothing_is_asked_of_the_network(opened, report):
    assert [url for url in opened.requests if not url.startswith("data:")] == [report.as_uri()]


def test_the_page_is_as_wide_as_the_screen(opened):
    wide, inner = opened.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
    screen = opened.viewport_size["width"]
    assert wide <= inner == screen  # a phone zooms out where a page is too wide: both grow then
    outside = opened.evaluate(
        """screen => [...document.querySelectorAll("main *")]
           .filter(one => !one.closest(".scroll *, .plate *, pre *, svg *") && one.getBoundingClientRect().width > 0)
           .filter(one => one.getBoundingClientRect().right > screen + 1).map(one => one.outerHTML.slice(0, 80))""",
        screen,
    )
    assert outside == []


def test_wide_tables_scroll_in_their_own_box(opened, screen):
    wider = opened.evaluate(
        "[...document.querySelectorAll('.scroll')].filter(one => one.scrollWidth > one.clientWidth).length"
    )
    assert (wider > 0) == (screen == "phone")


def test_the_film_plays(opened, screen, tmp_path):
    film = opened.locator("video")
    film.scroll_into_view_if_needed()
    assert film.evaluate("one => one.muted && one.controls && one.playsInline && one.poster.startsWith('data:image/')")
    film.evaluate("one => one.play()")
    opened.wait_for_function("document.querySelector('video').currentTime > 0.4")
    size = film.evaluate("one => [one.videoWidth, one.videoHeight, one.error]")
    assert size == [1920, 1080, None]
    film.screenshot(path=tmp_path / f"film_{screen}.png")
    assert opened.complaints == []


def test_dark_screens_get_a_dark_page(opened, screen):
    def brightness(selector):
        color = opened.evaluate(f"getComputedStyle(document.querySelector('{selector}')).backgroundColor")
        return sum(map(int, color.removeprefix("rgb(").removesuffix(")").split(", "))) / 3

    assert (brightness("body") < 60) == (screen == "dark")
    assert brightness(".plate") > 240  # figures are drawn on white


def test_on_paper_the_page_is_light_and_the_film_a_picture(opened):
    opened.emulate_media(media="print")
    assert opened.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert not opened.locator("video").is_visible()
    assert opened.locator("img.still").is_visible()
    assert not opened.locator("nav").is_visible()

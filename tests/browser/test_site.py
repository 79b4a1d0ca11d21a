"""The documentation in a browser: no errors, nothing from elsewhere, equations and pictures are drawn, phones do."""

import functools
import http.server
import json
import re
import threading

import pytest

PHONE, DESKTOP = {"width": 390, "height": 844}, {"width": 1300, "height": 900}
LOADED = """async () => {
    for (const image of document.images) image.loading = "eager";
    await Promise.all([...document.images].map((image) => image.complete || new Promise((done) => {
        image.onload = image.onerror = done;
    })));
    await document.fonts.ready;
}"""
PICTURES = "[...document.images].filter((image) => !image.naturalWidth).map((image) => image.src)"
EQUATIONS = """[...document.querySelectorAll("article math")].filter((math) => {
    const box = math.getBoundingClientRect();
    return box.width < 4 || box.height < 4;
}).length"""
WIDER = """[...document.querySelectorAll("article *")].filter((part) => {
    const box = part.getBoundingClientRect();
    return box.width && box.right > innerWidth + 1 &&
        !part.closest(".equation, .md-typeset__scrollwrap, pre, .highlight, .tabbed-set");
}).map((part) => part.outerHTML.slice(0, 120))"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves files, and says nothing."""

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def address(site):
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(site)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()


def watched(page, home: str) -> list[str]:
    """What goes wrong on a page from now on."""
    trouble = []

    def note(wrong: bool, words: str) -> None:
        if wrong:
            trouble.append(words)

    page.on("console", lambda said: note(said.type in ("error", "warning"), said.text))
    page.on("pageerror", lambda error: note(True, str(error)))
    # what is aborted belongs to the page before
    page.on("requestfailed", lambda asked: note("ABORTED" not in asked.failure, f"failed: {asked.url}"))
    page.on("response", lambda answer: note(answer.status >= 400, f"{answer.status}: {answer.url}"))
    page.on("request", lambda asked: note(not asked.url.startswith((home, "data:", "blob:")), f"asks {asked.url}"))
    return trouble


def test_every_page_is_drawn_without_trouble(browser, site, address):
    names = sorted(file.relative_to(site).as_posix() for file in site.rglob("*.html") if file.name != "404.html")
    assert len(names) > 45
    page = browser.new_page(viewport=PHONE)
    trouble, found, equations = watched(page, address), {}, 0
    for name in names:
        trouble.clear()
        page.goto(address + name)
        page.evaluate(LOADED)
        wrong = [f"picture: {one}" for one in page.evaluate(PICTURES)]
        wrong += ["an equation without size"] * bool(page.evaluate(EQUATIONS))
        if page.evaluate("document.documentElement.scrollWidth") > PHONE["width"]:
            wrong.append(f"wider than the screen: {page.evaluate(WIDER)[:3]}")
        equations += page.evaluate('document.querySelectorAll("article math").length')
        if wrong or trouble:
            found[name] = [*wrong, *trouble]
    page.close()
    assert not found
    assert equations > 200


def test_equations_have_their_own_font(browser, address):
    page = browser.new_page(viewport=DESKTOP)
    page.goto(address + "theory/law.html")
    page.evaluate(LOADED)
    assert page.evaluate("document.fonts.check('20px \"STIX Two Math\"')")
    assert page.evaluate("[...document.fonts].some((font) => font.family.includes('STIX') && font.status === 'loaded')")
    wide, high = page.evaluate(
        "(() => { const box = document.querySelector('.equation math').getBoundingClientRect();"
        " return [box.width, box.height]; })()"
    )
    assert wide > 200
    assert high > 25
    page.close()


@pytest.mark.parametrize("disk", [False, True], ids=["server", "disk"])
def test_the_search_finds_a_word(browser, site, address, disk):
    page = browser.new_page(viewport=DESKTOP)
    home = f"{site.as_uri()}/" if disk else address
    trouble = watched(page, home)
    page.goto(home + "tutorial.html")
    page.locator(".md-search__input").click()
    page.keyboard.type("beverloo")
    results = page.locator(".md-search-result__link")
    results.first.wait_for(timeout=15_000)
    assert any("silos.html" in link.get_attribute("href") for link in results.all())
    assert not trouble
    page.close()


@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("wheat", "how-to/sand.html"), ("cement", "how-to/sand.html"), ("calibrate", "how-to/calibrate.html"),
        ("wheat", "how-to/eurocode.html"), ("cement", "how-to/eurocode.html"), ("grain bin", "how-to/eurocode.html"),
        ("grain bin", "how-to/real-size.html"), ("discharge", "how-to/eurocode.html"), ("DXF", "how-to/shape.html"),
        ("hopper", "how-to/shape.html"), ("Janssen", "theory/silos.html"), ("wheat", "reference/solids.html"),
        ("6 m", "how-to/real-size.html"), ("notebook", "how-to/python.html"), ("ParaView", "how-to/paraview.html"),
        ("plugin", "how-to/own-parts.html"), ("measured points", "validation/element-tests.html"),
    ],
)  # fmt: skip
def test_the_words_that_people_use_stand_in_the_page_that_they_look_for(site, words, page):
    index = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))["docs"]
    texts = {one["location"]: f"{one['title']} {one['text']}".replace("\u00a0", " ").lower() for one in index}
    whole = re.compile(rf"\b{re.escape(words.lower())}\b")  # cement is no displacement
    assert any(place.split("#")[0] == page and whole.search(text) for place, text in texts.items())


def test_what_is_wrong_would_be_noticed(browser, tmp_path):
    (tmp_path / "index.html").write_text(
        '<!doctype html><body style="margin:0"><article><div style="width:900px">wide</div><img src="none.png">'
        '<script>console.error("oh")</script></article>'
    )
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(tmp_path)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    home = f"http://127.0.0.1:{server.server_port}/"
    page = browser.new_page(viewport=PHONE)
    trouble = watched(page, home)
    page.goto(home + "index.html")
    page.evaluate(LOADED)
    assert page.evaluate(PICTURES) == [home + "none.png"]
    assert page.evaluate("document.documentElement.scrollWidth") == 900
    assert page.evaluate(WIDER)
    assert "oh" in trouble
    assert any(words.startswith("404") for words in trouble)
    page.close()
    server.shutdown()

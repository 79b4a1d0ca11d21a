"""The site as it is built: links, equations, nothing from elsewhere."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

GENERATED = ("commands", "scenarios", "scene", "sands", "python")


class Page(HTMLParser):
    """Names that can be linked to, and what is linked to."""

    def __init__(self, text: str):
        super().__init__()
        self.names, self.links, self.loaded = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.names |= {found[key] for key in ("id", "name") if found.get(key)}
        if tag == "a" and found.get("href"):
            self.links.append(found["href"])
        if tag in ("img", "script", "source", "video") and found.get("src"):
            self.loaded.append(found["src"])
        if tag == "link" and found.get("href") and "canonical" not in (found.get("rel") or ""):
            self.loaded.append(found["href"])


def broken(site: Path) -> list[str]:
    """Links of a site that lead nowhere."""
    pages = {file: Page(file.read_text(encoding="utf-8")) for file in site.rglob("*.html")}
    found = []
    for file, page in pages.items():
        for link in (*page.links, *page.loaded):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc or file.name == "404.html":
                continue
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            target = target / "index.html" if target.is_dir() else target
            if not target.exists() or (
                parts.fragment and target in pages and unquote(parts.fragment) not in {*pages[target].names, "__top"}
            ):
                found.append(f"{file.relative_to(site)}: {link}")
    return found


def test_every_link_and_anchor_resolves(site):
    assert not broken(site)


def test_a_broken_link_is_noticed(tmp_path):
    (tmp_path / "a.html").write_text('<p id="here"><a href="b.html#gone">x</a><a href="#here">y</a><img src="c.png">')
    (tmp_path / "b.html").write_text('<p id="there">')
    assert broken(tmp_path) == ["a.html: b.html#gone", "a.html: c.png"]


def test_nothing_is_loaded_from_elsewhere(site):
    for file in site.rglob("*.html"):
        for link in Page(file.read_text(encoding="utf-8")).loaded:
            assert not urlsplit(link).netloc, f"{file.relative_to(site)} loads {link}"
    for file in site.rglob("assets/*.css"):
        assert "url(http" not in file.read_text(encoding="utf-8")


def test_equations_are_mathml(site):
    law = (site / "theory" / "law.html").read_text(encoding="utf-8")
    assert law.count("<math") > 40
    for file in site.rglob("*.html"):
        text = re.sub(r"<(code|pre)[ >].*?</\1>", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)
        assert "arithmatex" not in text, file
        assert not re.search(r"\\(frac|boldsymbol|sum|left)\b", text), file


@pytest.mark.parametrize("name", GENERATED)
def test_pages_made_from_the_program_are_there(site, name):
    assert (site / "reference" / f"{name}.html").stat().st_size > 10_000


def test_every_command_and_every_public_name_has_a_place(site):
    import taichi_silo
    from taichi_silo.cli import app, catalogue

    commands = Page((site / "reference" / "commands.html").read_text(encoding="utf-8")).names
    assert {f"taichi-silo-{name}" for name in app.COMMANDS} <= commands
    scenarios = Page((site / "reference" / "scenarios.html").read_text(encoding="utf-8")).names
    assert set(catalogue.scenarios()) <= scenarios
    names = Page((site / "reference" / "python.html").read_text(encoding="utf-8")).names
    wanted = {f"taichi_silo.{module}.{name}" for module, many in taichi_silo.HOME.items() for name in many}
    assert wanted <= names


def test_flags_of_the_program_are_in_the_reference(site):
    text = (site / "reference" / "scenarios.html").read_text(encoding="utf-8")
    for flag in ("--void-ratio", "--outlet-width", "--half-angle", "--characteristic-length", "--no-film"):
        assert f'<code class="flag">{flag}</code>' in text
    assert '<code class="flag">--set</code>' in (site / "reference" / "commands.html").read_text(encoding="utf-8")


def test_the_schema_can_be_loaded(site):
    assert json.loads((site / "reference" / "scene.schema.json").read_text(encoding="utf-8"))["title"] == "Scene"


def test_what_is_not_for_readers_is_not_in_the_site(site):
    assert not (site / "hooks").exists()
    assert not (site / "data").exists()

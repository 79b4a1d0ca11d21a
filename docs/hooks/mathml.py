"""Equations: LaTeX in the pages becomes MathML when the site is built, which browsers draw without any script."""

import html
import re
import unicodedata

from latex2mathml.converter import convert

INLINE = re.compile(r'<span class="arithmatex">\\\((.+?)\\\)</span>', re.DOTALL)
BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.+?)\\\]\s*</div>', re.DOTALL)
BOLD = re.compile(r'<mi mathvariant="bold-italic">(.)</mi>')  # browsers pass over the attribute
STYLE = "MATHEMATICAL BOLD ITALIC"


def on_page_content(content: str, **_) -> str:
    """Every equation of a page as MathML; one that is too wide for its column scrolls in its own box."""
    content = BLOCK.sub(lambda found: f'<div class="equation" tabindex="0">{mathml(found[1], "block")}</div>', content)
    return INLINE.sub(lambda found: mathml(found[1], "inline"), content)


def mathml(latex: str, display: str) -> str:
    """One equation; bold letters are characters of their own."""
    return BOLD.sub(lambda found: f"<mi>{bold(found[1])}</mi>", convert(html.unescape(latex).strip(), display=display))


def bold(letter: str) -> str:
    """The bold italic one of a Latin or Greek letter."""
    size = "CAPITAL" if letter.isupper() else "SMALL"
    return unicodedata.lookup(f"{STYLE} {size} {unicodedata.name(letter).rpartition(' ')[2]}")

"""Equations: LaTeX in the pages becomes MathML when the site is built, which browsers draw without any script."""

import html
import re
import unicodedata

from latex2mathml.converter import convert

INLINE = re.compile(r'<span class="arithmatex">\\\((.+?)\\\)</span>', re.DOTALL)
BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.+?)\\\]\s*</div>', re.DOTALL)
VARIANT = re.compile(r'<mi mathvariant="(bold-italic|script|double-struck)">(.)</mi>')  # browsers pass over these
LETTERS = {  # names of the characters that they are instead
    "bold-italic": "MATHEMATICAL BOLD ITALIC {size} {letter}",
    "script": "SCRIPT {size} {letter}",
    "double-struck": "DOUBLE-STRUCK {size} {letter}",
}
SIGNS = {  # norms and bars that do not grow, accents that sit on their letter, close slashes
    "<mo>&#x02016;</mo>": '<mo stretchy="false">&#x02016;</mo>',
    "<mo>&#x0005E;</mo>": '<mo stretchy="false">&#x002C6;</mo>',
    "&#x000AF;</mo>": "&#x0203E;</mo>",
    "<mo>&#x0007C;</mo>": '<mo stretchy="false">&#x0007C;</mo>',
    "<mo>&#x0002F;</mo>": '<mo lspace="0.1em" rspace="0.1em">&#x0002F;</mo>',
}


def on_page_content(content: str, **_) -> str:
    """Every equation of a page as MathML; one that is too wide for its column scrolls in its own box."""
    content = BLOCK.sub(lambda found: f'<div class="equation" tabindex="0">{mathml(found[1], "block")}</div>', content)
    return INLINE.sub(lambda found: mathml(found[1], "inline"), content)


def mathml(latex: str, display: str) -> str:
    """One equation."""
    found = convert(html.unescape(latex).strip(), display=display)
    for sign, better in SIGNS.items():
        found = found.replace(sign, better)
    return VARIANT.sub(lambda letter: f"<mi>{letter_of(*letter.groups())}</mi>", found)


def letter_of(variant: str, letter: str) -> str:
    """A Latin or Greek letter in another style."""
    size = "CAPITAL" if letter.isupper() else "SMALL"
    plain = unicodedata.name(letter).rpartition(" ")[2]
    return unicodedata.lookup(LETTERS[variant].format(size=size, letter=plain))

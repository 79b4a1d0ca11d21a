"""What is written in the pages: their code blocks."""

import re
import textwrap
from pathlib import Path
from typing import NamedTuple

DOCS = Path(__file__).parents[2] / "docs"
FENCE = re.compile(r"^(?P<indent> *)```(?P<kind>[a-z]+)(?P<title>[^\n]*)\n(?P<text>.*?)^(?P=indent)```$", re.M | re.S)
TITLE = re.compile(r'title="([^"]+)"')


class Block(NamedTuple):
    """A block of code.

    Attributes
    ----------
    page : file of the page below docs/.
    number : of the block on its page.
    kind : language.
    title : name of the file that it stands for; empty if none.
    text : what is in it.

    """

    page: str
    number: int
    kind: str
    title: str
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.number}"


def pages() -> list[Path]:
    """All pages that are written by hand."""
    return sorted(DOCS.rglob("*.md"))


def blocks(*kinds: str) -> list[Block]:
    """All blocks of some languages."""
    found = []
    for page in pages():
        for number, fence in enumerate(FENCE.finditer(page.read_text(encoding="utf-8"))):
            title = TITLE.search(fence["title"])
            name, text = title[1] if title else "", textwrap.dedent(fence["text"])
            found.append(Block(page.relative_to(DOCS).as_posix(), number, fence["kind"], name, text))
    return [block for block in found if block.kind in kinds]


def beside(block: Block, folder: Path) -> None:
    """Write the files that the blocks of a page stand for."""
    for other in blocks("toml", "csv", "python"):
        if other.page == block.page and other.title:
            (folder / other.title).write_text(other.text, encoding="utf-8")

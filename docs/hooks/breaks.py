"""Long names in tables break behind an underscore, and nowhere else."""

import re

CELL = re.compile(r"<td[^>]*>.*?</td>", re.DOTALL)
CODE = re.compile(r"(?<=>)([^<>]*)(?=</code>)")


def on_page_content(content: str, **_) -> str:
    """Places where they may, in the names of all tables."""
    return CELL.sub(lambda cell: CODE.sub(lambda name: name[1].replace("_", "_<wbr>"), cell[0]), content)

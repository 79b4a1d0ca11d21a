"""Docstrings of this project as mkdocstrings reads them.

Here a parameter is `name : what it is`, and a result is a sentence; numpy's style would take both for types.
"""

import re

import griffe

ENTRY = re.compile(r"^(\*{0,2}\w[\w, *]*?) : (.+)$")
SECTIONS = ("Parameters", "Attributes")


class PlainWords(griffe.Extension):
    """Turns the words behind a colon into a description, and gives results the type of the signature."""

    def on_instance(self, *, obj: griffe.Object, **_) -> None:
        """Rewrite its docstring."""
        if obj.docstring is not None:
            returns = str(obj.returns) if getattr(obj, "returns", None) else ""
            obj.docstring.value = rewritten(obj.docstring.value, returns)


def rewritten(text: str, returns: str) -> str:
    """A docstring with descriptions below their names."""
    lines, section, found = text.split("\n"), "", []
    for number, line in enumerate(lines):
        if number + 1 < len(lines) and lines[number + 1].strip("-") == "" and lines[number + 1].startswith("---"):
            section = line.strip()
        entry = ENTRY.match(line)
        if section in SECTIONS and entry:
            found += [entry[1], f"    {entry[2]}"]
        elif section == "Returns" and line.strip("-") and line.strip() != "Returns":
            if found[-1].startswith("---"):
                found.append(returns or "result")
            found.append(f"    {line}")
        else:
            found.append(line)
    return "\n".join(found)

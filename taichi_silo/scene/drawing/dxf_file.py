"""A DXF file as ezdxf reads it, a damaged one at its second try."""

from pathlib import Path
from typing import Any

from taichi_silo.errors import BadInput
from taichi_silo.utils import bounded_reading

LARGEST = 50_000_000  # bytes of a file
DWG = b"AC10"  # with which such a file begins
UNIT = "$INSUNITS"  # in a drawing's header


def opened(file: Path) -> tuple[Any, bool]:
    """The drawing of a file, and whether the file is damaged and was mended.

    Raises BadInput if it cannot be read as a drawing.
    """
    try:
        import ezdxf
        from ezdxf import recover
    except ImportError as error:
        raise BadInput("reading drawings needs ezdxf: install taichi-silo[drawings]") from error
    content = bounded_reading.content(file, "a DXF drawing", LARGEST)
    if content[:4] == DWG:
        raise BadInput(f"{file} cannot be read as a DXF drawing: it is a DWG file; save it as DXF")
    try:
        drawing, mended = ezdxf.readfile(file), False
    except Exception as first:  # noqa: BLE001 - a damaged file makes its readers say anything
        try:
            drawing, _ = recover.readfile(file)
            empty = not any(len(layout) for layout in drawing.layouts)
        except Exception:  # noqa: BLE001
            empty = True
        if empty:
            raise BadInput(f"{file} cannot be read as a DXF drawing: it is none, or damaged") from first
        mended = True
    if UNIT.encode() not in content:
        drawing.header[UNIT] = 0  # the reader's own default says metres
    return drawing, mended

"""VTU files (VTK's unstructured grids) of points with named arrays, each array one zlib block in base64."""

import base64
import sys
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from taichi_silo.utils import atomic_write

LEVEL = 1  # of zlib: the noise of floating-point numbers packs no better with more
KINDS = {"float64": "Float64", "float32": "Float32", "int64": "Int64", "int32": "Int32", "uint8": "UInt8"}
MOST_POINTS, MOST_COMPONENTS = 100_000_000, 9
LONGEST_START = 1000  # bytes, in which an XML file says what else it needs
BLOCKS = ("Points", "PointData")
VERTEX, LINE = 1, 3  # VTK's numbers of cells of one point and of two


def spatial(vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 2) of the plane as (n, 3), which VTK asks for."""
    return np.column_stack([vectors, np.zeros(len(vectors))])


def write(
    file: Path, places: np.ndarray, arrays: dict[str, np.ndarray], units: dict[str, str] | None = None,
    components: Mapping[str, Sequence[str]] | None = None,
) -> None:  # fmt: skip
    """Write points at places (n, 3) [m] as vertices; the file appears when it is complete.

    Parameters
    ----------
    file : its path.
    places : of the points.
    arrays : (n,) or (n, components) by name, whose types stay.
    units : of the arrays, by name, for VTK's key UNITS_LABEL.
    components : names of their components, by name.

    """
    units, components = {"Points": "m"} | (units or {}), components or {}
    count = len(places)
    index = np.arange(count, dtype=np.int32)
    cells: dict[str, np.ndarray] = {
        "connectivity": index,
        "offsets": index + 1,
        "types": np.full(count, VERTEX, np.uint8),
    }
    blocks: dict[str, dict[str, np.ndarray]] = {"PointData": arrays, "Points": {"Points": places}, "Cells": cells}
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    head = (
        f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" byte_order="{order}" '
        'header_type="UInt32" compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>'
        f'<Piece NumberOfPoints="{count}" NumberOfCells="{count}">\n'
    )
    with atomic_write.written(file) as passing, open(passing, "w", encoding="ascii", newline="\n") as stream:
        stream.write(head)
        for block, found in blocks.items():
            stream.write(f"<{block}>")
            for name, values in found.items():
                stream.write(_array(name, values, units.get(name, ""), components.get(name, ())))
            stream.write(f"</{block}>\n")
        stream.write("</Piece></UnstructuredGrid>\n</VTKFile>\n")


def _array(name: str, values: np.ndarray, unit: str, parts: Sequence[str]) -> str:
    """A DataArray: its header (blocks, bytes of a block, of a last partial one, packed bytes) and its packed bytes."""
    values = np.ascontiguousarray(values)
    components = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    components += "".join(f' ComponentName{number}="{part}"' for number, part in enumerate(parts))
    label = f'<InformationKey name="UNITS_LABEL" location="vtkDataArray">{unit}</InformationKey>' if unit else ""
    raw = values.tobytes()
    packed = zlib.compress(raw, LEVEL)
    header = np.array([1, len(raw), 0, len(packed)], np.uint32).tobytes()
    data = base64.b64encode(header) + base64.b64encode(packed)
    kind = KINDS[values.dtype.name]
    return f'<DataArray type="{kind}" Name="{name}"{components} format="binary">{data.decode()}{label}</DataArray>\n'


def read(file: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Places (n, 3) [m] and arrays by name, of such a file or another with binary arrays in zlib blocks.

    Raises OSError, ValueError, KeyError, zlib.error, xml.etree.ElementTree.ParseError if it cannot be read.
    """
    with open(file, "rb") as stream:
        if b"<!DOCTYPE" in stream.read(LONGEST_START):
            raise ValueError(f"{file} defines entities")
    piece = ElementTree.parse(file).getroot().find("UnstructuredGrid/Piece")
    if piece is None:
        raise ValueError(f"{file} holds no piece of an unstructured grid")
    count = int(piece.attrib["NumberOfPoints"])
    places, arrays = (
        {one.attrib["Name"]: _values(one, count) for one in piece.iterfind(f"{block}/*")} for block in BLOCKS
    )
    return places["Points"], arrays


def _values(element, points: int) -> np.ndarray:
    """Values of a DataArray of so many points; what is packed in it is unpacked no further than that."""
    kind, components = np.dtype(element.get("type").lower()), int(element.get("NumberOfComponents", 1))
    room = points * components * kind.itemsize
    if not 0 <= points <= MOST_POINTS or not 1 <= components <= MOST_COMPONENTS:
        raise ValueError(f"{points} points with {components} components")
    text = element.text.strip()
    blocks = int(np.frombuffer(base64.b64decode(text[:8])[:4], np.uint32)[0])
    count = 3 + blocks
    ends = 4 * -(-4 * count // 3)  # of the header: four characters for each three bytes begun
    sizes = np.frombuffer(base64.b64decode(text[:ends]), np.uint32, count)[3:]
    packed, parts, begin = base64.b64decode(text[ends:]), [], 0
    for size in sizes.tolist():
        parts.append(zlib.decompressobj().decompress(packed[begin : begin + size], room + 1))
        begin, room = begin + size, room - len(parts[-1])
        if room < 0:
            raise ValueError("an array is longer than it says")
    if room:
        raise ValueError("an array is shorter than it says")
    values = np.frombuffer(b"".join(parts), kind)
    return values.reshape(-1, components) if components > 1 else values

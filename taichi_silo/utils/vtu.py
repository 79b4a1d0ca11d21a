"""VTU files (VTK's unstructured grids) of points with named arrays, each array in zlib blocks in base64."""

import base64
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import BinaryIO
from xml.etree import ElementTree

import numpy as np

from taichi_silo.utils import atomic_write

LEVEL = 1  # of zlib: the noise of floating-point numbers packs no better with more
BLOCK = 1 << 20  # bytes of an array that are packed at once
KINDS = {"float64": "Float64", "float32": "Float32", "int64": "Int64", "int32": "Int32", "uint8": "UInt8"}
MOST_POINTS, MOST_COMPONENTS = 100_000_000, 9
LONGEST_START = 1000  # bytes, in which an XML file says what else it needs
BLOCKS = ("Points", "PointData")
VERTEX, LINE = 1, 3  # VTK's numbers of cells of one point and of two


def spatial(vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 2) of the plane as (n, 3), which VTK asks for."""
    return np.column_stack([vectors, np.zeros(len(vectors))])


Pieces = Callable[[], Iterable[np.ndarray]]  # gives an array, some rows at a time, each time it is called


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
    whole = {name: _once(values) for name, values in arrays.items()}
    write_pieces(file, len(places), _once(places), whole, units, components)


def write_pieces(
    file: Path, count: int, places: Pieces, arrays: Mapping[str, Pieces], units: dict[str, str] | None = None,
    components: Mapping[str, Sequence[str]] | None = None, synced: bool = True,
) -> None:  # fmt: skip
    """As `write`, from arrays of `count` rows, of which only pieces are there at a time (synced: see `put`)."""
    units, components = {"Points": "m"} | (units or {}), components or {}
    index = np.arange(count, dtype=np.int32)
    cells = {
        "connectivity": _once(index), "offsets": _once(index + 1), "types": _once(np.full(count, VERTEX, np.uint8)),
    }  # fmt: skip
    blocks: dict[str, Mapping[str, Pieces]] = {"PointData": arrays, "Points": {"Points": places}, "Cells": cells}
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    head = (
        f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" byte_order="{order}" '
        'header_type="UInt32" compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>'
        f'<Piece NumberOfPoints="{count}" NumberOfCells="{count}">\n'
    )
    with atomic_write.written(file, synced=synced) as passing, open(passing, "wb") as stream:
        stream.write(head.encode())
        for block, found in blocks.items():
            stream.write(f"<{block}>".encode())
            for name, pieces in found.items():
                _write_array(stream, name, pieces(), count, units.get(name, ""), components.get(name, ()))
            stream.write(f"</{block}>\n".encode())
        stream.write(b"</Piece></UnstructuredGrid>\n</VTKFile>\n")


def _once(values: np.ndarray) -> Pieces:
    """An array as its only piece."""
    return lambda: [values]


def _write_array(
    stream: BinaryIO, name: str, pieces: Iterable[np.ndarray], count: int, unit: str, parts: Sequence[str]
) -> None:
    """A DataArray: its header (blocks, bytes of a block, of a last partial one, packed bytes) and its packed bytes."""
    rest = iter(pieces)
    first = next(rest)
    components = f' NumberOfComponents="{first.shape[1]}"' if first.ndim > 1 else ""
    components += "".join(f' ComponentName{number}="{part}"' for number, part in enumerate(parts))
    label = f'<InformationKey name="UNITS_LABEL" location="vtkDataArray">{unit}</InformationKey>' if unit else ""
    kind = KINDS[first.dtype.name]
    stream.write(f'<DataArray type="{kind}" Name="{name}"{components} format="binary">'.encode())
    size = count * first.dtype.itemsize * (first.shape[1] if first.ndim > 1 else 1)
    blocks = max(1, -(-size // BLOCK))
    begin = stream.tell()
    header = np.array([blocks, min(size, BLOCK), size % BLOCK if blocks > 1 else 0, *[0] * blocks], np.uint32)
    stream.write(base64.b64encode(header.tobytes()))
    left = b""
    for number, block in enumerate(_blocks(first, rest)):
        packed = zlib.compress(block, LEVEL)
        header[3 + number] = len(packed)
        left += packed
        whole = len(left) - len(left) % 3  # base64 writes three bytes in four characters
        stream.write(base64.b64encode(left[:whole]))
        left = left[whole:]
    stream.write(base64.b64encode(left))
    end = stream.tell()
    stream.seek(begin)
    stream.write(base64.b64encode(header.tobytes()))
    stream.seek(end)
    stream.write(f"{label}</DataArray>\n".encode())


def _blocks(first: np.ndarray, rest: Iterator[np.ndarray]) -> Iterator[bytes]:
    """The bytes of pieces of an array, in blocks; at least one, be it empty."""
    held = first.tobytes()
    for piece in rest:
        while len(held) > BLOCK:
            yield held[:BLOCK]
            held = held[BLOCK:]
        held += piece.tobytes()
    for begin in range(0, max(len(held), 1), BLOCK):
        yield held[begin : begin + BLOCK]


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

"""`film_states.bin`: the states that the film of a run shows, packed so that hundreds of them are a few megabytes.

A head, then a piece for each state: `PIECE` and the zlib-compressed differences of the points' whole numbers from what
the two states before let expect (positions move on straight, void ratios stay). Positions are whole numbers of
1/2048 of the points' spacing, void ratios of 2^-16: less than a hundredth of a pixel, and of a shade of colour.
The file only grows, so that a run that dies leaves whole pieces, and at most one that is cut off at the end.
"""

import contextlib
import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.errors import BadInput

NAME = "film_states.bin"
MAGIC = b"taichi-silo film states 1\n"
HEAD = struct.Struct("<ddI")  # a unit of position [m], and of void ratio [-]; CRC-32 of both
PIECE = struct.Struct("<IIddBBHI")  # bytes and CRC-32 of what follows; time [s], displacement [m], flow?, names?, shown
POSITION_UNITS, VOID_RATIO_UNITS = 2048, 65536  # to a spacing, to 1
MOST_POINTS = 100_000_000
STAGES = ("filling", "flow")
FIELDS = ("position", "void_ratio", "identity")  # of the points, that a state shows


class Packing:
    """Packs states one after the other, or unpacks them in the same order.

    Attributes
    ----------
    identity : (n,) of the points of the last state.
    numbers : (n, 3) of it: x, y and void ratio in units.
    motion : (n, 3) by which `numbers` are expected to change until the next state.

    """

    def __init__(self):
        self.identity = np.zeros(0, np.int32)
        self.numbers = self.motion = np.zeros((0, 3), np.int32)

    def pack(self, identity: np.ndarray, numbers: np.ndarray) -> tuple[bool, bytes]:
        """Whether the names of the points are in it, and the bytes of a state of n points: (n,), (n, 3)."""
        identity = identity.astype(np.int32)
        renamed = not np.array_equal(identity, self.identity)
        self._rename(identity)
        rest = numbers.astype(np.int32) - self._expected()
        self._take(rest)
        parts = ([np.diff(identity, prepend=np.int32(0))] if renamed else []) + [*rest.T]
        return renamed, zlib.compress(b"".join(_planes(part) for part in parts), 6)

    def unpack(self, renamed: bool, points: int, packed: bytes) -> None:
        """Read one state, which is then in `identity` and `numbers`; ValueError or zlib.error if it is damaged."""
        rows = 3 + renamed
        unpacker = zlib.decompressobj()
        data = np.frombuffer(unpacker.decompress(packed, 4 * rows * points + 1), np.uint8)
        parts = np.ascontiguousarray(data.reshape(rows, 4, points).transpose(0, 2, 1)).view("<i4")[..., 0]
        if renamed:
            self._rename(np.cumsum(parts[0], dtype=np.int32))
        self._take(parts[rows - 3 :].T)

    def _expected(self) -> np.ndarray:
        return self.numbers + self.motion

    def _take(self, rest: np.ndarray) -> None:
        """Go on to the state that differs by so much from the expected one."""
        numbers = self._expected() + rest
        moved = numbers - self.numbers
        moved[:, 2] = 0
        self.motion, self.numbers = moved, numbers

    def _rename(self, identity: np.ndarray) -> None:
        """Keep what is known of these points, in this order; new points begin at 0."""
        if np.array_equal(identity, self.identity):
            return
        _, here, there = np.intersect1d(identity, self.identity, assume_unique=True, return_indices=True)
        known = np.zeros((2, len(identity), 3), np.int32)
        known[:, here] = self.numbers[there], self.motion[there]
        self.identity, (self.numbers, self.motion) = identity, known


def _planes(values: np.ndarray) -> bytes:
    """The four bytes of all numbers one after the other, which packs better: the higher ones hardly differ."""
    return np.ascontiguousarray(values, "<i4").view(np.uint8).reshape(-1, 4).T.tobytes()


def head(spacing_m: float) -> tuple[bytes, np.ndarray]:
    """The first bytes of a file for points of such a spacing, and the units (3,) of its numbers."""
    units = spacing_m / POSITION_UNITS, 1.0 / VOID_RATIO_UNITS
    return MAGIC + HEAD.pack(*units, zlib.crc32(struct.pack("<dd", *units))), np.array([units[0], *units])


def piece(packing: Packing, units: np.ndarray, points: dict, time_s: float, stage: str, displacement_m: float,
          shown: int) -> bytes:  # fmt: skip
    """The bytes of a state that is shown in so many frames; points that are not finite are left out."""
    numbers = np.column_stack([points["position"], points["void_ratio"]])
    numbers /= units
    sound = (np.abs(numbers) < 2**29).all(axis=1)  # of nan, too
    renamed, packed = packing.pack(points["identity"][sound], np.rint(numbers[sound]))
    rest = PIECE.pack(0, 0, time_s, displacement_m, STAGES.index(stage), renamed, shown, int(sound.sum()))[8:] + packed
    return struct.pack("<II", len(packed), zlib.crc32(rest)) + rest


class FilmStates:
    """The states of a file, read one at a time; also of a run that goes on or was cut off.

    Attributes
    ----------
    index : a row a state: stage, time_s, displacement_m, and the number of frames that show it.

    Raises
    ------
    BadInput
        if the file is no such file, or is damaged.

    """

    def __init__(self, file: str | os.PathLike):
        file = Path(file)
        self.file, self.pieces, rows = file, [], []
        with self._understood(), open(file, "rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise ValueError("it begins otherwise")
            *units, crc = HEAD.unpack(stream.read(HEAD.size))
            if zlib.crc32(struct.pack("<dd", *units)) != crc:
                raise ValueError("a checksum does not fit")
            self.units = np.array(units)[[0, 0, 1]]
            size, place = file.stat().st_size, stream.tell()
            while place + PIECE.size <= size:
                stream.seek(place)
                length, crc, time, displacement, flow, renamed, shown, points = PIECE.unpack(stream.read(PIECE.size))
                if points > MOST_POINTS or not np.isfinite([time, displacement]).all():
                    raise ValueError("no state is like that")
                if place + PIECE.size + length > size:
                    break  # it is being written
                self.pieces.append((place, length, crc, renamed > 0, points))
                rows.append((STAGES[flow], time, displacement, shown))
                place += PIECE.size + length
        self.index = pd.DataFrame(rows, columns=["stage", "time_s", "displacement_m", "shown"])
        self._begin()

    @contextlib.contextmanager
    def _understood(self) -> Iterator[None]:
        """Turn what a damaged file leads to into BadInput."""
        try:
            yield
        except (OSError, ValueError, LookupError, struct.error, zlib.error) as error:
            raise BadInput(
                f"{self.file} is damaged: {error}; remove it, and films are drawn from the snapshots"
            ) from error

    def _begin(self) -> None:
        self.packing, self.number = Packing(), -1

    def state(self, number: int) -> dict[str, np.ndarray]:
        """Of a row of the index: `identity`, `position` (n, 2) [m], `velocity` (n, 2) [m/s] since the state before
        and `void_ratio` of the points. Going on to a later row is cheap.
        """
        if number < self.number:
            self._begin()
        with self._understood(), open(self.file, "rb") as stream:
            while self.number < number:
                place, length, crc, renamed, points = self.pieces[self.number + 1]
                stream.seek(place + 8)
                rest = stream.read(PIECE.size - 8 + length)
                if zlib.crc32(rest) != crc:
                    raise ValueError("a checksum does not fit")
                self.packing.unpack(renamed, points, rest[PIECE.size - 8 :])
                self.number += 1
        times = self.index["time_s"].to_numpy()
        since = times[number] - times[number - 1] if number else np.inf
        values, moved = self.packing.numbers * self.units, self.packing.motion[:, :2] * self.units[:2]
        return {
            "identity": self.packing.identity.astype(np.int64), "position": values[:, :2],
            "velocity": moved / max(since, 1e-12), "void_ratio": values[:, 2],
        }  # fmt: skip

    def last_packing(self) -> Packing:
        """What packs the states that come after those of the file."""
        if self.pieces:
            self.state(len(self.pieces) - 1)
        return self.packing

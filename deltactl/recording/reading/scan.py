"""MCAP records in file order, as far as they go: a file cut anywhere is read up to the cut."""

from __future__ import annotations

import contextlib
import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.channels import MAGIC

_PIECE_BYTES = 2**20
_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_MAXIMUM_RECORD_BYTES = 2**28
"""A longer record is damage; it must not make a reader ask for that much memory."""
_MAXIMUM_CHUNK_BYTES = 2**26
"""Size of one chunk, unpacked; ours have about 30 kB, other writers' some MB."""
_NO_OPCODE = 0
"""The format has none such: it is what a hole in a sparse file, or a disk that failed, reads as."""
_READ = (Opcode.CHUNK, Opcode.CHANNEL, Opcode.MESSAGE)
"""Records whose content is looked at; others are passed over unread."""
_TIMES = struct.Struct("<QQQ")
"""How a chunk begins: its first and last time, and the bytes that it unpacks to."""
STRETCHES = 12
"""So many, evenly spread, are read of a recording that is too long to be read whole."""
_SLACK_BYTES, _MAXIMUM_RATIO = 2**23, 100
"""All chunks together may unpack to so much, and to so many times what they take in the file:
ours have 5 to 15 times. A bomb of a few kB may not become gigabytes, or hours of parsing."""


@dataclass(slots=True)
class Scan:
    """What a file holds: its channels, its messages chunk by chunk, and whether it is whole.

    `channels` grows while `chunks` is read; `damage` is complete when it has been read.
    """

    path: Path
    channels: dict[int, records.Channel] = field(default_factory=dict)
    complete: bool = False
    damage: list[str] = field(default_factory=list)
    share: float = 1.0
    """How much of the messages is read; less than 1 where `most_bytes` holds them."""
    most_bytes: int | None = None
    _packed: int = 0
    _unpacked: int = 0

    def chunks(self) -> Iterator[dict[int, list[bytes]]]:
        """Messages by channel, one dictionary a chunk.

        Raises RecordingError when the file cannot be read or is no MCAP file.
        """
        try:
            with self.path.open("rb") as stream:
                _check_magic(self.path, stream.read(len(MAGIC)))
                left_out = self._left_out(stream)
                stream.seek(len(MAGIC))
                yield from self._read(stream, left_out)
        except OSError as error:
            raise RecordingError(f"{self.path}: cannot be read ({error.strerror})") from error

    def _left_out(self, stream: BinaryIO) -> frozenset[int]:
        """Where the chunks begin that are not read, so that the others have `most_bytes`."""
        if self.most_bytes is None:
            return frozenset()
        starts, sizes = [], []
        while len(head := stream.read(_HEAD.size)) == _HEAD.size:
            opcode, length = _HEAD.unpack(head)
            ends = opcode in (Opcode.DATA_END, Opcode.FOOTER, _NO_OPCODE)
            if ends or length > _MAXIMUM_RECORD_BYTES:
                break
            begin = stream.read(min(length, _TIMES.size))
            if opcode == Opcode.CHUNK and len(begin) == _TIMES.size:
                starts.append(stream.tell() - len(begin) - len(head))
                sizes.append(min(_TIMES.unpack(begin)[2], _MAXIMUM_CHUNK_BYTES))
            stream.seek(length - len(begin), 1)
        kept = _spread(sizes, self.most_bytes)
        self.share = sum(map(sizes.__getitem__, kept)) / max(sum(sizes), 1) if sizes else 1.0
        return frozenset(starts) - {starts[number] for number in kept}

    def _read(self, stream: BinaryIO, left_out: frozenset[int]) -> Iterator[dict[int, list[bytes]]]:
        size = os.fstat(stream.fileno()).st_size
        while head := stream.read(_HEAD.size):
            start = stream.tell() - len(head)
            if len(head) < _HEAD.size:
                break
            opcode, length = _HEAD.unpack(head)
            if length > _MAXIMUM_RECORD_BYTES or opcode == _NO_OPCODE:
                self.damage.append(f"damaged at byte {start}; what follows is not read")
                return
            end = start + _HEAD.size + length
            if opcode in (Opcode.DATA_END, Opcode.FOOTER) and end <= size:
                # The summary repeats what the data section has said.
                self.complete = True
                return
            if opcode not in _READ or start in left_out:
                self._packed += length if start in left_out else 0
                stream.seek(min(end, size))
                if end > size:
                    break
                continue
            body = stream.read(length)
            if (messages := self._messages(opcode, body, length, start)) is not None:
                yield messages
            if len(body) < length:
                break
        self.damage.append(f"cut off at byte {stream.tell()}; read up to there")

    def _messages(
        self, opcode: int, body: bytes, length: int, start: int
    ) -> dict[int, list[bytes]] | None:
        try:
            if opcode == Opcode.CHUNK:
                data = _chunk_data(body, len(body) == length, self._room(len(body)))
                self._unpacked += len(data)
                return self._split(data)
            if opcode in (Opcode.CHANNEL, Opcode.MESSAGE) and len(body) == length:
                return self._split(_HEAD.pack(opcode, length) + body)
        except _UNREADABLE as error:
            self.damage.append(f"damaged at byte {start} ({error}); that piece is left out")
        return None

    def _room(self, packed: int) -> int:
        """How much the next chunk may unpack to."""
        self._packed += packed
        left = _SLACK_BYTES + _MAXIMUM_RATIO * self._packed - self._unpacked
        return min(left, _MAXIMUM_CHUNK_BYTES)

    def _split(self, data: bytes) -> dict[int, list[bytes]]:
        """Messages among uncompressed records, up to the last whole one."""
        found: dict[int, list[bytes]] = {}
        position, size = 0, len(data)
        while position + _HEAD.size <= size:
            opcode, length = _HEAD.unpack_from(data, position)
            if opcode == _NO_OPCODE:
                raise RecordingError("holds nothing from there on")
            position += _HEAD.size
            if position + length > size:
                break
            if opcode == Opcode.MESSAGE:
                channel_id = _MESSAGE.unpack_from(data, position)[0]
                payload = data[position + _MESSAGE.size : position + length]
                found.setdefault(channel_id, []).append(payload)
            elif opcode == Opcode.CHANNEL:
                channel = records.Channel.read(_stream(data[position : position + length]))
                self.channels[channel.id] = channel
            position += length
        return found


_UNREADABLE = (
    McapError,
    RecordingError,
    zstandard.ZstdError,
    RuntimeError,
    struct.error,
    ValueError,
    OverflowError,
    MemoryError,
)
"""What damaged bytes make the decoders raise (lz4 raises RuntimeError, a length of 2**63 bytes
OverflowError)."""


def begins_as_mcap(stream: BinaryIO) -> bool:
    """Whether a stream, at its beginning, has what every MCAP file begins with; goes back there."""
    head = stream.read(len(MAGIC) + _HEAD.size)
    stream.seek(0)
    if not head.startswith(MAGIC) or len(head) < len(MAGIC) + _HEAD.size:
        return False
    opcode, length = _HEAD.unpack_from(head, len(MAGIC))
    return bool(opcode == Opcode.HEADER and length <= _MAXIMUM_RECORD_BYTES)


def refuse_holes(path: Path, stream: BinaryIO) -> None:
    """Raise RecordingError for what a library would read for minutes; goes back to the beginning.

    That is a file with a hole, whose bytes are zero and count as records, and one with messages
    longer than any.
    """
    size = os.fstat(stream.fileno()).st_size
    stream.seek(len(MAGIC))
    while len(head := stream.read(_HEAD.size)) == _HEAD.size:
        start = stream.tell() - len(head)
        opcode, length = _HEAD.unpack(head)
        if opcode in (Opcode.DATA_END, Opcode.FOOTER):
            break
        if opcode == _NO_OPCODE or (opcode in _READ and length > _MAXIMUM_RECORD_BYTES):
            raise RecordingError(f"{path}: is damaged at byte {start}; make a copy up to there")
        if stream.tell() + length > size:
            break
        stream.seek(length, 1)
    stream.seek(0)


def _spread(sizes: list[int], most: int) -> list[int]:
    """Numbers of the chunks to read: the first, which says whose they are, and STRETCHES of them
    spread evenly, which together have no more than `most` bytes.
    """
    total = sum(sizes)
    if total <= most:
        return list(range(len(sizes)))
    starts = [k * (total - most / STRETCHES) / (STRETCHES - 1) for k in range(STRETCHES)]
    kept, before = [0], sizes[0]
    for number, size in enumerate(sizes[1:], 1):
        if any(start <= before and before + size <= start + most / STRETCHES for start in starts):
            kept.append(number)
        before += size
    return kept


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


def _check_magic(path: Path, head: bytes) -> None:
    if not head:
        raise RecordingError(f"{path}: is empty; nothing was recorded")
    if head != MAGIC:
        raise RecordingError(f"{path}: is not an MCAP recording (it starts with {head!r})")


def _chunk_data(body: bytes, whole: bool, most: int) -> bytes:
    """The records inside a chunk; of a chunk that was cut, what can still be unpacked."""
    chunk = records.Chunk.read(_stream(body))
    if chunk.uncompressed_size > most:
        raise RecordingError("unpacks to more than a recording holds")
    data = _unpack(chunk.compression, chunk.data, chunk.uncompressed_size)
    if whole and chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise RecordingError("wrong checksum")
    return data


def _unpack(compression: str, data: bytes, most: int) -> bytes:
    """Unpack up to the size that the chunk names; what comes after it is not looked at."""
    if compression == "":
        return data
    if compression == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(BytesIO(data)) as stream:
            return _all_of(stream, most)
    if compression == "lz4":
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=most))
    raise RecordingError(f"unknown compression {compression!r}")


def _all_of(stream: BinaryIO, most: int) -> bytes:
    """What can be read, up to a size; a stream that breaks off gives what it has."""
    parts: list[bytes] = []
    with contextlib.suppress(zstandard.ZstdError):
        while most > 0 and (part := stream.read(min(most, _PIECE_BYTES))):
            parts.append(part)
            most -= len(part)
    return b"".join(parts)

"""An MCAP file that is readable after every chunk and complete after `finish`.

The official writer keeps an index of every chunk in memory and cannot go on after a failed
write; this one spills its index to disk and can still finish a file whose last chunk did not
fit. Records are those of the MCAP specification, built by the official library.
"""

from __future__ import annotations

import struct
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode

from deltactl.recording.format.channels import CHANNEL_IDS, MAGIC, WRITTEN
from deltactl.recording.writing.append_file import AppendFile

_MESSAGE = struct.Struct("<BQHIQQ")
"""Opcode, length, channel, sequence, log time, publish time (MCAP specification, op 0x05)."""
_MESSAGE_OPCODE = 0x05
_HEAD_BYTES = 22
_INDEX_ENTRY = struct.Struct("<QQ")


class McapChunk:
    """Messages of about half a second; becomes one chunk."""

    __slots__ = ("born_s", "data", "first_ns", "index", "last_ns")

    def __init__(self, born_s: float):
        self.born_s = born_s
        self.data = bytearray()
        self.index: dict[int, bytearray] = {}
        """Per channel: log time and offset of every message, as MCAP's MessageIndex wants them."""
        self.first_ns = 2**63
        self.last_ns = 0

    def add(self, channel_id: int, sequence: int, log_ns: int, payload: bytes) -> None:
        """Append one message."""
        entries = self.index.setdefault(channel_id, bytearray())
        entries += _INDEX_ENTRY.pack(log_ns, len(self.data))
        self.data += _MESSAGE.pack(
            _MESSAGE_OPCODE, _HEAD_BYTES + len(payload), channel_id, sequence, log_ns, log_ns
        )
        self.data += payload
        self.first_ns = min(self.first_ns, log_ns)
        self.last_ns = max(self.last_ns, log_ns)

    @property
    def span_ns(self) -> int:
        """Run time between the earliest and the latest message."""
        return max(0, self.last_ns - self.first_ns)

    def messages(self) -> int:
        """How many messages it holds."""
        return sum(len(entries) for entries in self.index.values()) // _INDEX_ENTRY.size


COMPRESSION = "zstd"
_SPILL_BYTES = 4 * 2**20
"""The chunk index stays in memory up to this size: about two hours."""
_COPY_BYTES = 2**20


@dataclass(frozen=True, slots=True)
class Attachment:
    """A text file that travels with the recording."""

    name: str
    text: str


def record_bytes(record: Any) -> bytes:
    """One MCAP record as it is in the file."""
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


class Container:
    """Writes schemas, chunks and, at the end, the summary. Raises OSError when the disk does."""

    def __init__(self, file: AppendFile, library: str):
        self._file = file
        self._compressor = zstandard.ZstdCompressor(level=1)
        self._chunk_index = tempfile.SpooledTemporaryFile(  # noqa: SIM115 - lives with the file
            max_size=_SPILL_BYTES, dir=str(file.path.parent)
        )
        self._attachments: list[records.AttachmentIndex] = []
        self._metadata: list[records.MetadataIndex] = []
        self._counts = dict.fromkeys(CHANNEL_IDS.values(), 0)
        self._chunks = 0
        self._first_ns = 2**63
        self._last_ns = 0
        # Schemas and channels are outside the chunks too: a reader needs no chunk to know them.
        head = [MAGIC, record_bytes(records.Header(profile="", library=library))]
        file.append(b"".join([*head, *_schemas(), *_channels()]))

    def add_metadata(self, name: str, facts: dict[str, str]) -> None:
        """Store short facts under a name."""
        data = record_bytes(records.Metadata(name=name, metadata=facts))
        index = records.MetadataIndex(offset=self._file.size, length=len(data), name=name)
        self._file.append(data)
        self._metadata.append(index)

    def add_attachment(self, attachment: Attachment, log_ns: int) -> None:
        """Store a text file."""
        text = attachment.text.encode(errors="replace")
        what: dict[str, Any] = {
            "log_time": log_ns,
            "create_time": log_ns,
            "name": attachment.name,
            "media_type": "text/plain",
        }
        data = record_bytes(records.Attachment(**what, data=text))
        index = records.AttachmentIndex(
            **what, offset=self._file.size, length=len(data), data_size=len(text)
        )
        self._file.append(data)
        self._attachments.append(index)

    def add_chunk(self, block: McapChunk) -> None:
        """Store a block with its message index, wholly or not at all."""
        packed = self._compressor.compress(block.data)
        chunk = record_bytes(
            records.Chunk(
                compression=COMPRESSION,
                data=packed,
                message_start_time=block.first_ns,
                message_end_time=block.last_ns,
                uncompressed_crc=zlib.crc32(block.data),
                uncompressed_size=len(block.data),
            )
        )
        start = self._file.size
        offsets, index = _message_index(block, start + len(chunk))
        self._file.append(chunk + index)
        entry = records.ChunkIndex(
            message_start_time=block.first_ns,
            message_end_time=block.last_ns,
            chunk_start_offset=start,
            chunk_length=len(chunk),
            message_index_offsets=offsets,
            message_index_length=len(index),
            compression=COMPRESSION,
            compressed_size=len(packed),
            uncompressed_size=len(block.data),
        )
        try:
            self._chunk_index.write(record_bytes(entry))
        except OSError:
            self._file.truncate(start)
            raise
        self._count(block)

    def finish(self) -> None:
        """Write the summary; on failure the file goes back to its last chunk, readable."""
        data_end = self._file.size
        try:
            self._write_summary()
        except OSError:
            self._file.truncate(data_end)
            raise
        finally:
            self._chunk_index.close()

    def _count(self, block: McapChunk) -> None:
        self._chunks += 1
        self._first_ns = min(self._first_ns, block.first_ns)
        self._last_ns = max(self._last_ns, block.last_ns)
        for channel_id, entries in block.index.items():
            self._counts[channel_id] += len(entries) // 16

    def _write_summary(self) -> None:
        self._file.append(record_bytes(records.DataEnd(data_section_crc=0)))
        start = self._file.size
        crc = 0
        groups: list[records.SummaryOffset] = []
        for opcode, parts in self._summary_groups():
            group_start = self._file.size
            for part in parts:
                self._file.append(part)
                crc = zlib.crc32(part, crc)
            length = self._file.size - group_start
            groups.append(records.SummaryOffset(opcode, group_start, length))
        offsets_start = self._file.size
        offsets = b"".join(record_bytes(group) for group in groups if group.group_length)
        footer_head = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offsets_start)
        crc = zlib.crc32(footer_head, zlib.crc32(offsets, crc))
        footer = records.Footer(start, offsets_start, crc)
        self._file.append(offsets + record_bytes(footer) + MAGIC)

    def _summary_groups(self) -> Iterator[tuple[int, Iterator[bytes]]]:
        yield Opcode.SCHEMA, iter(_schemas())
        yield Opcode.CHANNEL, iter(_channels())
        yield Opcode.STATISTICS, iter([record_bytes(self._statistics())])
        yield Opcode.CHUNK_INDEX, self._spilled()
        yield (
            Opcode.ATTACHMENT_INDEX,
            (record_bytes(attachment) for attachment in self._attachments),
        )
        yield Opcode.METADATA_INDEX, (record_bytes(one) for one in self._metadata)

    def _spilled(self) -> Iterator[bytes]:
        self._chunk_index.seek(0)
        while part := self._chunk_index.read(_COPY_BYTES):
            yield part

    def _statistics(self) -> records.Statistics:
        return records.Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(WRITTEN),
            channel_message_counts=self._counts,
            chunk_count=self._chunks,
            message_count=sum(self._counts.values()),
            message_end_time=self._last_ns,
            message_start_time=self._first_ns if self._chunks else 0,
            metadata_count=len(self._metadata),
            schema_count=len(_schema_ids()),
        )


def _message_index(block: McapChunk, offset: int) -> tuple[dict[int, int], bytes]:
    """MessageIndex records of a block, and the place of each in the file."""
    offsets: dict[int, int] = {}
    data = bytearray()
    for channel_id, entries in block.index.items():
        offsets[channel_id] = offset + len(data)
        data += struct.pack(
            "<BQHI", Opcode.MESSAGE_INDEX, 6 + len(entries), channel_id, len(entries)
        )
        data += entries
    return offsets, bytes(data)


def _schema_ids() -> dict[str, int]:
    names = dict.fromkeys(channel.schema_name for channel in WRITTEN)
    return {name: number for number, name in enumerate(names, start=1)}


def _schemas() -> list[bytes]:
    by_name = {channel.schema_name: channel for channel in WRITTEN}
    return [
        record_bytes(
            records.Schema(
                id=number,
                name=name,
                encoding="jsonschema",
                data=by_name[name].json_schema(),
            )
        )
        for name, number in _schema_ids().items()
    ]


def _channels() -> list[bytes]:
    ids = _schema_ids()
    return [
        record_bytes(
            records.Channel(
                id=CHANNEL_IDS[channel.topic],
                topic=channel.topic,
                message_encoding="json",
                metadata={},
                schema_id=ids[channel.schema_name],
            )
        )
        for channel in WRITTEN
    ]

"""Logs of others: MCAP files, ROS 1 and 2 bags, by topic and field, laid on one topic's times.

Columns are called `/topic.field`, as `/joint_states.position.elbow`; lists by place or, where the
message has a list `name` as long, by those names. A time stamp of sec and nanosec is one column.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, MutableMapping, MutableSequence
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.extras import needs
from deltactl.recording.reading.scan import refuse_holes
from deltactl.recording.tables.flat import AnyArray

LOG_TIME = "log_time"
"""Column of when the messages were logged, in seconds since the first one."""
ROS_1 = ".bag"
"""A ROS 1 bag is one file."""
LONGEST_LIST = 64
DECODED = "ROS 1 and 2, protobuf, JSON"
_PLAIN = (int, float, bool, np.integer, np.floating)
Series = tuple[list[float], list[float]]


def is_log(path: Path) -> bool:
    """Whether a path is an MCAP file, a ROS 1 bag, or a ROS 2 bag: its folder or its database."""
    return path.suffix in (".mcap", ".db3", ROS_1) or (path / "metadata.yaml").is_file()


def read_log(path: Path, base: str | None = None) -> dict[str, AnyArray]:
    """All numbers of a log as columns on the times of one topic, shape (n,) each.

    base: topic whose messages are the rows; without it the one with most. Others are interpolated
    between their messages, and NaN before the first and after the last. Raises RecordingError.
    """
    topics: dict[str, dict[str, Series]] = {}
    messages = _of_mcap(path) if path.suffix == ".mcap" else _of_bag(path)
    try:
        for topic, time_ns, message in messages:
            fields = topics.setdefault(topic, {})
            for name, value in _flat(message, ""):
                times, values = fields.setdefault(name, ([], []))
                times.append(time_ns * 1e-9)
                values.append(value)
    except RecordingError:
        raise
    except Exception as error:  # decoders raise nearly anything for a damaged file
        raise RecordingError(f"{path}: is not a readable log ({error})") from error
    topics = {topic: fields for topic, fields in topics.items() if fields}
    if not topics:
        raise RecordingError(
            f"{path}: holds no messages with numbers that can be decoded ({DECODED} can); export"
            " what you need as CSV, from PlotJuggler or Foxglove"
        )
    rows = base or max(topics, key=lambda topic: max(len(t) for t, _ in topics[topic].values()))
    if rows not in topics:
        raise RecordingError(f"{path}: has no topic {rows}; it has {', '.join(sorted(topics))}")
    return _table(topics, rows)


def topic_of(column: str) -> str | None:
    """The topic of a column's name, None where it is none."""
    return column.split(".", 1)[0] if column.startswith("/") and "." in column else None


def _table(topics: dict[str, dict[str, Series]], rows: str) -> dict[str, AnyArray]:
    times = np.array(max((times for times, _ in topics[rows].values()), key=len))
    table: dict[str, AnyArray] = {LOG_TIME: times - times[0]}
    for topic, fields in topics.items():
        for name, (at, values) in fields.items():
            own = topic == rows and len(at) == len(times)
            column = np.array(values) if own else _between(times, np.array(at), np.array(values))
            table[f"{topic}.{name}"] = column
    return table


def _between(times: AnyArray, at: AnyArray, values: AnyArray) -> AnyArray:
    order = np.argsort(at, kind="stable")
    return np.interp(times, at[order], values[order], left=np.nan, right=np.nan)


def _flat(value: Any, name: str) -> Iterator[tuple[str, float]]:
    """The numbers of a message, whatever decoder it came from."""
    if isinstance(value, _PLAIN):
        yield name, float(value)
        return
    if isinstance(value, (list, tuple, np.ndarray)):
        if len(value) <= LONGEST_LIST:
            for place, inner in enumerate(value):
                yield from _flat(inner, f"{name}.{place}")
        return
    fields = _fields(value)
    stamp = {key.lstrip("_") for key in fields}
    if stamp in ({"sec", "nanosec"}, {"secs", "nsecs"}, {"seconds", "nanos"}):
        whole, part = (float(fields[key]) for key in sorted(fields, reverse=True))
        yield name, whole + 1e-9 * part
        return
    labels: Any = fields.get("name")
    for key, inner in fields.items():
        below = f"{name}.{key}" if name else key
        if _labelled(labels, inner):
            for label, one in zip(labels, inner, strict=True):
                yield from _flat(one, f"{below}.{label}")
        else:
            yield from _flat(inner, below)


def _labelled(labels: Any, values: Any) -> bool:
    known = isinstance(labels, list) and all(isinstance(label, str) for label in labels)
    alike = isinstance(values, (list, tuple, np.ndarray)) and values is not labels
    return bool(known and alike and labels and len(values) == len(labels))


def _fields(value: Any) -> dict[str, Any]:
    if isinstance(value, dict):
        return value
    if hasattr(value, "DESCRIPTOR"):
        return dict(_of_protobuf(value))
    names = getattr(value, "__slots__", None) or getattr(value, "__dataclass_fields__", None)
    if names is None or isinstance(value, (str, bytes)):
        return {}
    return {key.lstrip("_"): getattr(value, key) for key in names if not key.startswith("__")}


def _of_protobuf(message: Any) -> Iterator[tuple[str, Any]]:
    """Fields of a protobuf message but for messages that are not there, which may be of its own
    kind without end.
    """
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        if isinstance(value, MutableSequence):
            yield field.name, list(value)
        elif field.message_type is None or (
            not isinstance(value, MutableMapping) and message.HasField(field.name)
        ):
            yield field.name, value


def _of_mcap(path: Path) -> Iterator[tuple[str, int, Any]]:
    """Messages of an MCAP file: ROS 2 (CDR), protobuf and JSON; others are passed over."""
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    with needs("diagnosis", "reading MCAP of others"):
        from mcap_protobuf.decoder import DecoderFactory as OfProtobuf
        from mcap_ros2.decoder import DecoderFactory as OfRos

    try:
        with path.open("rb") as stream:
            refuse_holes(path, stream)
            factories, decoders = (OfRos(), OfProtobuf()), dict[int, Any]()
            for schema, channel, message in make_reader(stream).iter_messages():
                if channel.message_encoding == "json":
                    yield channel.topic, message.log_time, json.loads(message.data)
                    continue
                if channel.id not in decoders:
                    found = (
                        factory.decoder_for(channel.message_encoding, schema)
                        for factory in factories
                    )
                    decoders[channel.id] = next(filter(None, found), None)
                if decoders[channel.id] is not None:
                    yield channel.topic, message.log_time, decoders[channel.id](message.data)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from error
    except McapError as error:
        raise RecordingError(f"{path}: is not a whole MCAP file ({error})") from error


def _of_bag(path: Path) -> Iterator[tuple[str, int, Any]]:
    """Messages of a ROS 2 bag, or of a ROS 1 bag, which brings its own definitions."""
    with needs("diagnosis", "reading ROS bags"):
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore

    bag = path if path.is_dir() or path.suffix == ROS_1 else path.parent
    if bag.is_dir() and not (bag / "metadata.yaml").is_file():
        raise RecordingError(f"{path}: a ROS 2 bag has a metadata.yaml beside it; there is none")
    usual = get_typestore(Stores.ROS2_HUMBLE)
    with AnyReader([bag], default_typestore=usual) as reader:
        for connection, time_ns, data in reader.messages():
            yield connection.topic, time_ns, reader.deserialize(data, connection.msgtype)

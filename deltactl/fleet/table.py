"""All answers as one Parquet table: a row a size found, and one for a recording without any."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from deltactl.fleet.book import Row
from deltactl.foundation.plain_file import whole_file

NUMBERS = ("false_alarm_p", "rms_before", "rms_after", "noise_floor", "seconds", "value", "low",
           "high", "probability", "alone", "share")  # fmt: skip
TEXTS = ("recording", "robot", "verdict", "error", "effect", "named", "component", "parameter",
         "unit", "sisters", "rather")  # fmt: skip
SCHEMA = pa.schema(
    [("time", pa.timestamp("ms", tz="UTC"))]
    + [(name, pa.string()) for name in TEXTS]
    + [(name, pa.float64()) for name in NUMBERS]
)


def flat_rows(rows: list[Row]) -> Iterator[Row]:
    """One row a size found; one of a recording where nothing was found, or that is bad."""
    for row in rows:
        head = {name: row.get(name) for name in (*TEXTS, *NUMBERS)}
        head["time"] = int(row["time_s"] * 1e3) if "time_s" in row else None
        for finding in row.get("findings") or [{}]:
            yield head | {name: finding.get(name) for name in (*TEXTS, *NUMBERS) if name in finding}


def write_table(rows: list[Row], path: Path) -> None:
    """Write the table; an earlier one is replaced whole."""
    table = pa.Table.from_pylist(list(flat_rows(rows)), schema=SCHEMA)
    with whole_file(path) as out:
        pq.write_table(table, out, compression="zstd")

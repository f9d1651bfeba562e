"""An episode as an MCAP file of JSON messages, which Foxglove and PlotJuggler open as it is."""

from __future__ import annotations

import heapq
import io
import json
import os
from collections.abc import Iterator, Mapping
from operator import itemgetter
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray

from thenar.hand.driver import COMMANDS
from thenar.hand.episode import Episode
from thenar.hand.world import ELEMENTS
from thenar.io.files import atomic_write
from thenar.runtime.record import Entry

__all__ = ["TOPICS", "write_mcap"]

_FINGER = ("force_x", "force_z", "acceleration_x", "acceleration_z", "position_x", "position_z", "pitch")
_PAD = {name: tuple(f"{name}_{k}" for k in range(ELEMENTS)) for name in ("normal", "shear")}

TOPICS: Mapping[str, Mapping[str, str | tuple[str, ...]]] = {
    "/finger_1": {name: f"{name}_1" for name in _FINGER},
    "/finger_2": {name: f"{name}_2" for name in _FINGER},
    "/pad": _PAD,
    "/command": {name: name for name in COMMANDS},
}
"""Topic -> field of its messages -> the channel of the recording, or the channels of an array, that it shows."""

_TRUTH = ("height_m", "aside_m", "tilt_rad", "on_table", "slid_1_m", "slid_2_m")
_UNITS = {"force": "N", "acceleration": "m/s²", "position": "m", "pitch": "rad", "normal": "N", "shear": "N"}
_UNITS |= {"grip": "N", "lift": "m", "slip": "share of the pad's elements", "height": "m", "aside": "m", "tilt": "rad"}
_UNITS |= {"slid": "m along the plate, median of the elements", "on": "1: yes, 0: no"}
_MS = 1_000_000  # ns
_TEXT, _COUNT = {"type": "string"}, {"type": "integer"}
_READING = {"type": ["number", "null"]}
_TEXTS = {"type": "array", "items": _TEXT}
_ENTRY: Mapping[str, Any] = {
    "kind": _TEXT,
    "t": {"type": "number", "description": "s"},
    "event": _TEXT,
    "plant": _TEXT,
    "plant_state": _COUNT,
    "supervisor_state": _COUNT,
    "enabled": _TEXTS,
    "chosen_by": _TEXT,
    "message": _TEXT,
    "why": _TEXT,
    "policy": _TEXT,
    "outcome": _TEXT,
    "violations": _TEXTS,
}


def write_mcap(path: str | os.PathLike[str], episode: Episode, header: Mapping[str, Any]) -> None:
    """Write the log and the 1 kHz recording of ``episode`` to ``path``; ``header`` is the first line of its log.

    ``/events`` holds each entry of the log, :data:`TOPICS` what was sensed and commanded (N, m, rad, m/s²; one message
    a millisecond, no digit lost), ``/truth`` what only the scorer knew.  Times are simulated nanoseconds from 0, and
    the metadata record ``thenar`` is the header, each value as JSON; so the same episode gives the same bytes.
    Written all or nothing, compressed by zstd; about 0.5 s and 3.6 MB for 14 s.

    Raises InputError if the file cannot be written.
    """
    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.ZSTD)
    writer.start()
    writer.add_metadata("thenar", {name: _json(value) for name, value in header.items()})
    sensors = dict.fromkeys((s for entry in episode.run.entries for s in entry.get("sensors", ())), _READING)
    events = _channel(writer, "/events", {**_ENTRY, "sensors": {"type": "object", "properties": sensors}})
    tracks = [(_channel(writer, topic, fields), messages) for topic, fields, messages in _tracks(episode)]
    channels = [channel for channel, _ in tracks]
    rows = enumerate(zip(*(messages for _, messages in tracks), strict=True))
    # a row is what was measured at the end of its period, and comes before what was made of it
    measured = ((_MS * (k + 1), k, zip(channels, row, strict=True)) for k, row in rows)
    happened = (
        (1000 * round(1e6 * entry["t"]), k, [(events, _json(entry))]) for k, entry in enumerate(episode.run.entries)
    )
    for time_ns, number, messages in heapq.merge(measured, happened, key=itemgetter(0)):
        for channel, message in messages:
            writer.add_message(channel, time_ns, message.encode(), time_ns, number)
    writer.finish()  # type: ignore[no-untyped-call]
    atomic_write(path, stream.getvalue())


def _tracks(episode: Episode) -> Iterator[tuple[str, dict[str, Any], Iterator[str]]]:
    """Yield each topic of a message a millisecond: its name, the schema of its fields, and its messages."""
    at = {name: k for k, name in enumerate(episode.channels)}
    for topic, fields in TOPICS.items():
        columns = [at[c] for field in fields.values() for c in ((field,) if isinstance(field, str) else field)]
        schema = {name: _number(name, 0 if isinstance(field, str) else len(field)) for name, field in fields.items()}
        yield topic, schema, _messages(schema, episode.recording[:, columns])
    truth = episode.truth
    values = np.column_stack(
        [truth.height_m, truth.aside_m, truth.tilt_rad, truth.on_table, np.median(truth.slid_m, axis=2)]
    )
    schema = {name: _number(name, 0) for name in _TRUTH}
    yield "/truth", schema, _messages(schema, values)


def _messages(fields: Mapping[str, Mapping[str, Any]], values: NDArray[np.float64]) -> Iterator[str]:
    """Yield each row of ``values`` as a JSON object with ``fields``, of which an array takes several columns."""
    # a format string: quicker than json.dumps of a dict, and %s of a float is as exact
    slots = (f'"{name}":' + (f"[{','.join(['%s'] * n)}]" if (n := _length(f)) else "%s") for name, f in fields.items())
    pattern = "{" + ",".join(slots) + "}"
    rows: list[list[float | str]] = values.tolist()
    if not np.isfinite(values).all():  # a sensor at fault: JSON has no word for nan
        rows = [[x if np.isfinite(x) else "null" for x in row] for row in values]
    return (pattern % tuple(row) for row in rows)


def _length(field: Mapping[str, Any]) -> int:
    return int(field.get("maxItems", 0))


def _number(name: str, length: int) -> dict[str, Any]:
    """Return the schema of a number, or of an array of ``length`` of them, with its unit."""
    unit = _UNITS[name.partition("_")[0]]
    if not length:
        return {"type": "number", "description": unit}
    return {
        "type": "array",
        "items": {"type": "number"},
        "minItems": length,
        "maxItems": length,
        "description": f"{unit}, by element",
    }


def _channel(writer: Writer, topic: str, fields: Mapping[str, Any]) -> int:
    schema = {"title": topic[1:], "type": "object", "properties": fields}
    return writer.register_channel(
        topic, "json", writer.register_schema(f"thenar{topic.replace('/', '.')}", "jsonschema", _json(schema).encode())
    )


def _json(value: Entry | Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)

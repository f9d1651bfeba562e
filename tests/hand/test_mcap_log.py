"""The MCAP file: all of the log and of the recording, to the last digit, and the same bytes each time."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from mcap.reader import make_reader

from thenar.errors import InputError
from thenar.hand.episode import Episode
from thenar.hand.mcap_log import TOPICS, write_mcap
from thenar.runtime.record import header

HEADER = header("glr", variant="paper", seed=1, events=["approach_1", "incip_slip*"], scenario="gave_up")


@pytest.fixture(scope="module")
def short(episode: Callable[..., Episode]) -> Episode:
    return episode("paper", "misaligned-thrice")


@pytest.fixture(scope="module")
def file(short: Episode, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("mcap") / "episode.mcap"
    write_mcap(path, short, HEADER)
    return path


@pytest.fixture(scope="module")
def messages(file: Path) -> dict[str, list[tuple[int, dict[str, Any]]]]:
    """Topic -> (log time in ns, message), in the order of the file."""
    found: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    with file.open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            assert schema is not None
            assert (channel.message_encoding, schema.encoding) == ("json", "jsonschema")
            assert message.publish_time == message.log_time
            found.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
    return found


def test_every_entry_of_the_log_is_there_in_its_order(short: Episode, messages: dict[str, Any]) -> None:
    assert [entry for _, entry in messages["/events"]] == json.loads(json.dumps(short.run.entries))
    assert [time / 1e9 for time, _ in messages["/events"]] == pytest.approx([e["t"] for e in short.run.entries])


def test_no_digit_of_the_recording_is_lost(short: Episode, messages: dict[str, Any]) -> None:
    n = len(short.recording)
    at = {name: k for k, name in enumerate(short.channels)}
    seen = set()
    for topic, fields in TOPICS.items():
        assert [time for time, _ in messages[topic]] == [(k + 1) * 1_000_000 for k in range(n)]
        for field, channel in fields.items():
            columns = [at[channel]] if isinstance(channel, str) else [at[c] for c in channel]
            read = np.array([message[field] for _, message in messages[topic]]).reshape(n, -1)
            assert np.array_equal(read, short.recording[:, columns])
            seen.update(columns)
    assert seen == set(range(len(short.channels)))


def test_the_truth_is_kept_apart(short: Episode, messages: dict[str, Any]) -> None:
    assert set(messages) == {"/events", "/truth", *TOPICS}
    read = {field: np.array([m[field] for _, m in messages["/truth"]]) for field in messages["/truth"][0][1]}
    assert np.array_equal(read["height_m"], short.truth.height_m)
    assert np.array_equal(read["on_table"], short.truth.on_table)
    assert np.array_equal(read["slid_2_m"], np.median(short.truth.slid_m[:, 1], axis=1))
    for topic in TOPICS:
        assert not set(read) & set(messages[topic][0][1])


def test_every_message_is_as_its_schema_says(file: Path) -> None:
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
        assert summary is not None
        assert {index.compression for index in summary.chunk_indexes} == {"zstd"}
        assert len(summary.chunk_indexes) > 1
        checks = {}
        for number, schema in summary.schemas.items():
            document = json.loads(schema.data)
            Draft202012Validator.check_schema(document)
            # nothing undeclared either: what a viewer is not told of it does not show
            checks[number] = Draft202012Validator(
                document
                | {
                    "additionalProperties": False,
                    "required": [] if "kind" in document["properties"] else list(document["properties"]),
                }
            )
        stream.seek(0)
        for k, (schema_, channel, message) in enumerate(make_reader(stream).iter_messages()):
            if channel.topic == "/events" or k % 97 == 0:
                assert schema_ is not None
                checks[schema_.id].validate(json.loads(message.data))


def test_the_messages_come_in_the_order_of_time(file: Path) -> None:
    with file.open("rb") as stream:
        times = [m.log_time for _, _, m in make_reader(stream).iter_messages(log_time_order=False)]
    assert times == sorted(times)
    assert times[0] == 1_000_000  # ns: the first reading


def test_the_header_is_the_metadata(file: Path) -> None:
    with file.open("rb") as stream:
        (record,) = make_reader(stream).iter_metadata()
    assert record.name == "thenar"
    assert {name: json.loads(text) for name, text in record.metadata.items()} == HEADER


def test_the_same_episode_gives_the_same_bytes(short: Episode, file: Path, tmp_path: Path) -> None:
    write_mcap(tmp_path / "again.mcap", replace(short, wall_s=123.0), HEADER)
    assert (tmp_path / "again.mcap").read_bytes() == file.read_bytes()


def test_what_is_no_number_is_null(short: Episode, tmp_path: Path) -> None:
    spoilt = short.recording.copy()
    spoilt[-1, short.channels.index("normal_3")] = np.nan
    spoilt[-1, short.channels.index("pitch_1")] = np.inf
    write_mcap(tmp_path / "nan.mcap", replace(short, recording=spoilt), HEADER)
    with (tmp_path / "nan.mcap").open("rb") as stream:
        last = {c.topic: json.loads(m.data) for _, c, m in make_reader(stream).iter_messages()}
    assert last["/pad"]["normal"][3] is None
    assert last["/pad"]["normal"][2] == spoilt[-1, short.channels.index("normal_2")]
    assert last["/finger_1"]["pitch"] is None


def test_a_file_that_cannot_be_written_is_an_input_error(short: Episode, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_mcap(tmp_path / "nowhere" / "episode.mcap", short, HEADER)

"""Files that cannot be read, and files that are written whole or not at all."""

from __future__ import annotations

import io
import os
import stat
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from thenar.errors import InputError
from thenar.io import atomic_write, files, load, save
from thenar.model.automaton import Automaton

Says = Callable[..., None]

LAMP = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", marked=["off"], name="LAMP")
TEXT = '[events]\n[automata.M]\nkind = "plant"\ninitial = "x"\n'


# -- reading -------------------------------------------------------------------------------------------------


def test_a_missing_file_is_offered_the_nearest_name(files_say: Says) -> None:
    files_say({"hand.toml": TEXT}, "hnad.toml: no such file; did you mean 'hand.toml'?", load_names=("hnad.toml",))


def test_a_missing_folder_is_named(files_say: Says) -> None:
    files_say({}, "models/hand.toml: no such file; there is no folder 'models'", load_names=("models/hand.toml",))


def test_a_folder_is_no_file(files_say: Says, tmp_path: Path) -> None:
    (tmp_path / "models.toml").mkdir()
    files_say({}, "models.toml: a folder, not a file; name the model files in it", load_names=("models.toml",))


def test_an_unknown_ending_is_told_the_endings(files_say: Says) -> None:
    files_say(
        {"hand.yaml": "x"},
        "hand.yaml: unknown ending '.yaml'; a model file ends with .toml or .json, another tool's with "
        ".ADS, .cif, .DES, .dot, .fsm, .gen, .gv, .mermaid, .mmd, .wmod, .xmd, .xml, .xws",
    )


def test_a_missing_ending_is_told_the_endings(files_say: Says) -> None:
    files_say(
        {"hand": "x"},
        "hand: no ending; a model file ends with .toml or .json, another tool's with "
        ".ADS, .cif, .DES, .dot, .fsm, .gen, .gv, .mermaid, .mmd, .wmod, .xmd, .xml, .xws",
    )


def test_bytes_that_are_no_text_are_located(files_say: Says) -> None:
    files_say({"hand.toml": b"name = '\xff'"}, "hand.toml: not UTF-8 text: byte 0xff at offset 8; save it as UTF-8")


def test_binary_junk_is_refused_where_it_begins(files_say: Says) -> None:
    files_say(
        {"hand.json": bytes(reversed(range(256)))},
        "hand.json: not UTF-8 text: byte 0xff at offset 0; save it as UTF-8",
    )


def test_a_file_above_the_limit_is_refused_unread(files_say: Says, tmp_path: Path) -> None:
    with (tmp_path / "hand.toml").open("wb") as file:
        file.truncate(files.MAX_BYTES + 1)  # takes no room on the disk
    files_say(
        {},
        "hand.toml: larger than 268,435,456 bytes (256 MiB): 268,435,457 bytes; split the model, several files load "
        "as one problem",
        load_names=("hand.toml",),
    )


def test_standard_input_is_read_up_to_the_limit(files_say: Says, monkeypatch: pytest.MonkeyPatch) -> None:
    class Endless(io.RawIOBase):
        def readable(self) -> bool:
            return True

        def read(self, size: int = -1) -> bytes:
            return b"#" * size

    monkeypatch.setattr(sys, "stdin", type("Stdin", (), {"buffer": Endless()}))
    files_say(
        {},
        "<stdin>: larger than 268,435,456 bytes (256 MiB): it goes on; split the model, several files load as one "
        "problem",
        load_names=("-",),
    )


def test_standard_input_is_read_once(files_say: Says) -> None:
    files_say({}, "standard input can be read once only; give - once", load_names=("-", "-"))


def test_loading_nothing_asks_for_a_file(files_say: Says) -> None:
    files_say({}, "no file to load; name at least one model file, or - for standard input", load_names=())


def test_what_the_system_refuses_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    (tmp_path / "hand.toml").write_text(TEXT)
    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(InputError, match=r"hand.toml: cannot be read: Permission denied$"):
        load(tmp_path / "hand.toml")


def test_a_null_character_in_a_path_is_refused() -> None:
    with pytest.raises(InputError, match=r"cannot be read: embedded null|no such file"):
        load("ha\0nd.toml")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_is_read_like_a_file(tmp_path: Path) -> None:
    pipe = tmp_path / "hand.toml"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(TEXT,))
    writer.start()
    assert load(pipe).plants[0].name == "M"
    writer.join()


# -- writing -------------------------------------------------------------------------------------------------


def test_a_written_file_holds_what_was_given(tmp_path: Path) -> None:
    atomic_write(tmp_path / "a", "ψ\r\n")
    atomic_write(str(tmp_path / "b"), b"\0\xff")
    assert (tmp_path / "a").read_bytes() == "ψ\r\n".encode()
    assert (tmp_path / "b").read_bytes() == b"\0\xff"
    assert sorted(os.listdir(tmp_path)) == ["a", "b"]


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_write_that_fails_leaves_everything_as_it_was(
    step: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    target = tmp_path / "lamp.toml"
    target.write_text("before")
    monkeypatch.setattr(os, step, fail)
    with pytest.raises(InputError, match=r"lamp.toml: cannot be written: No space left on device$"):
        save(LAMP, target)
    assert os.listdir(tmp_path) == ["lamp.toml"]
    assert target.read_text() == "before"


def test_an_interrupted_write_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        save(LAMP, tmp_path / "lamp.toml")
    assert os.listdir(tmp_path) == []


def test_a_model_that_cannot_be_written_touches_no_file(tmp_path: Path) -> None:
    target = tmp_path / "lamp.toml"
    target.write_text("before")
    with pytest.raises(InputError):
        save(Automaton.empty(LAMP.alphabet), target)
    assert target.read_text() == "before"


@pytest.mark.skipif(os.name != "posix", reason="needs permissions")
def test_permissions_stay_and_new_files_follow_the_umask(tmp_path: Path) -> None:
    target = tmp_path / "lamp.toml"
    target.write_text("before")
    target.chmod(0o640)
    atomic_write(target, "after")
    assert stat.S_IMODE(target.stat().st_mode) == 0o640
    old = os.umask(0o027)
    try:
        atomic_write(tmp_path / "new.toml", "new")
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "new.toml").stat().st_mode) == 0o640


@pytest.mark.skipif(os.name != "posix", reason="needs symbolic links")
def test_a_link_keeps_pointing_where_it_did(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("before")
    (tmp_path / "link").symlink_to("real")
    atomic_write(tmp_path / "link", "after")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "after"


@pytest.mark.skipif(os.name != "posix", reason="needs devices")
def test_a_device_is_written_to_and_not_replaced() -> None:
    atomic_write(os.devnull, "gone")
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


def test_a_folder_is_not_overwritten(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be written: "):
        atomic_write(tmp_path, "x")
    assert os.listdir(tmp_path) == []


def test_a_missing_folder_is_not_made(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"lamp.toml: cannot be written: there is no folder '.*'$"):
        save(LAMP, tmp_path / "models" / "lamp.toml")


def test_saving_to_an_unknown_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"lamp.yaml: unknown ending '.yaml'; a model file ends with .toml or .json, "):
        save(LAMP, tmp_path / "lamp.yaml")

"""The command line as a person meets it: what it prints, its exit codes, its files, its errors."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import NamedTuple

import jsonschema
import pytest

import thenar
from thenar.cli import main

MODEL = """
[events]
go = {}
stop = {}
slip = { controllable = false }

[automata.HAND]
kind = "plant"
initial = "idle"
marked = ["idle"]
transitions = ["idle -go-> busy -stop-> idle", "busy -slip-> lost -stop-> idle"]

[automata.DRY]
kind = "spec"
initial = "dry"
marked = ["dry"]
alphabet = ["slip"]
transitions = []
says = "Nothing slips."
"""


class Done(NamedTuple):
    code: int
    out: str
    err: str


Run = Callable[..., Done]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command line in this process."""

    def call(*args: object, stdin: str | bytes = "") -> Done:
        data = stdin if isinstance(stdin, bytes) else stdin.encode()
        monkeypatch.setattr(sys, "argv", ["thenar", *map(str, args)])
        monkeypatch.setattr(sys, "stdin", TextIOWrapper(BytesIO(data)))
        with pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        code = ended.value.code
        assert isinstance(code, int)
        return Done(code, captured.out, captured.err)

    return call


@pytest.fixture
def hand(tmp_path: Path) -> Path:
    path = tmp_path / "hand.toml"
    path.write_text(MODEL)
    return path


# -- synth -----------------------------------------------------------------------------------------------------


def test_synth_prints_the_sizes(run: Run) -> None:
    done = run("synth", "glr")
    assert done.code == 0
    assert "plant                 90 states          242 transitions" in done.out
    assert "supervisor         2,809 states        6,076 transitions" in done.out


def test_synth_json_has_exact_counts_as_integers(run: Run) -> None:
    done = run("synth", "glr", "--json")
    answer = json.loads(done.out)
    seconds = answer.pop("seconds")
    assert isinstance(seconds, float)
    assert answer == {
        "plant": {"states": 90, "transitions": 242},
        "supervisor": {"states": 2809, "transitions": 6076},
        "controllable": True,
        "nonblocking": True,
        "engine": "explicit",
        "engine_reason": "the product has at most 100,000 transitions",
    }


def test_an_impossible_task_exits_with_1_and_the_reason(run: Run, tmp_path: Path) -> None:
    model = tmp_path / "m.toml"
    model.write_text(MODEL.replace('"idle -go-> busy', '"idle -slip-> idle -go-> busy'))
    done = run("synth", model)
    assert done.code == 1
    assert done.out.splitlines()[-1] == (
        "No supervisor exists: DRY alone makes it impossible; without it there is one. Already at the start the "
        'uncontrollable event slip could follow, which no supervisor can prevent, and DRY ("Nothing slips.") '
        "forbids slip in its state 'dry'."
    )
    answer = json.loads(run("synth", model, "--json").out)
    assert answer["supervisor"] == {"states": 0, "transitions": 0}
    assert answer["reason"]["conflict"] == ["DRY"]


def first_plant(problem: thenar.Problem | thenar.ExtendedProblem) -> thenar.Automaton:
    assert isinstance(problem, thenar.Problem)
    return problem.plants[0]


def test_the_written_supervisor_is_the_supervisor(run: Run, hand: Path, tmp_path: Path) -> None:
    for ending in ("toml", "json"):
        out = tmp_path / f"sup.{ending}"
        assert run("synth", "glr", "-o", out).code == 0
        again = first_plant(thenar.load(out))
        assert thenar.is_isomorphic(again, thenar.synthesize(thenar.library.glr.problem()).supervisor.automaton)


def test_several_models_are_composed(run: Run, hand: Path, tmp_path: Path) -> None:
    both = json.loads(run("synth", hand, "small_factory", "--json").out)
    assert both["plant"]["states"] == 3 * 9


def test_a_model_comes_through_a_pipe(run: Run) -> None:
    assert json.loads(run("synth", "-", "--json", stdin=MODEL).out)["plant"]["states"] == 3


def test_a_limit_is_exit_code_3(run: Run) -> None:
    done = run("synth", "transfer_line(5)", "--engine", "explicit", "--max-states", "1000")
    assert done.code == 3
    assert "stopped at the limit of 1,000 states" in done.err


def test_a_large_problem_is_solved_by_diagrams(run: Run) -> None:
    done = run("synth", "transfer_line(20)", "--guards")
    assert done.code == 0
    assert "8.77e28 states" in done.out
    assert "symbolic engine" in done.out
    assert "checked on the diagrams: controllable, nonblocking" in done.out
    assert "L20_test if true" in done.out


def test_local_supervisors_are_listed(run: Run) -> None:
    done = run("modular", "transfer_line(2)")
    assert done.code == 0
    assert "784 states" in done.out
    assert "28 states       65 transitions  L1_B1, L1_B2 with L1_M1, L1_M2, L1_TU" in done.out
    answer = json.loads(run("modular", "glr(fingers=10)", "--json").out)
    assert (answer["states"], len(answer["supervisors"])) == (17_928_826_831_041_992_149, 10)


def test_what_looks_wrong_is_exit_code_1(run: Run, tmp_path: Path) -> None:
    assert run("lint", "agv").out == "nothing looks wrong\n"
    model = tmp_path / "m.toml"
    model.write_text(MODEL.replace('"idle -go-> busy', '"lost -slip-> idle -go-> busy'))
    done = run("lint", model)
    assert done.code == 1
    assert "never reaches its state 'lost'" in done.out


def test_guards_in_json(run: Run) -> None:
    done = run("synth", "cat_and_mouse", "--guards", "--json")
    assert json.loads(done.out)["guards"]["c3"] == "ROOM4.mouse"


# -- certificates ----------------------------------------------------------------------------------------------


def test_a_certificate_is_written_and_verified(run: Run, hand: Path, tmp_path: Path) -> None:
    certificate = tmp_path / "hand.cert"
    assert run("synth", hand, "--certificate", certificate).code == 0
    done = run("verify", certificate, hand)
    assert done.code == 0
    assert "proved: controllable, nonblocking, within the specifications and largest" in done.out
    other = run("verify", certificate, "glr")
    assert other.code == 1
    assert "not proved: the certificate is about another problem" in other.out


def test_a_corrupted_certificate_is_exit_code_2(run: Run, hand: Path, tmp_path: Path) -> None:
    certificate = tmp_path / "hand.cert"
    run("synth", hand, "--certificate", certificate)
    whole = bytearray(certificate.read_bytes())
    whole[len(whole) // 2] ^= 255
    certificate.write_bytes(whole)
    done = run("verify", certificate)
    assert done.code == 2
    assert done.err == f"thenar: {certificate}: damaged: the contents do not match their digest\n"


# -- check -----------------------------------------------------------------------------------------------------


def test_check_says_what_does_not_hold_and_shows_a_trace(run: Run, hand: Path) -> None:
    done = run("check", hand, "--property", "controllable")
    assert done.code == 1
    assert done.out == (
        "controllable: no after go, slip: the plant can do uncontrollable 'slip', which 'DRY' forbids in state 'dry'\n"
    )
    assert run("check", hand, "--property", "nonblocking").code == 0
    assert run("check", "small_factory", "--property", "nonconflicting").code == 0
    answers = json.loads(run("check", hand, "--json").out)
    assert [a["property"] for a in answers] == ["controllable", "nonblocking", "nonconflicting", "solvable"]
    assert answers[0]["witness"] == ["go", "slip"]


def test_specifications_that_block_each_other_conflict_and_block(run: Run, tmp_path: Path) -> None:
    spec = {"kind": "spec", "initial": "0", "marked": ["2"]}
    automata = {
        "P": {"kind": "plant", "initial": "0", "marked": ["0"], "transitions": [["0", "a", "0"], ["0", "b", "0"]]},
        "AB": {**spec, "transitions": ["0 -a-> 1 -b-> 2"]},
        "BA": {**spec, "transitions": ["0 -b-> 1 -a-> 2"]},
    }
    model = tmp_path / "conflict.json"
    model.write_text(json.dumps({"events": {"a": {}, "b": {}}, "automata": automata}))
    verdicts = {a["property"]: a["holds"] for a in json.loads(run("check", model, "--json").out)}
    assert verdicts == {"controllable": True, "nonblocking": False, "nonconflicting": False, "solvable": False}


# -- explain ---------------------------------------------------------------------------------------------------

THIRD_SLIP = (
    "approach_1, approach_2, align_finger2, prox_make_C1, prox_make_C2, suppress_vib1, suppress_vib2, orient_normal1, "
    "orient_normal2, apply_gripF, apply_loadF, incip_slip, inc_gripF, incip_slip, inc_gripF, incip_slip"
)


def test_explain_tells_why_the_third_increase_of_the_grip_force_is_disabled(run: Run) -> None:
    done = run("explain", "glr", "--after", THIRD_SLIP, "--event", "inc_gripF")
    assert done.code == 0
    assert "the event inc_gripF* is disabled: SPEC4" in " ".join(done.out.split())
    data = json.loads(run("explain", "glr", "--after", THIRD_SLIP, "--event", "inc_gripF", "--json").out)
    assert data[0]["violations"][0]["state"] == "slip_3"


def test_explain_without_an_event_explains_all_that_is_disabled(run: Run) -> None:
    assert "SPEC1" in run("explain", "glr").out
    assert "After approach_1 nothing is disabled; enabled: retract_finger_1, approach_2." in " ".join(
        run("explain", "glr", "--after", "approach_1").out.split()
    )
    assert "disabled" in run("explain", "glr", "--state", "75").out


def test_explain_of_a_prevented_trace_says_where_it_is_cut(run: Run) -> None:
    done = run("explain", "glr", "--after", "approach_2, approach_1")
    assert "approach_2 is disabled: SPEC1" in " ".join(done.out.split())


# -- simulate --------------------------------------------------------------------------------------------------


def test_simulate_prints_what_the_paper_prints(run: Run) -> None:
    done = run("simulate", "glr", "--trace", "approach_1, approach_2")
    assert done.out == (
        "Event approach_1 is enabled at state 0\n"
        "Event approach_2 is disabled at state 0\n"
        "Event approach_2 is enabled at state 1\n"
    )


def test_simulate_at_random_repeats_itself(run: Run) -> None:
    first = run("simulate", "glr", "--random", "20", "--seed", "3", "--json").out
    assert run("simulate", "glr", "--random", "20", "--seed", "3", "--json").out == first
    assert len(json.loads(first)) == 20
    assert run("simulate", "glr", "--random", "20", "--seed", "4", "--json").out != first


def test_simulate_lets_a_person_step_undo_and_err(run: Run) -> None:
    done = run("simulate", "glr", "-i", stdin="1\nnonsense\napproach_2\nu\nq\n")
    assert done.code == 0
    assert "disabled: SPEC1" in done.out
    assert "'nonsense' is not enabled here" in done.out
    assert done.out.splitlines()[-1].endswith("Trace: approach_1")
    assert run("simulate", "glr", "-i", stdin="").code == 0
    odd = run("simulate", "glr", "-i", stdin="²\n" + "9" * 5000 + "\n0\n-1\nq\n")
    assert odd.code == 0
    assert odd.out.count("is not enabled here") == 4
    assert run("simulate", "glr", "-i", "--json").code == 2


def test_show_json_is_a_model_file(run: Run, hand: Path) -> None:
    assert thenar.is_isomorphic(
        first_plant(thenar.loads(run("show", hand, "--json").out)), first_plant(thenar.load(hand))
    )
    supervisor = first_plant(thenar.loads(run("show", "glr", "--automaton", "supervisor", "--json").out))
    assert supervisor.n_states == 2809


# -- show, paper, doctor ---------------------------------------------------------------------------------------


def test_show_gives_a_table_mermaid_and_svg(run: Run, hand: Path, tmp_path: Path) -> None:
    assert "HAND" in run("show", hand).out
    assert "stateDiagram-v2" in run("show", hand, "--automaton", "HAND", "--format", "mermaid").out
    drawing = tmp_path / "hand.svg"
    assert run("show", hand, "--automaton", "supervisor", "--format", "svg", "-o", drawing).code == 0
    assert drawing.read_text().startswith("<svg")
    assert (
        run("show", "glr", "--automaton", "FINGER1", "--format", "svg", "--after", "approach_1, approach_2").code == 0
    )
    assert "a drawing shows one automaton" in run("show", "glr", "--format", "svg").err


def test_paper_prints_the_results_and_exits_with_0(run: Run) -> None:
    done = run("paper")
    assert done.code == 0
    assert "Event approach_1 is enabled at state 0" in done.out
    rows = json.loads(run("paper", "--json").out)["rows"]
    assert {"what", "published", "computed", "match", "status"} == set(rows[0])
    assert all(row["match"] for row in rows if row["status"] == "exact")


def test_paper_exits_with_1_if_an_exact_result_is_missed(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from thenar.library import glr

    monkeypatch.setattr(glr, "adequate", lambda: glr.spec3(1))
    assert run("paper", "--json").code == 1


def test_doctor_finds_what_is_needed(run: Run) -> None:
    done = run("doctor", "--json")
    assert done.code == 0
    found = {f["what"]: f["found"] for f in json.loads(done.out)}
    assert found["kernel"] == "works"


# -- bad input: one clear error, exit code 2, nothing half-written ---------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "{file}: the file is empty; a model file gives events and automata"),
        (
            MODEL.replace('"idle -go-> busy', '"idle -goo-> busy'),
            "{file}:11: automaton 'HAND', transition 1: unknown event 'goo'; did you mean 'go'?",
        ),
        (
            MODEL.replace("lost -stop-> idle", "lost -stop-> idle -go-> lost"),
            "nondeterministic: 'go' leads from 'idle'",
        ),
        (MODEL.replace('initial = "idle"\n', ""), "initial"),
        (MODEL.replace("stop = {}", "go = {}"), "{file}:4"),
        (MODEL.replace('kind = "spec"', 'kind = "sepc"'), "'plant' or 'spec'"),
    ],
    ids=["empty", "unknown", "nondeterministic", "no-initial", "duplicate", "kind"],
)
def test_a_bad_model_is_one_error_that_names_the_place(run: Run, tmp_path: Path, text: str, message: str) -> None:
    model, out = tmp_path / "bad.toml", tmp_path / "out.toml"
    model.write_text(text)
    done = run("synth", model, "-o", out, "--certificate", tmp_path / "c")
    assert done.code == 2
    assert message.format(file=model) in done.err
    assert done.out == ""
    assert [p.name for p in tmp_path.iterdir()] == ["bad.toml"]


def test_no_output_overwrites_a_model_or_another_output(run: Run, hand: Path, tmp_path: Path) -> None:
    before = hand.read_text()
    assert "would overwrite" in run("synth", hand, "-o", hand).err
    assert "would overwrite" in run("synth", hand, "--certificate", hand).err
    both = tmp_path / "both.json"
    assert run("synth", hand, "-o", both, "--certificate", both).code == 2
    assert "'-' is no file to write to" in run("synth", hand, "-o", "-").err
    assert hand.read_text() == before
    assert list(tmp_path.iterdir()) == [hand]


def test_a_file_or_folder_does_not_shadow_a_library_model(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("glr").mkdir()
    assert run("synth", "glr").code == 0


def test_state_names_with_the_separator_can_be_saved(run: Run, tmp_path: Path) -> None:
    model = tmp_path / "bar.json"
    automata = {
        name: {"kind": "plant", "initial": p, "marked": [p], "transitions": [[p, name, q], [q, name, p]]}
        for name, p, q in (("A", "a|b", "a"), ("B", "c", "b|c"))
    }
    model.write_text(json.dumps({"events": {"A": {}, "B": {}}, "automata": automata}))
    assert run("synth", model, "-o", tmp_path / "out.toml").code == 0
    assert first_plant(thenar.load(tmp_path / "out.toml")).n_states == 4


def test_limits_beyond_all_bounds_are_refused(run: Run) -> None:
    done = run("synth", "glr", "--max-states", "9" * 30)
    assert done.code == 2
    assert "a whole number from 0 to 2**63 - 1" in done.err


def test_an_event_controllable_here_and_uncontrollable_there(run: Run, hand: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    other.write_text(
        MODEL.replace("slip = { controllable = false }", "slip = {}").replace("HAND", "A").replace("DRY", "B")
    )
    done = run("synth", hand, other)
    assert done.code == 2
    assert "event 'slip' is uncontrollable in" in done.err


def test_junk_a_huge_file_and_a_missing_one(run: Run, tmp_path: Path) -> None:
    junk = tmp_path / "junk.toml"
    junk.write_bytes(bytes(range(256)))
    assert run("synth", junk).code == 2
    huge = tmp_path / "huge.toml"
    with huge.open("wb") as file:
        file.truncate(1 << 30)
    start = time.perf_counter()
    done = run("synth", huge)
    assert done.code == 2
    assert "larger than 268,435,456 bytes" in done.err
    assert time.perf_counter() - start < 30  # refused by its size, not read: a hang would take minutes
    assert "no such file; did you mean 'junk.toml'?" in run("synth", tmp_path / "junkk.toml").err
    assert run("synth", tmp_path).code == 2


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["synth", "gl"], "no file and no library model is called 'gl'; did you mean 'glr'?"),
        (["synth", "dining(0)"], "dining"),
        (["synth", "glr(7)"], "model 'glr(7)': unknown variant 7"),
        (["synth", "glr", "--engine", "explicitt"], "unknown engine 'explicitt'; did you mean 'explicit'?"),
        (["simulate", "glr", "--trace", "aproach_1"], "unknown event 'aproach_1'; did you mean 'approach_1'?"),
        (["simulate", "glr"], "one of --trace, --interactive and --random"),
        (["explain", "glr", "--after", "fly"], "unknown event 'fly'"),
        (["explain", "glr", "--state", "9999999"], "unknown state 9999999"),
        (["show", "glr", "--automaton", "FINGER3"], "unknown automaton 'FINGER3'; did you mean 'FINGER2'?"),
        (["synth", "glr", "-o", "/nowhere/x.toml"], "cannot be written: there is no folder"),
        (["synth", "glr", "-o", "x.docx"], "unknown ending '.docx'"),
        (["verify", "/nowhere/c"], "/nowhere/c: No such file"),
        (["synth"], "Missing argument 'MODEL...'"),
        (["fly"], "No such command 'fly'"),
    ],
)
def test_wrong_arguments_are_exit_code_2_and_a_clear_word(run: Run, args: list[str], message: str) -> None:
    done = run(*args)
    assert done.code == 2
    assert message in done.err
    assert "Traceback" not in done.err


# -- the process -----------------------------------------------------------------------------------------------


def test_ctrl_c_ends_with_130_and_leaves_nothing(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "thenar.cli", "synth", "chain(24)", "--engine", "explicit", "-o", "out.toml"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        statistics, deadline = Path(f"/proc/{process.pid}/statm"), time.monotonic() + 60
        while statistics.exists() and int(statistics.read_text().split()[1]) < 50_000 and time.monotonic() < deadline:
            time.sleep(0.05)  # until it holds 200 MB: then it explores
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert err.strip() == "thenar: interrupted; nothing was written"
    assert list(tmp_path.iterdir()) == []


def test_the_reader_of_a_pipe_may_leave(tmp_path: Path) -> None:
    command = f"{sys.executable} -m thenar.cli show 'chain(6)' --automaton supervisor | head -1"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", command], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout


def test_a_full_disk_is_one_message() -> None:
    command = f"{sys.executable} -m thenar.cli paper > /dev/full"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "thenar: cannot write the answer: No space left on device\n"


def test_a_terminal_without_unicode_gets_escapes() -> None:
    command = [sys.executable, "-m", "thenar.cli", "check", "glr", "--property", "controllable"]
    done = subprocess.run(command, capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}, check=False)
    assert b"Traceback" not in done.stderr


def test_the_json_schema_accepts_the_models_here() -> None:
    import tomllib

    jsonschema.validate(tomllib.loads(MODEL), thenar.io.json_schema())

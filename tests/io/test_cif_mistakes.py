"""What is wrong with a CIF model is said in one error, with file, line and column."""

from __future__ import annotations

import random
import re

import pytest

from thenar.errors import InputError, ModelError
from thenar.io import cif

MODEL = """\
controllable c_on, c_off;
uncontrollable u;
enum E = X, Y;
plant lamp:
  disc int[0..3] n;
  disc bool b;
  disc E e;
  location Off: initial; marked; edge c_on do n := n + 1 goto On;
  location On: edge c_off, u when b and n < 3 goto Off;
end
requirement c_on needs lamp.n = 1;
"""
READ = "is not supported; thenar reads events, bounded variables, automata and invariants; see docs/cif.md"
FIT = "they cannot be equal or take turns"
HERE = "¦"  # in a text: the place that the message names


def mistakes(text: str) -> list[str]:
    with pytest.raises(ModelError) as caught:
        cif.loads(text, "m.cif")
    return [str(m) for m in caught.value.mistakes]


def refused(old: str, new: str) -> str:
    """Replace ``old``, or add ``new`` at the end; return what is said of the place that is marked in ``new``."""
    assert old in MODEL
    text = MODEL.replace(old, new, 1) if old else MODEL + new
    before = text.partition(HERE)[0]
    first = mistakes(text.replace(HERE, ""))[0]
    place = f"m.cif:{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}: " if HERE in text else ""
    assert first.startswith(place)
    return first.removeprefix(place)


@pytest.mark.parametrize(
    ("new", "message"),
    [
        ("¦cont t der 1.0;", f"CIF construct 'cont' (continuous variable) {READ}"),
        ("disc ¦real b;", f"CIF construct 'real' (real number) {READ}"),
        ("disc ¦list int b;", f"CIF construct 'list' (list) {READ}"),
        ("disc ¦int b;", "an int without bounds; write int[LOWEST..HIGHEST]"),
        ("disc ¦int[3..1] b;", "int[3..1] has no value"),
        ("disc bool ¦n;", "'lamp.n' is declared twice; rename one of the two"),
        ("disc bool ¦x.b;", "'x.b' is declared here; a name that is declared has no dot"),
        ("disc ¦Lamp b;", "unknown name 'Lamp'; did you mean 'lamp'?"),
        ("disc ¦X b;", "'X' is no type"),
        ("disc bool b = ¦3;", "variable 'lamp.b' of type bool begins with a value of type int[3..3]"),
        ("disc bool b; disc int[0..3] m = ¦4;", "variable 'lamp.m' of type int[0..3] cannot begin with 4"),
        ("alg bool b;", "m.cif:9:35: algebraic variable 'lamp.b' has no value; give it an equation"),
        ("const bool b = n = 1;", "m.cif:9:35: the value of constant 'lamp.b' is not known from the text"),
        ("disc bool b; equation ¦b = true;", "an equation for 'b', which is no algebraic variable of this component"),
        ("alg bool b = true; equation ¦b = true;", "algebraic variable 'lamp.b' has two values"),
    ],
)
def test_mistakes_in_declarations(new: str, message: str) -> None:
    assert refused("disc bool b;", new) == message


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("goto On", "goto ¦Om", "automaton 'lamp' has no location 'Om'"),
        ("edge c_on", "edge ¦c_no", "unknown name 'c_no'; did you mean 'c_on'?"),
        ("edge c_on", "edge ¦tau", f"CIF construct 'tau' (internal event) {READ}"),
        ("edge c_on", "¦edge", f"CIF construct 'tau' (internal event) {READ}"),
        ("edge c_on", "edge ¦c_on!", f"CIF construct 'channel' (event with a sender and a receiver) {READ}"),
        ("edge c_on", "edge ¦n", "'n' is no event"),
        ("edge c_on", "edge c_on ¦now", f"CIF construct 'now' (urgent edge) {READ}"),
        ("edge c_on", "¦alphabet c_off; edge c_on", "'alphabet' cannot stand here; one of 'edge', 'end', "),
        ("disc bool b", "alphabet c_off; disc bool b", "m.cif:8:34: event 'c_on' is not in the alphabet of 'lamp'"),
        ("uncontrollable u", "event u", "m.cif:9:28: event 'u' is neither controllable nor uncontrollable; declare it"),
        ("initial; marked; edge", "edge", "m.cif:4:1: automaton 'lamp' has no initial location; write 'initial;'"),
        ("location On", "location", "m.cif:4:1: automaton 'lamp' has several locations; give each a name"),
        ("location On:", "location On: ¦urgent;", f"CIF construct 'urgent' (urgent location) {READ}"),
        ("n := n + 1", "¦lamp := 1", "'lamp' is no variable that can be assigned"),
        ("n := n + 1", "¦n := b", "variable 'lamp.n' of type int[0..3] is given a value of type bool"),
        ("n := n + 1", "¦n := n + 4", "variable 'lamp.n' of type int[0..3] is given a value of type int[4..7]"),
        ("n := n + 1", "n := 1, ¦n := 2", "variable 'lamp.n' is assigned twice on one edge"),
        ("n := n + 1", "¦(n, b) := 2", f"CIF construct 'tuple' (tuple) {READ}"),
        ("  location On", "  marked locaton ¦On", "'On' cannot stand here; one of '(', ',', ';', an operator should"),
        ("plant lamp:", "plant lamp", "m.cif:5:3: 'disc' cannot stand here; one of"),
        ("end\n", "¦§ end", "CIF does not use the character '§'"),
        ("end\n", "¦/* end", "this comment has no end"),
        ("", "requirement ¦lamp needs true;", "'lamp' is no event"),
        ("", "requirement ¦1 needs true;", "the name of an event is asked for beside 'needs'"),
        ("", "¦initial;", "'initial' asks for a condition here; only in a location it needs none"),
        ("", "x: ¦Lamp();", "unknown name 'Lamp'; did you mean 'lamp'?"),
        ("", "x: ¦lamp();", "'lamp' is no definition"),
        ("", "group def D(event e): end ¦x: D();", "0 arguments for the 1 parameters of D"),
        ("", "plant def D(event e): location: initial; edge e; end x: D(¦1 + 2);", "a event parameter asks for a name"),
        ("", "¦func int f(): return 1; end", f"CIF construct 'func' (function) {READ}"),
        ("", 'import ¦"x.cif";', 'import "x.cif": there is no folder to look in; load the file, or say search=FOLDER'),
    ],
)
def test_mistakes_in_automata_and_around_them(old: str, new: str, message: str) -> None:
    assert refused(old, new).startswith(message)


@pytest.mark.parametrize(
    ("new", "message"),
    [
        ("n ¦and b", "a bool is asked for here, and this is of type int[0..3]"),
        ("¦n", "a condition is asked for here, and this is of type int[0..3]"),
        ("¦not n", "a bool is asked for here, and this is of type int[0..3]"),
        ("b ¦< 3", "a number is asked for here, and this is of type bool"),
        ("n ¦= b", f"a value of type int[0..3] and one of type bool; {FIT}"),
        ("e ¦= 3", f"a value of type E and one of type int[3..3]; {FIT}"),
        ("¦if b: n else b end", f"a value of type int[0..3] and one of type bool; {FIT}"),
        ("n ¦div n = 1", "div by lamp.n; thenar divides by numbers other than 0 that the text gives"),
        ("n ¦mod 0 = 1", "mod by 0; thenar divides by numbers other than 0 that the text gives"),
        ("n ¦/ 2 = 1", f"CIF construct 'real' (real number) {READ}"),
        ("n = ¦1.5", f"CIF construct 'real' (real number) {READ}"),
        ('n = ¦"one"', f"CIF construct 'string' (text) {READ}"),
        ("n ¦in {1, 2}", f"CIF construct 'set' (set) {READ}"),
        ("n = ¦{1}", f"CIF construct 'set' (set) {READ}"),
        ("b => b ¦=> b", "'=>' after another; put brackets around one of them"),
        ("¦sqrt(n) < 3", "function 'sqrt' is not read; there are abs, sign, min, max"),
        ("¦min(n) < 3", "1 arguments for min"),
        ("¦time < 3", f"CIF construct 'time' (the time that has passed) {READ}"),
        ("¦lamp", "'lamp' is an automaton; name one of its locations"),
        ("¦u", "'u' has no value: it is no variable, no location, no constant and no literal"),
        ("¦lamp.m < 3", "'lamp.m': component 'lamp' declares no 'm'"),
        ("¦n.m < 3", "'n.m': 'n' is no component"),
        ("n < ¦)", "')' cannot stand here; an expression should"),
        ("n < ¦99999999999", "the number 99999999999... is too large; CIF's numbers have 32 bits"),
        ("n ¦* 2000000000 > 0", "a result between 0 and 6000000000; CIF's numbers have 32 bits"),
        ("switch lamp: case ¦Of: b else b end", "'Of' is no location of automaton 'lamp'"),
        ("if b: n ¦end", "'end' cannot stand here; 'elif' or 'else' should"),
    ],
)
def test_mistakes_in_expressions(new: str, message: str) -> None:
    assert refused("b and n < 3", new) == message


def test_all_mistakes_are_said_at_once_in_the_order_of_the_text() -> None:
    text = MODEL.replace("n := n + 1", "n := b").replace("b and n < 3", "q").replace("lamp.n = 1", "lamp.n")
    text = text.replace("disc bool b;", "disc bool b = 1;")
    assert [m.split(": ")[0] for m in mistakes(text)] == ["m.cif:6:17", "m.cif:8:47", "m.cif:9:35", "m.cif:11:24"]
    definition = "plant def D(): location: initial; marked x; end a: D(); b: D();"
    assert mistakes(definition) == ["m.cif:1:42: unknown name 'x'"]


def test_what_only_the_whole_shows_names_the_file() -> None:
    assert mistakes("controllable c;") == [
        "m.cif: problem: no plant; a problem needs at least one automaton that says what can happen"
    ]


def said_in_words(text: str) -> bool:
    """Return whether ``text`` loads, or is refused with its place."""
    try:
        cif.loads(text, "m.cif")
    except InputError as error:
        return str(error).startswith("m.cif:")
    return True


def test_a_text_that_ends_too_early_is_no_model_or_a_smaller_one() -> None:
    assert [end for end in range(len(MODEL)) if not said_in_words(MODEL[:end])] == []


def test_mutilated_texts_are_refused_in_words() -> None:
    rng = random.Random(7)
    words = re.findall(r"\s+|\w+|.", MODEL)
    for _ in range(600):
        changed = list(words)
        for _ in range(rng.randint(1, 4)):
            k = rng.randrange(len(changed))
            changed[k] = rng.choice([*words, ""])
        assert said_in_words("".join(changed)), "".join(changed)

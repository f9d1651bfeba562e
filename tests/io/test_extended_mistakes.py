"""What variables, guards and conditions can get wrong: every mistake is one test, with its message."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from thenar.errors import ModelError
from thenar.io import loads

Says = Callable[..., None]

Cup = Callable[..., str]

CASES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "a variable has values": (
        ('lamp = { values = ["red", "green"] }', "lamp = {}"),
        ("""7: variable 'lamp': no values; write values = "0..5", "bool" or a list of names""",),
    ),
    "values are a range, bool or a list": (
        ('"0..5"', '"0-5"'),
        (
            "6: variable 'stock', values: cannot read '0-5' as values; write 'lowest..highest', 'bool' or a list of "
            "values",
        ),
    ),
    "values are no number": (
        ('"0..5"', "5"),
        ("6: variable 'stock', values: expected 'lowest..highest', 'bool' or a list of values, found 5",),
    ),
    "there is a value": (
        ('["red", "green"]', "[]"),
        ("7: variable 'lamp', values: expected 'lowest..highest', 'bool' or a list of values, found []",),
    ),
    "a value is a number, a truth or a name": (
        ('"green"', "1.5"),
        ("7: variable 'lamp', value 2: expected a whole number, true, false or a name, found 1.5",),
    ),
    "a range goes upwards": (
        ('"0..5"', '"5..0"'),
        ("6: variable 'stock', values: no values: 5 is above 0; write 'lowest..highest'",),
    ),
    "a range has an end": (
        ('"0..5"', '"0..9999999999"'),
        ("6: variable 'stock', values: more than 1,000,000 values",),
    ),
    "values are of one kind": (
        ('"green"', "1"),
        ("7: variable 'lamp': its values must be all whole numbers, all truths or all names",),
    ),
    "a value is listed once": (('"green"', '"red"'), ("7: variable 'lamp': value 'red' is listed twice",)),
    "the initial value is one of the values": (
        ('"green"] }', '"green"], initial = ["gren"], marked = "blue" }'),
        (
            "7: variable 'lamp': its initial value 'gren' is none of its values; did you mean 'green'?",
            "7: variable 'lamp': its marked value 'blue' is none of its values",
        ),
    ),
    "there is an initial value": (
        ('"green"] }', '"green"], initial = [] }'),
        ("7: variable 'lamp': no initial value",),
    ),
    "an initial value is no list of lists": (
        ('"green"] }', '"green"], initial = ["red", []], marked = {} }'),
        (
            "7: variable 'lamp', initial value 2: expected a whole number, true, false or a name, found []",
            "7: variable 'lamp', marked: expected a value or a list of values, found a table",
        ),
    ),
    "a variable's name can be written": (
        ("lamp =", '"the lamp" ='),
        (
            "7: variable 'the lamp': a name is made of letters, digits, _ and dots, begins with a letter, and is no "
            "word of Python or true or false",
        ),
    ),
    "a variable's name with a dot is to be quoted": (
        ("lamp =", "cup.lamp ="),
        ("""7: variable 'cup', lamp: unknown key; a name with a dot stands in double quotes: "cup.lamp\"""",),
    ),
    "a variable's name is not that of an automaton": (
        ("lamp =", "CUP ="),
        ("7: variable 'CUP': an automaton is called so too; rename one of the two",),
    ),
    "a value is not called like a variable": (
        ('"green"', '"stock"'),
        ("7: variable 'lamp': its value 'stock' is called like a variable; rename one of them",),
    ),
    "a guard speaks of what there is": (
        ("stock < 3", "stok < 3 and CUP.dwn"),
        (
            "14: automaton 'CUP', transition 1, when: 'stok' is no variable, no state of an automaton and no value; "
            "did you mean 'stock'?",
            "14: automaton 'CUP', transition 1, when: automaton 'CUP' has no state 'dwn'; did you mean 'down'?",
        ),
    ),
    "a state in brackets is one": (
        ("stock < 3", "CUP['flat']"),
        ("14: automaton 'CUP', transition 1, when: automaton 'CUP' has no state 'flat'",),
    ),
    "an automaton is one": (
        ("stock < 3", "CAP['up']"),
        ("14: automaton 'CUP', transition 1, when: unknown automaton 'CAP'; did you mean 'CUP'?",),
    ),
    "a name in quotes is a value": (
        ("stock < 3", "lamp == 'blue'"),
        ("14: automaton 'CUP', transition 1, when: 'blue' is a value of no variable",),
    ),
    "an expression can be read": (
        ("stock < 3", "stock = 3"),
        (
            "14: automaton 'CUP', transition 1, when: expression 'stock = 3', column 7: not understood; "
            "for '=' write '=='",
        ),
    ),
    "an expression is not empty": (
        ("stock < 3", ""),
        ("14: automaton 'CUP', transition 1, when: an expression is empty; write 'true' for one that always holds",),
    ),
    "a guard is true or false": (
        ("stock < 3", "stock + 3"),
        ("14: automaton 'CUP', transition 1, when: a guard is true or false, but 'stock + 3' is a number",),
    ),
    "a comparison is of two like things": (
        ("stock < 3", "lamp == 3"),
        (
            "14: automaton 'CUP', transition 1, when: in 'lamp == 3': 'lamp' is green or red, '3' is a number; "
            "they cannot be compared",
        ),
    ),
    "a number is needed for arithmetic": (
        ("stock < 3", "lamp + 1 < 3"),
        ("14: automaton 'CUP', transition 1, when: in 'lamp + 1': 'lamp' is green or red, where a number is needed",),
    ),
    "a divisor is a number": (
        ("stock < 3", "3 // stock > 0"),
        (
            "14: automaton 'CUP', transition 1, when: in '3 // stock': the divisor must be written as a number other "
            "than 0",
        ),
    ),
    "a guard is a text": (
        ('when = "stock < 3"', "when = 3"),
        ("14: automaton 'CUP', transition 1, when: expected text, found 3",),
    ),
    "an update is of a variable": (
        ("{ stock =", "{ stok ="),
        ("14: automaton 'CUP', transition 1, do 'stok': updates 'stok', which is no variable; did you mean 'stock'?",),
    ),
    "a new value is of the variable's kind": (
        ('"stock + 1"', '"green"'),
        (
            "14: automaton 'CUP', transition 1, do 'stock': 'stock' is a number, but its new value 'green' is the name "
            "green",
        ),
    ),
    "a new value is a value or an expression": (
        ('"stock + 1"', "1.5"),
        ("14: automaton 'CUP', transition 1, do 'stock': expected a value or an expression, found 1.5",),
    ),
    "updates are a table": (
        ('{ stock = "stock + 1" }', '"stock + 1"'),
        ("14: automaton 'CUP', transition 1, do: expected a table, found the text 'stock + 1'",),
    ),
    "a dotted name in an update is to be quoted": (
        ("do = { stock = ", "do = { cup.stock = "),
        (
            "14: automaton 'CUP', transition 1, do 'cup': expected a value or an expression, found a table; "
            "a name with a dot stands in double quotes",
        ),
    ),
    "a transition has an arrow": (
        ('arrow = "up -fill-> up", ', ""),
        ("14: automaton 'CUP', transition 1: no arrow; write arrow = 'state -event-> state'",),
    ),
    "an arrow is one": (
        ('"up -fill-> up"', "3"),
        (
            "14: automaton 'CUP', transition 1, arrow: expected 'state -event-> state' or ['state', 'event', 'state'], "
            "found 3",
        ),
    ),
    "an arrow can be read": (
        ("up -fill-> up", "up fill up"),
        (
            "14: automaton 'CUP', transition 1: cannot read 'up fill up' as transitions; write 'state -event-> state', "
            "spaces around the arrow",
        ),
    ),
    "a key of a transition is a known one": (
        ("when =", "wen ="),
        ("14: automaton 'CUP', transition 1, wen: unknown key; did you mean 'when'?",),
    ),
    "a guarded transition is given once": (
        (
            '"up -pour-> down",',
            '{ arrow = "up -fill-> up", when = "stock < 3", do = { stock = "stock + 1" } },\n"up -pour-> down",',
        ),
        ("15: automaton 'CUP', transition 2: up -fill-> up repeats transition 1",),
    ),
    "a choice is to be said": (
        ('"up -pour-> down",', '"up -pour-> down", "up -pour-> up",'),
        (
            "15: automaton 'CUP', transition 3: nondeterministic: 'pour' leads from 'up' to 'up', and to 'down' in "
            "transition 2; tell them apart by when, or say nondeterministic = true",
        ),
    ),
    "an initial state is one": (
        ('initial = "up"', 'initial = ["up", "upp"]\nstates = ["up", "down"]'),
        ("11: automaton 'CUP', initial state 2: unknown state 'upp'; did you mean 'up'?",),
    ),
    "an initial state is listed once": (
        ('initial = "up"', 'initial = ["up", "up"]'),
        ("11: automaton 'CUP', initial state 2: 'up' is listed twice",),
    ),
    "there is an initial state": (
        ('initial = "up"', "initial = []"),
        ("11: automaton 'CUP', initial: expected at least one state, found []",),
    ),
    "a condition has a kind": (
        ('kind = "spec"\nevent', "event"),
        ("22: condition 2: no kind; say whether it is a 'plant' or a 'spec'",),
    ),
    "a condition says something": (
        ('needs = "CUP.up and stock > 0"\n', ""),
        ("22: condition 2: no predicate; write an invariant, or what an event needs or is disabled_when",),
    ),
    "a condition says one thing": (
        ("needs =", 'disabled_when = "stock == 0"\nneeds ='),
        ("22: condition 2: both needs and disabled_when; make it two conditions",),
    ),
    "what is needed is needed by an event": (
        ('event = "pour"\n', ""),
        ("22: condition 2: no event; say which event needs it",),
    ),
    "what disables disables an event": (
        ('event = "pour"\nneeds', "disabled_when"),
        ("22: condition 2: no event; say which event it disables",),
    ),
    "an invariant is of no event": (
        ("needs =", "invariant ="),
        (
            "24: condition 2, event: an invariant is of no event; an event needs something, or is disabled_when "
            "something holds",
        ),
    ),
    "the event of a condition is one": (
        ('event = "pour"', 'event = "pur"'),
        ("24: condition 2, event: unknown event 'pur'; did you mean 'pour'?",),
    ),
    "a condition is true or false": (
        ('"stock < 5"', '"stock"'),
        ("20: condition 1, invariant: a condition is true or false, but 'stock' is a number",),
    ),
    "a key of a condition is a known one": (
        ("needs =", "need ="),
        ("25: condition 2, need: unknown key; did you mean 'needs'?",),
    ),
    "where the problem starts is true or false": (
        ("[events]", "initial = 'stock'\nmarked = 3\n[events]"),
        ("1: initial: it is true or false, but 'stock' is a number", "2: marked: expected text, found 3"),
    ),
    "a variable is updated by one automaton": (
        (
            "[[conditions]]",
            "[automata.JUG]\nkind = 'plant'\ninitial = 'x'\n"
            "transitions = [{ arrow = 'x -pour-> x', do = { stock = 0 } }]\n[[conditions]]",
        ),
        ("6: variable 'stock': updated by automaton 'CUP' and by automaton 'JUG'; let one of them do it",),
    ),
    "what can be does not depend on what may be": (
        (
            '[[conditions]]\nkind = "spec"',
            '[automata.RULE]\nkind = "spec"\ninitial = "x"\n[[conditions]]\nkind = "plant"',
            "stock < 5",
            "RULE.x",
        ),
        (
            "23: condition 1, invariant: an invariant of the plants depends on 'RULE.x', a state of a specification; "
            "make it one of the specs",
        ),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_each_mistake_has_its_line_and_its_way_out(case: str, cup: Cup, says: Says) -> None:
    replacements, messages = CASES[case]
    says(cup(*replacements), *(f"hand.toml:{message}" for message in messages), error=ModelError)


def test_the_model_without_mistakes_loads(cup: Cup) -> None:
    assert (
        repr(loads(cup()))
        == "ExtendedProblem: 1 plant, 0 specs, 2 variables, 2 conditions, 2 events (0 uncontrollable)"
    )


def test_conditions_are_a_list(cup: Cup, says: Says) -> None:
    one = cup()[: cup().rindex("[[conditions]]")].replace("[[conditions]]", "[conditions]")
    says(one, "hand.toml:18: conditions: expected a list, found a table")


def test_what_has_a_mistake_causes_no_others(cup: Cup, says: Says) -> None:
    """A wrong variable is not unknown where it is used, nor are the states of a wrong automaton."""
    says(
        cup('"0..5"', "5", "CUP.up and stock > 0", "lamp == 3"),
        "hand.toml:6: variable 'stock', values: expected 'lowest..highest', 'bool' or a list of values, found 5",
        "hand.toml:25: condition 2, needs: in 'lamp == 3': 'lamp' is green or red, '3' is a number; they cannot be "
        "compared",
    )
    says(
        cup("up -pour-> down", "up -pour->down", "CUP.up", "CUP.down"),
        "hand.toml:15: automaton 'CUP', transition 2: cannot read 'up -pour->down' as transitions; write "
        "'state -event-> state', spaces around the arrow",
    )
    says(
        cup('["up"]\ntransitions = [', '["up"]\ntransitions = "neutral"\nnote = """[', '"up -pour-> down",\n]', '"""'),
        "hand.toml:13: automaton 'CUP', transition 1: cannot read 'neutral' as transitions; write "
        "'state -event-> state', spaces around the arrow",
    )
    says(
        cup('"stock < 3"', "3", '"up -pour-> down",', '"up -fill-> down", "up -pour-> up",'),
        "hand.toml:14: automaton 'CUP', transition 1, when: expected text, found 3",
    )


def test_events_that_are_not_listed_are_one_mistake(cup: Cup, says: Says) -> None:
    says(
        cup("[events]\nfill = {}\npour = {}\n", ""),
        "hand.toml: no events; list in events each event that the automata use",
    )


def test_json_has_lines_too(says: Says) -> None:
    text = """{"events": {"go": {}},
    "automata": {"M": {"kind": "plant", "initial": "x", "transitions": [
        {"arrow": "x -go-> x",
         "when": "n < 3",
         "do": {"n": true}}]}},
    "variables": {"n": {
        "values": "0..2",
        "initial": 7}},
    "conditions": [
        {"kind": "spec", "invariant": "n"},
        {"kind": "spec", "event": "stop",
         "needs": "n == m"}]}"""
    says(
        text,
        "hand.json:6: variable 'n': its initial value 7 is none of its values",
        "hand.json:11: condition 2, event: unknown event 'stop'; list it in events",
        format="json",
    )
    says(
        text.replace("7", "1"),
        "hand.json:5: automaton 'M', transition 1, do 'n': 'n' is a number, but its new value 'true' is true or false",
        "hand.json:10: condition 1, invariant: a condition is true or false, but 'n' is a number",
        "hand.json:11: condition 2, event: unknown event 'stop'; list it in events",
        "hand.json:12: condition 2, needs: 'm' is no variable, no state of an automaton and no value",
        format="json",
    )

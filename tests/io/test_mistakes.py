"""What a model can get wrong: every mistake is one test, with its message."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from thenar.errors import ModelError
from thenar.io import loads

Hand = Callable[[str, str], str]
Says = Callable[..., None]

PLANT = '[automata.M]\nkind = "plant"\ninitial = "x"\n'


# -- names ---------------------------------------------------------------------------------------------------


def test_an_unknown_event_is_offered_the_nearest_one(hand: Hand, says: Says) -> None:
    says(
        hand("-approach_1->", "-aproach_1->"),
        "hand.toml:10: automaton 'FINGER1', transition 1: unknown event 'aproach_1'; did you mean 'approach_1'?",
        error=ModelError,
    )


def test_an_event_like_no_other_is_to_be_listed(hand: Hand, says: Says) -> None:
    says(
        hand("-slip->", "-tick->"),
        "hand.toml:11: automaton 'FINGER1', transition 2: unknown event 'tick'; list it in events",
    )


def test_an_unknown_event_in_an_alphabet_is_reported(hand: Hand, says: Says) -> None:
    says(
        hand("marked =", 'alphabet = ["slop"]\nmarked ='),
        "hand.toml:8: automaton 'FINGER1', alphabet entry 1: unknown event 'slop'; did you mean 'slip'?",
    )


def test_an_event_that_no_automaton_uses_is_fine(hand: Hand) -> None:
    assert "lift" in loads(hand("[events]", "[events]\nlift = {}")).alphabet


def test_an_event_name_has_no_white_space_and_no_comma(hand: Hand, says: Says) -> None:
    says(
        hand("approach_1 = {}", 'approach_1 = {}\n"move up" = {}'),
        "hand.toml:3: event 'move up': a name is not empty and has no white space and no comma",
    )


def test_an_event_with_a_bad_name_is_not_reported_again_where_it_is_used(says: Says) -> None:
    says(
        '[events]\n"a b" = {}\n' + PLANT + 'transitions = [["x", "a b", "x"]]',
        "hand.toml:2: event 'a b': a name is not empty and has no white space and no comma",
    )


def test_no_events_at_all_is_one_mistake(says: Says) -> None:
    says(
        PLANT + 'transitions = ["x -a-> y", "y -b-> x"]',
        "hand.toml: no events; list in events each event that the automata use",
    )


def test_an_unknown_marked_state_is_offered_the_nearest_one(hand: Hand, says: Says) -> None:
    says(
        hand('marked = ["neutral"]', 'marked = ["netral"]'),
        "hand.toml:8: automaton 'FINGER1', marked state 1: unknown state 'netral'; did you mean 'neutral'?",
    )


def test_with_states_listed_any_other_name_is_a_mistake(hand: Hand, says: Says) -> None:
    says(
        hand('initial = "neutral"', 'states = ["neutral", "near"]\ninitial = "neutrall"').replace("-> near", "-> nera"),
        "hand.toml:8: automaton 'FINGER1', initial: unknown state 'neutrall'; did you mean 'neutral'?",
        "hand.toml:11: automaton 'FINGER1', transition 1: unknown state 'nera'; did you mean 'near'?",
    )


@pytest.mark.parametrize("key", ["states", "marked", "alphabet"])
def test_a_name_listed_twice_is_a_mistake(key: str, says: Says) -> None:
    noun = {"states": "state", "marked": "marked state", "alphabet": "alphabet entry"}[key]
    says(
        "[events]\nx = {}\n" + PLANT + f'{key} = ["x", "x"]',
        f"hand.toml:6: automaton 'M', {noun} 2: 'x' is listed twice",
    )


# -- transitions ---------------------------------------------------------------------------------------------


def test_two_targets_for_one_event_are_a_mistake(hand: Hand, says: Says) -> None:
    says(
        hand('"near -slip', '"neutral -approach_1-> neutral",\n  "near -slip'),
        "hand.toml:11: automaton 'FINGER1', transition 2: nondeterministic: 'approach_1' leads from 'neutral' to "
        "'neutral', and to 'near' in transition 1",
    )


def test_a_transition_given_twice_is_a_mistake(hand: Hand, says: Says) -> None:
    says(
        hand('"near -slip', '["neutral", "approach_1", "near"],\n  "near -slip'),
        "hand.toml:11: automaton 'FINGER1', transition 2: neutral -approach_1-> near repeats transition 1",
    )


@pytest.mark.parametrize("text", ["neutral approach_1 near", "a -b->c", "a -> b", "a -x,-> b", "a -x-> b -> c", ""])
def test_a_text_without_arrows_is_a_mistake(text: str, hand: Hand, says: Says) -> None:
    message = f"cannot read {text!r} as transitions; write 'state -event-> state', spaces around the arrow"
    with pytest.raises(ModelError) as caught:
        loads(hand("neutral -approach_1-> near", text), source="hand.toml")
    assert str(caught.value) == f"hand.toml:10: automaton 'FINGER1', transition 1: {message}"


def test_the_way_to_write_an_arrow_is_shown(hand: Hand, says: Says) -> None:
    says(
        hand("neutral -approach_1-> near", "neutral approach_1 near"),
        "hand.toml:10: automaton 'FINGER1', transition 1: cannot read 'neutral approach_1 near' as transitions; "
        "write 'state -event-> state', spaces around the arrow",
    )


def test_states_of_an_unreadable_transition_are_not_called_unknown(hand: Hand, says: Says) -> None:
    says(
        hand("neutral -approach_1-> near", "neutral -approach_1->close").replace('["neutral"]', '["close"]'),
        "hand.toml:10: automaton 'FINGER1', transition 1: cannot read 'neutral -approach_1->close' as transitions; "
        "write 'state -event-> state', spaces around the arrow",
    )


def test_states_of_other_entries_are_called_unknown(hand: Hand, says: Says) -> None:
    says(
        hand("neutral -approach_1-> near", "neutral -approach_1->close").replace('["neutral"]', '["netral"]'),
        "hand.toml:8: automaton 'FINGER1', marked state 1: unknown state 'netral'; did you mean 'neutral'?",
        "hand.toml:10: automaton 'FINGER1', transition 1: cannot read 'neutral -approach_1->close' as transitions; "
        "write 'state -event-> state', spaces around the arrow",
    )


def test_an_entry_that_is_no_transition_is_a_mistake(hand: Hand, says: Says) -> None:
    says(
        hand('"near -slip', '["near", "slip"],\n  7,\n  ["a", 1, "b"],\n  "near -slip'),
        "hand.toml:11: automaton 'FINGER1', transition 2: expected 'state -event-> state' or "
        "['state', 'event', 'state'], found [\"near\", \"slip\"]",
        "hand.toml:12: automaton 'FINGER1', transition 3: expected 'state -event-> state' or "
        "['state', 'event', 'state'], found 7",
        "hand.toml:13: automaton 'FINGER1', transition 4: expected 'state -event-> state' or "
        "['state', 'event', 'state'], found [\"a\", 1, \"b\"]",
    )


def test_a_chain_is_one_entry_and_complains_once(hand: Hand, says: Says) -> None:
    says(
        hand('kind = "plant"', 'kind = "plant"\nstates = ["neutral"]'),
        "hand.toml:11: automaton 'FINGER1', transition 1: unknown state 'near'",
        "hand.toml:12: automaton 'FINGER1', transition 2: unknown state 'near'",
    )
    says(
        "[events]\na = {}\n" + PLANT + 'states = ["x"]\ntransitions = ["x -a-> near -a-> x"]',
        "hand.toml:7: automaton 'M', transition 1: unknown state 'near'",
    )


# -- keys and values -----------------------------------------------------------------------------------------


def test_a_missing_kind_is_asked_for(hand: Hand, says: Says) -> None:
    says(
        hand('kind = "plant"\n', ""),
        "hand.toml:5: automaton 'FINGER1': no kind; say whether it is a 'plant' or a 'spec'",
    )


def test_a_wrong_kind_lists_the_kinds(hand: Hand, says: Says) -> None:
    says(
        hand('"plant"', '"robot"'),
        "hand.toml:6: automaton 'FINGER1', kind: expected 'plant' or 'spec', found the text 'robot'",
    )


def test_a_missing_initial_state_is_asked_for(hand: Hand, says: Says) -> None:
    says(
        hand('initial = "neutral"\n', ""),
        "hand.toml:5: automaton 'FINGER1': no initial state; say which state the automaton starts in",
    )


def test_an_empty_state_name_is_a_mistake(hand: Hand, says: Says) -> None:
    says(
        hand('initial = "neutral"', 'initial = ""'),
        "hand.toml:7: automaton 'FINGER1', initial: expected a name, found the text ''",
    )


def test_a_misspelt_key_is_offered_the_right_one(hand: Hand, says: Says) -> None:
    says(
        hand("initial =", "intial ="),
        "hand.toml:7: automaton 'FINGER1', intial: unknown key; did you mean 'initial'?",
    )
    says(hand("[events]", "nam = 'hand'\n[events]"), "hand.toml:1: nam: unknown key; did you mean 'name'?")


def test_what_a_misspelt_key_holds_is_checked_all_the_same(hand: Hand, says: Says) -> None:
    says(
        hand("transitions =", "transitons =").replace("[automata.", "[automaton.").replace("-slip->", "-slop->"),
        "hand.toml:5: automaton: unknown key; did you mean 'automata'?",
        "hand.toml:9: automaton 'FINGER1', transitons: unknown key; did you mean 'transitions'?",
        "hand.toml:11: automaton 'FINGER1', transition 2: unknown event 'slop'; did you mean 'slip'?",
    )


def test_a_key_like_no_other_is_told_the_keys(hand: Hand, says: Says) -> None:
    says(
        hand("initial =", "colour = 'red'\ninitial ="),
        "hand.toml:7: automaton 'FINGER1', colour: unknown key; the keys here are kind, initial, marked, states, "
        "alphabet, transitions, nondeterministic, note, says",
    )


def test_two_keys_misspelt_for_one_are_both_reported(hand: Hand, says: Says) -> None:
    says(
        hand("marked =", 'mark = ["near"]\nmarked ='),
        "hand.toml:8: automaton 'FINGER1', mark: unknown key; did you mean 'marked'?",
    )


def test_a_name_with_a_dot_is_to_be_quoted(hand: Hand, says: Says) -> None:
    says(
        hand("[events]", "[events]\nre.align = {}"),
        "hand.toml:2: event 're', align: unknown key; a name with a dot stands in double quotes: \"re.align\"",
    )


def test_a_key_of_the_file_below_a_table_is_to_be_moved(hand: Hand, says: Says) -> None:
    says(
        hand('kind = "plant"', 'kind = "plant"\ndescription = "a finger"'),
        "hand.toml:7: automaton 'FINGER1', description: unknown key; 'description' is said of the whole file, above "
        "the first [table]",
    )


def test_true_and_false_stand_without_quotes(hand: Hand, says: Says) -> None:
    says(
        hand("= false", '= "false"'),
        "hand.toml:3: event 'slip', controllable: expected true or false, found the text 'false'",
    )


def test_an_event_is_a_table(hand: Hand, says: Says) -> None:
    says(hand("approach_1 = {}", "approach_1 = true"), "hand.toml:2: event 'approach_1': expected a table, found true")


def test_an_event_is_an_object_in_json(says: Says) -> None:
    says(
        '{"events": {"slip": null}}',
        "hand.json:1: event 'slip': expected an object in braces, found null",
        format="json",
    )


def test_a_list_is_written_as_one(hand: Hand, says: Says) -> None:
    says(
        hand('marked = ["neutral"]', 'marked = ["neutral"]\nalphabet = "slip"'),
        "hand.toml:9: automaton 'FINGER1', alphabet: expected a list, found the text 'slip'; write [\"slip\"]",
    )


def test_a_state_name_is_text(hand: Hand, says: Says) -> None:
    says(
        hand('marked = ["neutral"]', 'marked = ["neutral", 3]'),
        "hand.toml:8: automaton 'FINGER1', marked state 2: expected text, found 3",
    )


@pytest.mark.parametrize("key", ["computed", "published"])
@pytest.mark.parametrize("size", ["[90]", "[90, -1]", "[90, 242, 2]", '"90"'])
def test_a_size_is_two_numbers(key: str, size: str, hand: Hand) -> None:
    with pytest.raises(ModelError, match=rf"^hand.toml:2: {key} size 'G': expected \[states, transitions\], two whole"):
        loads(hand("[events]", f"[{key}]\nG = {size}\n[events]"), source="hand.toml")


def test_a_size_of_one_number_is_a_mistake(hand: Hand, says: Says) -> None:
    says(
        hand("[events]", "[published]\nG = [90]\n[events]"),
        "hand.toml:2: published size 'G': expected [states, transitions], two whole numbers, found [90]",
    )


def test_a_file_is_a_table(says: Says) -> None:
    says("[1, 2]", "hand.json:1: expected an object in braces with events and automata, found [1, 2]", format="json")


def test_events_and_automata_are_tables(says: Says) -> None:
    says(
        'events = ["slip"]\n[[automata]]\nkind = "plant"',
        'hand.toml:1: events: expected a table, found ["slip"]',
        "hand.toml:2: automata: expected a table, found a list of 1",
    )


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("1.5", "1.5"),
        ("2020-01-01", "a date or time"),
        ("1" + "0" * 99, "a long number"),
        (f'"{"x" * 99}"', "a long text"),
        ("[[[[]]]]", "a list of 1"),
        ("{ a = 1 }", "a table"),
    ],
)
def test_a_message_repeats_short_values_only(value: str, words: str) -> None:
    with pytest.raises(ModelError) as caught:
        loads(f"[events]\nslip = {{ controllable = {value} }}", source="hand.toml")
    assert str(caught.value) == f"hand.toml:2: event 'slip', controllable: expected true or false, found {words}"


# -- the whole -----------------------------------------------------------------------------------------------


def test_a_file_without_automata_is_a_mistake(says: Says) -> None:
    says(
        "[events]\nslip = {}",
        "hand.toml: no automata; say in automata.NAME what the plant can do, and what a specification allows",
    )


def test_a_file_without_a_plant_is_a_mistake(says: Says) -> None:
    says(
        PLANT.replace("plant", "spec"),
        "hand.toml: no plant; at least one automaton of kind 'plant' says what can happen",
    )


def test_all_mistakes_are_reported_at_once_in_the_order_of_the_lines(says: Says) -> None:
    says(
        "[events]\n"
        "slip = { controlable = false }\n"
        '"move up" = {}\n'
        "[automata.PAD]\n"
        'kind = "robot"\n'
        'initial = "dry"\n'
        "marked = [\n"
        '  "dry",\n'
        '  "wett",\n'
        "  3,\n"
        "]\n"
        'transitions = ["dry -slip-> wet", "wet -slop-> dry", "wet"]\n'
        "[automata.ARM]\n"
        'colour = "red"\n',
        "hand.toml:2: event 'slip', controlable: unknown key; did you mean 'controllable'?",
        "hand.toml:3: event 'move up': a name is not empty and has no white space and no comma",
        "hand.toml:5: automaton 'PAD', kind: expected 'plant' or 'spec', found the text 'robot'",
        "hand.toml:9: automaton 'PAD', marked state 2: unknown state 'wett'; did you mean 'wet'?",
        "hand.toml:10: automaton 'PAD', marked state 3: expected text, found 3",
        "hand.toml:12: automaton 'PAD', transition 2: unknown event 'slop'; did you mean 'slip'?",
        "hand.toml:12: automaton 'PAD', transition 3: cannot read 'wet' as transitions; write 'state -event-> state', "
        "spaces around the arrow",
        "hand.toml:13: automaton 'ARM': no initial state; say which state the automaton starts in",
        "hand.toml:13: automaton 'ARM': no kind; say whether it is a 'plant' or a 'spec'",
        "hand.toml:14: automaton 'ARM', colour: unknown key; the keys here are kind, initial, marked, states, "
        "alphabet, transitions, nondeterministic, note, says",
    )


def test_a_mistake_carries_its_place_and_its_reason(hand: Hand) -> None:
    with pytest.raises(ModelError) as caught:
        loads(hand("-slip->", "-slop->"))
    [mistake] = caught.value.mistakes
    assert mistake.where == "<string>:11"
    assert mistake.what == "automaton 'FINGER1', transition 2: unknown event 'slop'; did you mean 'slip'?"

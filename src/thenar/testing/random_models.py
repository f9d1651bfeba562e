"""Random alphabets, automata and control problems, drawn small and quickly from a ``random.Random``.

The same seed gives the same model.  Small draws give small models, so that Hypothesis, which stands in for
the ``random.Random`` in :mod:`thenar.testing.strategies`, shrinks to readable counterexamples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem

__all__ = [
    "PLANT",
    "SPEC",
    "Shape",
    "numbered_alphabet",
    "problem_by_chance",
    "random_alphabet",
    "random_automaton",
    "random_problem",
]


@dataclass(frozen=True, slots=True)
class Shape:
    """What a random automaton looks like: chances in percent.

    ``controllable`` and ``uncontrollable``: that a state has a transition with such an event;
    ``at_first``: the same for uncontrollable events of the initial state;
    ``onward``: that a state leads on to the next one, the first by a controllable event if there is one;
    ``marked``: that a state other than the initial one is marked.
    """

    controllable: int
    uncontrollable: int
    at_first: int
    onward: int
    marked: int


# Tuned, with the chances in random_problem, on some thousand problems.  Plants that wait for a controllable
# event before others come leave room for control: with all chances alike, nineteen of twenty problems are
# empty or trivial.
PLANT = Shape(controllable=50, uncontrollable=40, at_first=5, onward=85, marked=20)
SPEC = Shape(controllable=50, uncontrollable=75, at_first=75, onward=90, marked=85)
UNMARKED_START = 5  # chance in percent that the initial state is not marked


def random_alphabet(rng: Random, *, max_events: int = 8) -> Alphabet:
    """Draw 1 to ``max_events`` events: ``c0, c1, ...`` controllable, ``u0, u1, ...`` uncontrollable.

    >>> random_alphabet(Random(5))
    Alphabet(u0!, u1!, u2!, c3, c4, c5)
    """
    return numbered_alphabet([_chance(rng, 30) for _ in range(_many(rng, 1, max_events))])


def numbered_alphabet(uncontrollable: Sequence[bool]) -> Alphabet:
    """Return one event for each entry: ``numbered_alphabet([False, True])`` is c0, u1!."""
    return Alphabet(Event(f"{'u' if u else 'c'}{k}", controllable=not u) for k, u in enumerate(uncontrollable))


def random_automaton(
    rng: Random, alphabet: Alphabet, *, max_states: int = 4, shape: Shape = PLANT, name: str = ""
) -> Automaton:
    """Draw an automaton with 1 to ``max_states`` states over the whole of ``alphabet``.

    It may block, have states out of reach, or events without any transition, which it forbids.

    >>> list(random_automaton(Random(5), Alphabet(["a", "b"])).transitions())
    [('0', 'a', '1'), ('0', 'b', '0'), ('1', 'b', '2'), ('2', 'a', '0')]
    """
    states = [str(k) for k in range(_many(rng, 1, max_states))]
    marked = [q for q in states if (_chance(rng, shape.marked) if q != "0" else not _chance(rng, UNMARKED_START))]
    targets: dict[tuple[str, str], str] = {}
    for k, q in enumerate(states):
        for e in alphabet:
            chance = shape.controllable if e.controllable else shape.uncontrollable if k else shape.at_first
            if _chance(rng, chance):
                targets[q, e.name] = rng.choice(states)
        onward = [e.name for e in alphabet if e.controllable or k] or alphabet.names
        if onward and _chance(rng, shape.onward):
            targets[q, rng.choice(onward)] = states[(k + 1) % len(states)]
    return Automaton.from_transitions(
        [(q, e, target) for (q, e), target in targets.items()],
        initial="0",
        marked=marked,
        events=alphabet,
        alphabet=alphabet.names,
        states=states,
        name=name,
    )


def random_problem(
    rng: Random, *, max_events: int = 8, max_plants: int = 3, max_specs: int = 3, max_states: int = 4
) -> Problem:
    """Draw a problem of plants with shared and private events, and specs over some of the plants' events.

    ``max_events`` bounds the events of the whole problem, ``max_states`` the states of each automaton.
    By default one problem in five has no supervisor; in two of five there are states to avoid, for a third of
    these because of uncontrollable events; in one of five it is enough to obey the specs, and one in six
    needs no control at all.

    >>> random_problem(Random(6))
    Problem: 3 plants, 2 specs, 8 events (3 uncontrollable)
    """
    alphabet = random_alphabet(rng, max_events=max_events)
    n_plants, n_specs = _many(rng, 1, max_plants), _many(rng, 0, max_specs)
    return problem_by_chance(alphabet, [rng] * n_plants, [rng] * n_specs, max_states=max_states)


def problem_by_chance(
    alphabet: Alphabet, plants: Sequence[Random], specs: Sequence[Random], *, max_states: int = 4
) -> Problem:
    """Draw a problem over ``alphabet`` with one source of chance for each plant and each spec."""
    parts = [[e for e in alphabet if _chance(rng, 40)] for rng in plants]
    for k, event in enumerate(alphabet):
        if not any(event in part for part in parts):
            parts[k % len(parts)].append(event)
    return Problem(
        [
            random_automaton(rng, alphabet.restrict(e.name for e in part), max_states=max_states, name=f"G{k}")
            for k, (rng, part) in enumerate(zip(plants, parts, strict=True), 1)
        ],
        [
            random_automaton(
                rng,
                Alphabet(e for e in alphabet if _chance(rng, 45)),
                max_states=max_states,
                shape=SPEC,
                name=f"E{k}",
            )
            for k, rng in enumerate(specs, 1)
        ],
        alphabet=alphabet,
    )


def _many(rng: Random, low: int, high: int) -> int:
    """Draw from ``low`` to ``high``, rather more than less."""
    return max(rng.randint(low, high), rng.randint(low, high))


def _chance(rng: Random, percent: int) -> bool:
    # 0, to which Hypothesis shrinks, means no
    return rng.randrange(100) >= 100 - percent

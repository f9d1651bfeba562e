"""Random alphabets, automata and control problems, drawn small and quickly from a ``random.Random``.

The same seed gives the same model.  Small draws give small models, so that Hypothesis, which stands in for
the ``random.Random`` in :mod:`thenar.testing.strategies`, shrinks to readable counterexamples.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.problem import Problem

__all__ = ["random_alphabet", "random_automaton", "random_problem"]

# Shares in percent, tuned on 10 000 problems of the default size so that about one in five has no supervisor,
# one in four needs no control, and in the rest something, often an uncontrollable event, must be prevented.
UNCONTROLLABLE = 40  # events that no supervisor can disable
KNOWN_TO_SPEC = 55  # events of the plants that a specification mentions
SHARED = 35  # events of one plant that another one knows as well
MARKED = 40  # states that are marked
DENSITY = 55  # events of the alphabet that a state of a plant has
RING=80
SPEC_FREE_DENSITY=90
SPEC_DENSITY = 75  # the same of a specification, which would forbid too much otherwise


def random_alphabet(rng: Random, *, max_events: int = 6) -> Alphabet:
    """Draw 1 to ``max_events`` events: ``c0, c1, ...`` controllable, ``u0, u1, ...`` uncontrollable.

    >>> random_alphabet(Random(5))
    Alphabet(c0, u1!, c2, c3, u4!)
    """
    n = rng.randint(1, max_events)
    free = [_chance(rng, UNCONTROLLABLE) for _ in range(n)]
    return Alphabet(Event(f"{'u' if f else 'c'}{k}", controllable=not f) for k, f in enumerate(free))


def random_automaton(
    rng: Random,
    alphabet: Alphabet,
    *,
    max_states: int = 4,
    density: int = DENSITY,
    free_density: int = DENSITY,
    name: str = "",
) -> Automaton:
    """Draw an automaton with 1 to ``max_states`` states over the whole of ``alphabet``.

    A state has each controllable event with a chance of ``density`` percent, each uncontrollable one with
    ``free_density``; besides, it mostly leads on to the next state, so that few are out of reach.  Any
    number of states, or none, is marked; an event may have no transition at all and so be blocked.

    >>> list(random_automaton(Random(5), Alphabet(["a", "b"])).transitions())
    """
    states = [str(k) for k in range(rng.randint(1, max_states))]
    transitions: dict[tuple[str, str], str] = {}
    for q, following in zip(states, [*states[1:], states[0]], strict=True):
        for event in alphabet:
            if _chance(rng, density if event.controllable else free_density):
                transitions[q, event.name] = rng.choice(states)
        if len(alphabet) and _chance(rng, RING):
            transitions[q, rng.choice(alphabet.names)] = following
    marked = [q for q in states if _chance(rng, MARKED)]
    return Automaton.from_transitions(
        [(q, e, target) for (q, e), target in transitions.items()],
        initial="0",
        marked=marked,
        events=alphabet,
        alphabet=alphabet.names,
        states=states,
        name=name,
    )


def random_problem(
    rng: Random, *, max_events: int = 6, max_plants: int = 3, max_specs: int = 3, max_states: int = 4
) -> Problem:
    """Draw a problem of plants with shared and private events, and specs over part of the plants' events.

    ``max_events`` bounds the events of the whole problem, ``max_states`` the states of each automaton.

    >>> random_problem(Random(1))
    """
    alphabet = random_alphabet(rng, max_events=max_events)
    n_plants = rng.randint(1, max_plants)
    plant_events: list[list[str]] = [[] for _ in range(n_plants)]
    for e in alphabet.names:
        owner = rng.randrange(n_plants)
        for k, events in enumerate(plant_events):
            if k == owner or _chance(rng, SHARED):
                events.append(e)
    plants = [
        random_automaton(rng, alphabet.restrict(events), max_states=max_states, name=f"G{k}")
        for k, events in enumerate(plant_events, 1)
    ]
    specs = [
        random_automaton(rng, _part(rng, alphabet), max_states=max_states, density=SPEC_DENSITY, free_density=SPEC_FREE_DENSITY, name=f"E{k}")
        for k in range(1, rng.randint(0, max_specs) + 1)
    ]
    return Problem(plants, specs, alphabet=alphabet)


def _part(rng: Random, alphabet: Alphabet) -> Alphabet:
    return Alphabet(e for e in alphabet if _chance(rng, KNOWN_TO_SPEC))


def _chance(rng: Random, percent: int) -> bool:
    # written so that 0, to which Hypothesis shrinks, means no
    return rng.randrange(100) >= 100 - percent

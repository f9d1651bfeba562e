"""libFAUDES's SupTcon: Brandin and Wonham's supremal controllable sublanguage, with its own conventions.

* To it tick is an event like others; which one forcing preempts is an argument.
* Its test of a state compares the events of plant and candidate in the order of libFAUDES's numbers for them, and ends
  with the candidate's last one: a preempted event that comes after it is not missed.  So here the preempted event has
  the lowest number, and the plant one more event that loops in every state and has the highest.
* libFAUDES numbers events as it first sees their names, so they are called e000, e001, ... while they are there.
* Of several preempted events, some may go while others stay.  With one there is no difference to ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tests.oracles.libfaudes import _read, event_set, library, lifted
from tests.oracles.worker import isolate

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event, merge

MOST = 100  # events of a problem

isolated = isolate("faudes")


@isolated
def supcon_forcing(plants: Sequence[Automaton], specs: Sequence[Automaton], preempted: str) -> Automaton:
    """Return libFAUDES's SupTcon."""
    faudes = library()
    alphabet = merge([a.alphabet for a in (*plants, *specs)])
    order = sorted(alphabet, key=lambda e: e.name != preempted)
    called = {e.name: f"e{k:03}" for k, e in enumerate(order)}
    last = f"e{MOST:03}"
    event_set(f"e{k:03}" for k in range(MOST + 1))  # gives them their numbers

    def renamed(automaton: Automaton) -> Automaton:
        return replace(automaton, alphabet=Alphabet(replace(e, name=called[e.name]) for e in automaton.alphabet))

    wide = Alphabet([*(replace(e, name=called[e.name]) for e in order), Event(last)])
    result = faudes.Generator()
    faudes.SupTcon(
        lifted([renamed(a) for a in plants], wide),
        event_set(e.name for e in wide if e.controllable),
        event_set(e.name for e in wide if e.forcible),
        event_set([called[preempted]]),
        lifted([renamed(a) for a in specs], wide),
        result,
    )
    found = _read(result, wide)
    if found.is_empty:
        return Automaton.empty(alphabet)
    own = {short: name for name, short in called.items()}
    return Automaton.from_transitions(
        [(source, own[event], target) for source, event, target in found.transitions() if event != last],
        initial=found.states[found.initial],
        marked=[found.states[q] for q in range(found.n_states) if found.marked[q]],
        states=[found.states[q] for q in range(found.n_states)],
        events=alphabet,
        alphabet=alphabet.names,
    )

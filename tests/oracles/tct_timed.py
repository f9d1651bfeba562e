"""TCT's FORCE, and its supcon after it: forcing as a change of the plant.

FORCE lets the preempted events of a state with forcible ones wait for a new, controllable event, the *timeout*: to
disable the timeout is to force.  All preempted events wait for it together, as ours do.  Two differences remain:

* TCT may disable a forcible event where it disables the timeout, so that nothing is left to force; ours wants one that
  is left.  So TCT's result holds ours, and is ours if it is forcibly controllable.
* An event that loops in the plant, and is neither preempted nor forcible, loops behind the timeout too, where all other
  events lead back before it.

pitct 1.0.8 does not end the lists of events that it hands to TCT: with a label of -1 at their end FORCE sees them.
"""

from __future__ import annotations

from collections.abc import Sequence

from tests.oracles.tct import session
from tests.oracles.worker import isolate

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event, merge

TIMEOUT = Event("~timeout")

isolated = isolate("pitct")


@isolated
def supcon_forcing(plants: Sequence[Automaton], specs: Sequence[Automaton], preempted: Sequence[str]) -> Automaton:
    """Return TCT's supcon of the plants after FORCE; the timeout is one of its events."""
    alphabet = merge([a.alphabet for a in (*plants, *specs)])
    with session(*plants, *specs, Automaton.empty(Alphabet([TIMEOUT]))) as tct:
        known = {e for a in plants for e in a.alphabet.names}
        free = [e for e in alphabet.names if e not in known]
        plant = tct.sync(plants, *([tct.create_loops(free)] if free else []))
        forcible = [tct.labels[e.name] for e in alphabet if e.forcible]
        waiting = [tct.labels[e] for e in preempted]
        forced = tct.do("force", plant, [*forcible, -1], [*waiting, -1], tct.labels[TIMEOUT.name])
        return tct.read(tct.do("supcon", forced, tct.legal(list(specs))))

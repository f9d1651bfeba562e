"""The real TCT (pip ``pitct``), taught our automata: what it answers, in our terms and in its numbering.

How the two worlds are mapped onto each other:

* Labels.  Event k of the common alphabet is 2k + 1 if it is controllable, else 2k + 2.  The order is kept, and
  so TCT numbers states as we do.
* Alphabets.  TCT has none: it knows the events that occur in some transition.  An event that an automaton has
  in its alphabet and never does would not be blocked by TCT's sync; so it is looped at an extra state that
  nothing leads to, which TCT sees, and drops from every result.
* Specifications.  TCT's supcon, condat and nonconflict have one alphabet for all.  So each specification is
  self-looped with the events that it does not know; the legal language is TCT's meet of them, the plant TCT's
  sync.
* Events of specifications alone.  No plant hinders them: a one-state automaton that loops them joins the plants.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from functools import reduce
from operator import or_
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from tests.oracles.worker import isolate

from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.supervisor import Supervisor
from thenar.model.trace import Trace

Automata = Automaton | Iterable[Automaton]

isolated = isolate("pitct")
_shared: list[str] = []  # the folder of questions that are asked together
_MEMORY = Path("/dev/shm")  # TCT answers in files: where there is such a place, they never see a disk


@isolated
def sync(*automata: Automaton, alphabet: Alphabet | None = None) -> Automaton:
    """Return TCT's sync."""
    with session(*automata, alphabet=alphabet) as tct:
        return tct.read(tct.sync(automata))


@isolated
def meet(*automata: Automaton) -> Automaton:
    """Return TCT's meet: an event happens in all automata at once, or not at all."""
    with session(*automata) as tct:
        return tct.read(tct.do("meet", *(tct.create(a) for a in automata)))


@isolated
def trim(automaton: Automaton) -> Automaton:
    """Return TCT's trim."""
    with session(automaton) as tct:
        return tct.read(tct.do("trim", tct.create(automaton)))


@isolated
def supcon(plants: Automata, specs: Automata = (), *, alphabet: Alphabet | None = None) -> Automaton:
    """Return TCT's supcon of the sync of ``plants`` and the meet of ``specs``.

    TCT numbers the states of the whole product breadth-first; those that survive keep that order, which need
    not be the breadth-first order of the result.
    """
    plants, specs = _several(plants), _several(specs)
    with session(*plants, *specs, alphabet=alphabet) as tct:
        return tct.read(tct.do("supcon", tct.plant(plants), tct.legal(specs)))


@isolated
def is_controllable(spec: Automaton, plants: Automata) -> bool:
    """Return the verdict of TCT's condat."""
    plants = _several(plants)
    with session(*plants, spec) as tct:
        return tct.condat(tct.plant(plants), tct.legal([spec]))[0]


@isolated
def condat(plants: Automata, automaton: Automaton) -> Supervisor:
    """Return ``automaton`` with the controllable events that TCT's condat lists as disabled."""
    plants = _several(plants)
    with session(*plants, automaton) as tct:
        _, disabled = tct.condat(tct.plant(plants), tct.legal([automaton]))
    position = {e.name: k for k, e in enumerate(automaton.alphabet) if e.controllable}
    number = _numbers(automaton)
    rows = [
        sorted(position[e] for e in disabled.get(number[q], ()) if e in position) for q in range(automaton.n_states)
    ]
    offsets = np.cumsum([0, *(len(row) for row in rows)])
    return Supervisor(automaton, offsets, np.array([k for row in rows for k in row], np.int32))


@isolated
def supreduce(plants: Automata, automaton: Automaton) -> Automaton:
    """Return TCT's reduction of the supervisor ``automaton``; like any heuristic, one of many."""
    plants = _several(plants)
    with session(*plants, automaton) as tct:
        plant, supervisor = tct.plant(plants), tct.legal([automaton])
        tct.do("condat", plant, supervisor, out="DAT")
        return tct.read(tct.do("supreduce", plant, supervisor, "DAT"))


@isolated
def is_nonconflicting(a: Automaton, b: Automaton) -> bool:
    """Return TCT's nonconflict."""
    with session(a, b) as tct:
        return bool(tct.tct.nonconflict(tct.legal([a]), tct.legal([b])))


@isolated
def project(automaton: Automaton, events: Iterable[str]) -> Automaton:
    """Return TCT's project, which is minimal."""
    seen = automaton.alphabet.restrict(events)
    with session(automaton) as tct:
        erased = [tct.labels[e] for e in automaton.alphabet.names if e not in seen]
        # pitct calls the argument ``obs``, but it is TCT's list of events to erase
        return tct.read(tct.do("project", tct.create(automaton), erased), seen)


@isolated
def minimize(automaton: Automaton) -> Automaton:
    """Return TCT's minstate.

    Not to be trusted (pitct 1.0.8): of 3000 random automata it took 2 for equal to smaller ones with other
    languages, where a state that lacks one event was merged with a state that lacks another.
    """
    with session(automaton) as tct:
        return tct.read(tct.do("minstate", tct.create(automaton)))


@isolated
def complement(automaton: Automaton) -> Automaton:
    """Return TCT's complement over the alphabet of ``automaton``."""
    with session(automaton) as tct:
        labels = [tct.labels[e] for e in automaton.alphabet.names]
        return tct.read(tct.do("complement", tct.create(automaton), labels))


@isolated
def is_isomorphic(a: Automaton, b: Automaton) -> bool:
    """Return TCT's isomorph."""
    with session(a, b) as tct:
        return bool(tct.tct.isomorph(tct.create(a), tct.create(b)))


@isolated
def selfloop(automaton: Automaton, events: Alphabet) -> Automaton:
    """Return TCT's selfloop; the events are new."""
    with session(automaton, Automaton.empty(events)) as tct:
        return tct.read(tct.do("selfloop", tct.create(automaton), [tct.labels[e] for e in events.names]))


@isolated
def shortest_trace(automaton: Automaton, state: int) -> Trace | None:
    """Return pitct's shortest string to a state; pitct has None for the empty string, as for no string."""
    with session(automaton) as tct:
        name, number = tct.create(automaton), _numbers(automaton)
        found = tct.tct.shortest_string(name, 0, number[state], convert=False)
        event = {label: e for e, label in tct.labels.items()}
        return None if found is None else Trace(event[int(label)] for label in found)


@isolated
def answers(questions: Iterable[tuple[Any, ...]]) -> list[Any]:
    """Return the answers to many questions (function, argument, ...) at once, in one folder: that is quicker."""
    with _folder() as folder:
        _shared.append(folder)
        try:
            return [globals()[function].__wrapped__(*arguments) for function, *arguments in questions]
        finally:
            _shared.pop()


class _Session:
    """A folder of TCT files over one alphabet."""

    def __init__(self, alphabet: Alphabet, folder: str) -> None:
        import pitct

        self.tct = pitct
        self.tct.init(folder, overwrite=True)
        self.alphabet = alphabet
        self.labels = {e.name: 2 * k + (1 if e.controllable else 2) for k, e in enumerate(self.alphabet)}
        self._names = (f"DES{k}" for k in range(10_000))

    def do(self, function: str, *args: object, out: str = "") -> str:
        """Call a TCT function that writes a file, and return the name of the file."""
        out = out or next(self._names)
        getattr(self.tct, function)(out, *args)
        return out

    def create(self, automaton: Automaton, loops: Iterable[str] = (), silent: bool = False) -> str:
        """Write ``automaton``, with ``loops`` at every state, and with its ``silent`` events for TCT to see."""
        number = _numbers(automaton)
        labels = [self.labels[e] for e in automaton.alphabet.names]
        transitions = [(number[q], labels[e], number[t]) for q in number for e, t in automaton.row(q)]
        transitions += [(k, self.labels[e], k) for k in number.values() for e in loops]
        size = len(number)
        if number and silent and (never := set(labels) - {label for _, label, _ in transitions}):
            transitions += [(size, label, size) for label in never]
            size += 1
        marked = [number[q] for q in number if automaton.marked[q]]
        return self.do("create", size, transitions, marked)

    def create_loops(self, events: Iterable[str]) -> str:
        return self.do("create", 1, [(0, self.labels[e], 0) for e in events], [0])

    def sync(self, automata: Iterable[Automaton], *others: str) -> str:
        return self.do("sync", *(self.create(a, silent=True) for a in automata), *others)

    def plant(self, plants: list[Automaton]) -> str:
        known = {e for a in plants for e in a.alphabet.names}
        free = [e for e in self.labels if e not in known]
        return self.sync(plants, *([self.create_loops(free)] if free else []))

    def legal(self, specs: list[Automaton]) -> str:
        everything = self.create_loops(self.labels)
        return self.do(
            "meet", everything, *(self.create(a, [e for e in self.labels if e not in a.alphabet]) for a in specs)
        )

    def read(self, name: str, alphabet: Alphabet | None = None) -> Automaton:
        """Return the automaton in a file; its states are called by TCT's numbers."""
        alphabet = self.alphabet if alphabet is None else alphabet
        position = {self.labels[e]: k for k, e in enumerate(alphabet.names)}
        rows = list(self.tct.des_info(name))
        moves = [sorted((position[label], target) for label, target in row["next"] or ()) for row in rows]
        return Automaton.from_arrays(
            alphabet,
            np.cumsum([0, *(len(row) for row in moves)]),
            [e for row in moves for e, _ in row],
            [target for row in moves for _, target in row],
            marked=[row["marked"] for row in rows],
            initial=0 if rows else -1,
        )

    def condat(self, plant: str, supervisor: str) -> tuple[bool, dict[int, list[str]]]:
        """Return whether the supervisor is controllable, and the events that it disables in each state."""
        text = self.tct.printdat("TEXT", self.do("condat", plant, supervisor), convert=False).text
        head, _, data = text.partition("control data:")
        event = {label: e for e, label in self.labels.items()}
        # pitct's own reading of the table loses the third and further events of a state
        table = re.findall(r"(\d+):((?:\s+\d+(?!\d*:))*)", data)
        return "NOT CONTROLLABLE" not in head, {int(q): [event[int(x)] for x in row.split()] for q, row in table}


@contextmanager
def session(*automata: Automaton, alphabet: Alphabet | None = None) -> Iterator[_Session]:
    """Open a session over the alphabet of all ``automata``, in the order of ``alphabet`` if it is given."""
    union = reduce(or_, (a.alphabet for a in automata), Alphabet())
    with nullcontext(_shared[-1]) if _shared else _folder() as folder:
        yield _Session(union if alphabet is None else alphabet.restrict(union.names), folder)


def _folder() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="tct", dir=_MEMORY if _MEMORY.is_dir() else None)


def _numbers(automaton: Automaton) -> dict[int, int]:
    """Return the number in TCT of each state; TCT starts in state 0."""
    order = sorted(range(automaton.n_states), key=lambda q: (q != automaton.initial, q))
    return {q: k for k, q in enumerate(order)}


def _several(automata: Automata) -> list[Automaton]:
    return [automata] if isinstance(automata, Automaton) else list(automata)

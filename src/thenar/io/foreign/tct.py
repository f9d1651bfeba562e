"""TCT's ``.DES``, in its three generations, and the control data in its ``.DAT``.

* ``pitct``: MessagePack, which PiTCT reads and writes (:mod:`thenar.io.foreign.tct_messages`)
* ``x64``: binary, 64 bits, of TCTX64 (:mod:`thenar.io.foreign.tct_records`)
* ``ctct``: binary, 32 bits, "CTCT DES file. Version 1.0", of CTCT and XPTCT; labels end at 999 there

The first bytes tell which one a file is.  In all of them state 0 is the initial one, states are called by their
numbers, an odd label is a controllable event and an even one uncontrollable, the event is called by its label, and
there is no alphabet: the events are those that some transition carries, in rising order.

An event that an automaton has and never does would so be lost, and no longer be blocked in a product.  It is written
as a loop at an extra, unmarked state that nothing leads to: TCT then knows the event, and drops the state from every
result.  Names of events and states, and what else TCT has no words for, go into the table of names.

Vocal outputs (of states, in hierarchical control) are refused: the model has none.  A ``.DAT`` is no automaton:
:func:`loads` says so, and :func:`loads_control_data` reads it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Literal

import numpy as np

from thenar.errors import InputError, UnknownName
from thenar.io.foreign import tct_messages, tct_records
from thenar.io.foreign.tct_numbers import MAX_LABEL, automaton_of, event_of, fail, numbers
from thenar.io.foreign.tct_records import NARROW, WIDE, Records
from thenar.io.foreign.written import Written
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet, Event
from thenar.model.extended import ExtendedAutomaton

__all__ = ["dumps", "loads", "loads_control_data"]

Generation = Literal["pitct", "x64", "ctct"]
GENERATIONS = ("pitct", "x64", "ctct")


def loads(data: bytes, source: str) -> Automaton | ExtendedAutomaton:
    """Read the automaton in the DES file ``data`` of any generation; messages call it ``source``.  O(bytes).

    Nondeterministic ones become extended automata.  Raises ModelError with the offset for what is damaged or of
    another kind, for control data, and for vocal outputs.

    >>> lamp = Automaton.from_transitions(["0 -1-> 1 -2-> 0"], initial="0", marked=["0"], uncontrollable=["2"])
    >>> data = b"".join(dumps(lamp, generation="ctct").chunks)
    >>> data[:26], loads(data, "LAMP.DES")
    (b'CTCT DES file. Version 1.0', Automaton 'LAMP': 2 states (1 marked), 2 transitions, 2 events)
    >>> loads(data[:80], "LAMP.DES")
    Traceback (most recent call last):
    thenar.errors.ModelError: LAMP.DES: offset 0x50: the file ends within its data; it is truncated
    """
    records = _read(data, source)
    if records.control_data:
        fail(source, "this is control data, the events that each state disables, and no automaton; load its file .DES")
    if records.vocal is not None:
        fail(source, f"state {records.vocal} has a vocal output; outputs of states are not supported")
    return automaton_of(source, records.size, records.marked, records.sources, records.labels, records.targets)


def loads_control_data(data: bytes, source: str) -> tuple[tuple[Event, ...], ...]:
    """Read the DAT file ``data`` of TCT's condat: the events that each state of a supervisor disables.

    State q of the answer is state q of the ``.DES`` file that belongs to it.  Raises ModelError as :func:`loads`.

    >>> loads_control_data(b"MZ", "S.DAT")
    Traceback (most recent call last):
    thenar.errors.ModelError: S.DAT: offset 0x0: this is no DES or DAT file of TCT, of none of its generations
    """
    records = _read(data, source)
    if not records.control_data:
        fail(source, "this is an automaton and no control data; load its file .DAT")
    rows: list[list[Event]] = [[] for _ in range(records.size)]
    for q, label in zip(records.sources.tolist(), records.labels.tolist(), strict=True):
        rows[q].append(event_of(label))
    return tuple(map(tuple, rows))


def dumps(
    automaton: Automaton | ExtendedAutomaton,
    *,
    generation: Generation = "pitct",
    alphabet: Alphabet | None = None,
    labels: Mapping[str, int] = MappingProxyType({}),
) -> Written:
    """Write ``automaton`` as a DES file of ``generation``, in pieces.  O(states + transitions).

    An event whose name is a number of the right parity keeps it as its label, if all events do; otherwise the labels
    count through ``alphabet``, 1, 3, 5 for controllable events and 2, 4, 6 for the others, always rising.
    ``alphabet`` are the events of all automata that TCT is to take together, so that an event has the same label in
    each file; by default, those of ``automaton``.  ``labels`` are those that events have in other files already.

    Raises InputError for several initial states, guards and updates, and for more labels or states than fit.

    >>> lamp = Automaton.from_transitions(["off -on-> lit -off-> off"], initial="off", uncontrollable=["off"])
    >>> written = dumps(lamp)
    >>> written.names.events
    (('1', Event('on', controllable)), ('2', Event('off', uncontrollable)))
    >>> list(loads(b"".join(written.chunks), "lamp.des").transitions())
    [('0', '1', '1'), ('1', '2', '0')]
    """
    if generation not in GENERATIONS:
        raise UnknownName("generation", generation, GENERATIONS)
    width = {"x64": WIDE, "ctct": NARROW}.get(generation)
    title = f"TCT's {generation}"
    n = numbers(automaton, width.highest if width else MAX_LABEL, alphabet, labels, title)
    if width and n.size > width.states:
        raise InputError(f"{n.size:,} states, and {title} files hold at most {width.states:,}; take another generation")
    if n.size and int(np.diff(n.offsets).max()) > MAX_LABEL:
        raise InputError(f"more than {MAX_LABEL:,} transitions leave a state, and {title} files count to that only")
    chunks: Iterable[bytes] = tct_records.write(n, width) if width else tct_messages.write(n)
    return Written(chunks, n.names, n.notes)


def _read(data: bytes, source: str) -> Records:
    if tct_records.is_binary(data):
        return tct_records.read(data, source)
    if not tct_messages.is_map(data):
        fail(f"{source}: offset 0x0", "this is no DES or DAT file of TCT, of none of its generations")
    return tct_messages.read(data, source)

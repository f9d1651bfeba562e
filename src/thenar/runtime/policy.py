"""Policies: the supervisor says which controllable events may be started, a policy which one is."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from random import Random
from typing import Literal, Protocol

from thenar.errors import Fault, InputError, UnknownName
from thenar.model.supervisor import Supervisor
from thenar.runtime.driver import Driver

__all__ = ["POLICIES", "Operator", "Policy", "Priority", "RandomPolicy", "policy_named"]

POLICIES = ("shortest", "cheapest", "priority", "random", "operator")


class Policy(Protocol):
    """Chooses among the events that may be started; events are positions in the supervisor's alphabet."""

    @property
    def name(self) -> str:
        """What the log calls the policy."""

    def begin(self) -> None:
        """Take note that a run begins."""

    def saw(self, event: int, state: int) -> None:
        """Take note that ``event`` has happened, and led the supervisor to ``state``."""

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        """Return one of ``choices``, the events enabled in supervisor state ``state``; None to start nothing.

        None ends the run if the state is marked; otherwise it waits for an uncontrollable event, which is
        allowed if ``may_wait``.  A choice whose skill does not get ready in time is left out of the next call.
        """


class _Memoryless:
    """A policy that looks at the state alone."""

    __slots__ = ()

    def begin(self) -> None:
        """Take no note."""

    def saw(self, event: int, state: int) -> None:
        """Take no note."""


class Priority(_Memoryless):
    """Starts the first event of a list that may be started.

    An uncontrollable event in the list means to wait for it where it can come.  Events that are not listed
    follow in the alphabet's order, the controllable ones first.  Raises UnknownName for an unknown event.

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> supervisor = synthesize(small_factory()).supervisor
    >>> policy = Priority(supervisor, ["finish_1", "start_1"])
    >>> policy.choose(0, [0], False), policy.choose(1, [], True)
    (0, None)
    """

    name = "priority"
    __slots__ = ("_order", "_supervisor")

    def __init__(self, supervisor: Supervisor, order: Iterable[str] = ()) -> None:
        alphabet = supervisor.automaton.alphabet
        listed = [alphabet.index(name) for name in order]
        rest = sorted(range(len(alphabet)), key=lambda k: not alphabet[k].controllable)
        self._order = list(dict.fromkeys([*listed, *rest]))
        self._supervisor = supervisor

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        """Return the first of the list in ``choices``, or None if one to wait for comes before it."""
        alphabet = self._supervisor.automaton.alphabet
        awaited = {alphabet.index(e) for e in self._supervisor.automaton.enabled(state) if not e.controllable}
        for event in self._order:
            if event in choices:
                return event
            if may_wait and event in awaited:
                return None
        return None


class RandomPolicy(_Memoryless):
    """Draws evenly from what may be done; waiting is one of it.

    >>> policy = RandomPolicy(Random(7))
    >>> [policy.choose(0, [3, 5], may_wait=True) for _ in range(5)]
    [5, 3, 5, None, 3]
    """

    name = "random"
    __slots__ = ("_rng",)

    def __init__(self, rng: Random) -> None:
        self._rng = rng

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        """Return any of ``choices``, or None."""
        options: list[int | None] = [*choices, *([None] if may_wait or not choices else [])]
        return self._rng.choice(options)


class Operator(_Memoryless):
    """Asks a person, by ``ask(text) -> answer``: a number or a name, ``w`` to wait, ``e`` to end, ``q`` to stop.

    Raises Fault, which stops the run safely, at ``q`` and at the end of the input.

    >>> from thenar.library.classics import small_factory
    >>> from thenar.synthesis.api import synthesize
    >>> policy = Operator(synthesize(small_factory()).supervisor, lambda text: "1")
    >>> policy.choose(0, [0], may_wait=False)
    0
    """

    name = "operator"
    __slots__ = ("_ask", "_supervisor")

    def __init__(self, supervisor: Supervisor, ask: Callable[[str], str]) -> None:
        self._supervisor, self._ask = supervisor, ask

    def choose(self, state: int, choices: Sequence[int], may_wait: bool) -> int | None:
        """Return what the person answers; asks again after an answer that is none."""
        automaton = self._supervisor.automaton
        names = [automaton.alphabet[e].name for e in choices]
        lines = [f"State {state}: {automaton.states[state]}"]
        lines += [f"  {k:>3}  {name}" for k, name in enumerate(names, 1)]
        idle = "e" if automaton.marked[state] else "w" if may_wait else ""
        also = {"e": ", e to end", "w": ", w to wait", "": ""}[idle]
        text = "\n".join(lines) + f"\nstart (number or name{also}, q to stop): "
        while True:
            try:
                answer = self._ask(text).strip()
            except EOFError:
                answer = "q"
            if answer == "q":
                raise Fault("the operator stopped the run")
            if idle and answer == idle:
                return None
            if answer.isdecimal() and 1 <= int(answer[:9]) <= len(names):
                return choices[int(answer) - 1]
            for known in (answer, answer + "*"):
                if known in names:
                    return choices[names.index(known)]
            text = f"{answer!r} cannot be started here; give a number from the list{also} or q to stop: "


def policy_named(
    text: str,
    supervisor: Supervisor,
    driver: Driver,
    *,
    seed: int = 0,
    through: Sequence[str] = (),
    ask: Callable[[str], str] = input,
) -> Policy:
    """Return the policy that ``text`` names: ``shortest``, ``cheapest(worst, e1=5)``, ``priority(e1, e2)``,
    ``random(7)``, ``operator``.

    ``cheapest`` takes the cost of events, 1 of those that it does not name, and ``worst`` to be ready for what costs
    most; ``random`` alone uses ``seed``; ``through`` are the goal events of ``shortest`` and ``cheapest``; ``operator``
    asks by ``ask``.
    Raises UnknownName for another name or an unknown event, InputError for arguments that a policy does not take.

    >>> policy_named("randon", None, None)
    Traceback (most recent call last):
    thenar.errors.UnknownName: unknown policy 'randon'; did you mean 'random'?
    """
    match = re.fullmatch(r"\s*([^\s()]*)\s*(?:\((.*)\))?\s*", text, re.DOTALL)
    kind, words = (match[1], (match[2] or "").replace(",", " ").split()) if match else (text, [])
    if kind == "priority":
        return Priority(supervisor, words)
    if kind == "cheapest":
        return _cheapest(text, words, supervisor, through)
    if kind == "random":
        if len(words) > 1 or not all(re.fullmatch(r"-?\d{1,18}", w, re.ASCII) for w in words):
            raise InputError(f"policy {text!r}: random takes one whole number, its seed, as in 'random(7)'")
        return RandomPolicy(Random(int(words[0]) if words else seed))
    if kind not in POLICIES:
        raise UnknownName("policy", text, POLICIES)
    if words:
        raise InputError(f"policy {text!r}: {kind} takes no arguments")
    if kind == "operator":
        return Operator(supervisor, ask)
    from thenar.runtime.plan import Shortest

    return Shortest(supervisor, driver, through=through)


def _cheapest(text: str, words: Sequence[str], supervisor: Supervisor, through: Sequence[str]) -> Policy:
    """Return the policy of least cost, as ``words`` have it: cases and costs."""
    from thenar.runtime.cheapest import Cheapest

    case: Literal["best", "worst"] = "best"
    costs: dict[str, float] = {}
    for word in words:
        event, sign, number = word.rpartition("=")
        if not sign and number in ("best", "worst"):
            case = "best" if number == "best" else "worst"
        elif sign and re.fullmatch(r"\d{1,15}(\.\d{1,15})?", number, re.ASCII):
            costs[event] = float(number)
        else:
            raise InputError(
                f"policy {text!r}: cheapest takes best, worst and costs, as in 'cheapest(worst, lift=2.5)'"
            )
    return Cheapest(supervisor, costs, case=case, through=through)

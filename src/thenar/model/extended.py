"""Extended automata: bounded variables, guarded transitions that update them, and conditions on states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from thenar.errors import InputError, Mistake, ModelError, UnknownName, counted
from thenar.model.automaton import Automaton
from thenar.model.build import Unknown, parse_arrows
from thenar.model.events import Alphabet, Event, merge
from thenar.model.expressions import TRUE, Expression, Operation, parse
from thenar.model.problem import Problem
from thenar.model.scope import Scope, about_specs, name_clashes, owner, written_twice
from thenar.model.variables import Variable

__all__ = ["Condition", "Edge", "ExtendedAutomaton", "ExtendedProblem", "Variable", "disables", "invariant", "needs"]


@dataclass(frozen=True, slots=True)
class Edge:
    """A transition ``source -event-> target`` that is possible where ``guard`` is true and then does ``updates``.

    ``source`` and ``target`` are positions among the states, ``event`` is one in the alphabet of the automaton.
    ``updates`` are pairs of a variable's name and the expression of its new value, over the values before
    the transition.  An update to a value that the variable cannot take makes the transition impossible.
    """

    source: int
    event: int
    target: int
    guard: Expression = TRUE
    updates: tuple[tuple[str, Expression], ...] = ()


Text: TypeAlias = str | int | Expression  # an expression, written down or made
Row: TypeAlias = (
    str | tuple[str, str, str] | tuple[str, str, str, Text] | tuple[str, str, str, Text, Mapping[str, Text]]
)


@dataclass(frozen=True, slots=True)
class ExtendedAutomaton:
    """An automaton whose transitions may have guards and updates; it may have several initial states.

    * ``initial``, ``marked``: (n_states,) truths; an event of ``alphabet`` without an edge is blocked
    * ``edges``: two edges of one state and event are a choice that the plant makes, if both are possible

    Raises ModelError with all mistakes at once.

    >>> cup = ExtendedAutomaton.from_edges(
    ...     "CUP", [("up", "fill", "up", "n < 3", {"n": "n + 1"}), ("up", "pour", "up", "n == 3", {"n": "0"})],
    ...     initial="up", marked=["up"])
    >>> len(cup.edges), cup.states
    (2, ('up',))
    """

    name: str
    alphabet: Alphabet
    states: tuple[str, ...]
    initial: tuple[bool, ...]
    marked: tuple[bool, ...]
    edges: tuple[Edge, ...]
    meaning: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        n, wrong = len(self.states), []
        wrong += [f"two states are called {s!r}" for s, count in Counter(self.states).items() if count > 1]
        for what, truths in (("initial", self.initial), ("marked", self.marked)):
            if len(truths) != n:
                wrong.append(f"{what} has {counted(len(truths), 'entry')} for {counted(n, 'state')}")
        if n and not any(self.initial):
            wrong.append("no initial state; write which state the automaton starts in")
        for k, e in enumerate(self.edges, 1):
            if not (0 <= e.source < n and 0 <= e.target < n and 0 <= e.event < len(self.alphabet)):
                wrong.append(f"edge {k} is of a state or an event that does not exist")
            elif e.updates:
                written = Counter(v for v, _ in e.updates)
                wrong += [f"{self.place(k - 1)}: updates {v!r} twice" for v, count in written.items() if count > 1]
        if wrong:
            raise ModelError([Mistake(owner(self.name), what) for what in wrong])

    def place(self, k: int) -> str:
        """Return how messages call the edge at position ``k``: its number, counted from 1, and where it leads."""
        e = self.edges[k]
        return f"edge {k + 1} ({self.states[e.source]} -{self.alphabet[e.event].name}-> {self.states[e.target]})"

    @classmethod
    def from_automaton(cls, automaton: Automaton) -> ExtendedAutomaton:
        """Return ``automaton`` as one whose guards are all true."""
        n = automaton.n_states
        rows = ((q, e, t) for q in range(n) for e, t in automaton.row(q))
        return cls(
            automaton.name,
            automaton.alphabet,
            tuple(automaton.states[q] for q in range(n)),
            tuple(q == automaton.initial for q in range(n)),
            tuple(automaton.marked.tolist()),
            tuple(Edge(*row) for row in rows),
            meaning=automaton.meaning,
        )

    @classmethod
    def from_edges(
        cls,
        name: str,
        edges: Iterable[Row],
        *,
        initial: str | Iterable[str],
        marked: Iterable[str] = (),
        uncontrollable: Iterable[str] = (),
        alphabet: Iterable[str] = (),
        events: Alphabet | None = None,
        states: Iterable[str] | None = None,
        meaning: str = "",
    ) -> ExtendedAutomaton:
        """Build from tuples (source, event, target[, guard[, {variable: value}]]), guards and values as text.

        An edge without guard may also be written as an arrow: ``"idle -start-> busy"``.
        ``events`` are the known events: any other name is an error, and their order orders the alphabet; without
        it every event mentioned is known, and controllable unless listed in ``uncontrollable``.  ``alphabet`` adds
        events that no edge carries.  ``states`` lists the states (any other name is an error); without it
        they are those mentioned, the initial ones first.

        Raises ModelError with all mistakes at once.
        """
        for what, entries in (("edges", edges), ("marked", marked), ("uncontrollable", uncontrollable)):
            if isinstance(entries, str):
                raise InputError(f"{what} is a list, not the text {entries!r}")
        mistakes: list[Mistake] = []
        rows = [row for k, item in enumerate(edges, 1) for row in _read_row(item, f"{owner(name)}, edge {k}", mistakes)]
        first = (initial,) if isinstance(initial, str) else tuple(initial)
        final, free, added = tuple(marked), tuple(uncontrollable), tuple(alphabet)
        mentioned = (q for _, (s, _, t, *_) in rows for q in (s, t))
        known_states = tuple(dict.fromkeys([*first, *mentioned] if states is None else states))
        names = dict.fromkeys([*(row[1] for _, row in rows), *added])
        known = Alphabet(Event(e, controllable=e not in free) for e in names) if events is None else events
        number = {q: k for k, q in enumerate(known_states)}
        unknown_state, unknown_event = Unknown("state", known_states), Unknown("event", known.names)
        for what, chosen in (("initial", first), ("marked", final)):
            mistakes += [Mistake(f"{owner(name)}, {what}", unknown_state(q)) for q in chosen if q not in number]
        for what, listed in (("uncontrollable", free), ("alphabet", added)):
            mistakes += [Mistake(f"{owner(name)}, {what}", unknown_event(e)) for e in listed if e not in known]
        mistakes += [
            Mistake(f"{owner(name)}, uncontrollable", f"event {e!r} is controllable in the given events")
            for e in free
            if e in known and known[e].controllable
        ]
        for where, (s, e, t, *_) in rows:
            mistakes += [Mistake(where, unknown_state(q)) for q in (s, t) if q not in number]
            mistakes += [Mistake(where, unknown_event(e))] if e not in known else []
        if mistakes:
            raise ModelError(mistakes)
        own = known.restrict(names)
        built = (Edge(number[s], own.index(e), number[t], guard, new) for _, (s, e, t, guard, new) in rows)
        start, end = (tuple(q in chosen for q in known_states) for chosen in (first, final))
        return cls(name, own, known_states, start, end, tuple(built), meaning=meaning)


def _read_row(item: Any, where: str, mistakes: list[Mistake]) -> list[tuple[str, tuple[Any, ...]]]:
    """Return the edges that ``item`` writes, as (place, (source, event, target, guard, updates))."""
    try:
        if isinstance(item, str):
            return [(where, (*triple, TRUE, ())) for triple in parse_arrows(item)]
        if not 3 <= len(item) <= 5 or not all(isinstance(part, str) for part in item[:3]):
            raise InputError(f"{item!r} is no (source, event, target[, guard[, updates]])")
        where += f" ({item[0]} -{item[1]}-> {item[2]})"
        guard = item[3] if len(item) > 3 and item[3] not in ("", None) else TRUE
        updates = item[4] if len(item) > 4 and item[4] is not None else {}
        if not isinstance(updates, Mapping):
            raise InputError(f"the updates are a table {{variable: value}}, not {updates!r}")
        return [(where, (*item[:3], parse(guard), tuple((str(v), parse(x)) for v, x in updates.items())))]
    except InputError as error:
        mistakes.append(Mistake(where, str(error)))
        return []


@dataclass(frozen=True, slots=True)
class Condition:
    """A condition on states: an invariant, or what an event needs in order to happen.

    * ``event`` None: ``predicate`` holds in every state;  else: ``event`` happens only where it holds
    * in a plant it is what can be, in a specification what may be

    >>> print(invariant("not (CAT.room1 and MOUSE.room1)"), "|", needs("start", "LAMP.green"))
    not (CAT.room1 and MOUSE.room1) | start needs LAMP.green
    """

    predicate: Expression
    event: str | None = None
    name: str = ""
    meaning: str = ""

    def __str__(self) -> str:
        return str(self.predicate) if self.event is None else f"{self.event} needs {self.predicate}"


def invariant(predicate: Text, *, name: str = "", meaning: str = "") -> Condition:
    """Return the condition that ``predicate`` holds in every state.

    >>> print(invariant("not (CAT.room1 and MOUSE.room1)"))
    not (CAT.room1 and MOUSE.room1)
    """
    return Condition(parse(predicate), None, name, meaning)


def needs(event: str, predicate: Text, *, name: str = "", meaning: str = "") -> Condition:
    """Return the condition that ``event`` happens only in states where ``predicate`` holds.

    >>> print(needs("start", "LAMP.green and stock < 3"))
    start needs LAMP.green and stock < 3
    """
    return Condition(parse(predicate), event, name, meaning)


def disables(predicate: Text, event: str, *, name: str = "", meaning: str = "") -> Condition:
    """Return the condition that ``event`` does not happen in states where ``predicate`` holds.

    >>> print(disables("DOOR.open", "start"))
    start needs not DOOR.open
    """
    return Condition(Operation("not", (parse(predicate),)), event, name, meaning)


Part: TypeAlias = Automaton | ExtendedAutomaton | Condition


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class ExtendedProblem:
    """A control problem over extended automata, variables and conditions.

    ``plants`` and ``specs`` may hold automata, extended automata and conditions, mixed; afterwards
    ``plants`` and ``specs`` are the automata, ``plant_conditions`` and ``spec_conditions`` the conditions, every
    name in them resolved.  ``initial`` and ``marked`` are predicates that narrow where the automata and
    variables start and what is marked.  Each variable is updated by one automaton only.

    A state is a state of each automaton and a value of each variable.  In state x,

    * event e *can happen* if each plant that knows it has an edge for it whose guard is true and whose updates
      stay in the ranges of the variables, what the plants' conditions need for e is true, and the state that is
      entered satisfies the plants' invariants;
    * e *may happen* if each specification that knows it has such an edge, and what the specifications'
      conditions need for it is true;
    * x is *bad* if it violates an invariant of the specifications, or if an uncontrollable event can happen
      there and may not, or can lead to a bad state;
    * a supervisor enables or disables controllable events, each as a whole: one that may lead to a bad state is
      disabled.  It has to leave a way to a marked state open, and starts in those initial states that it can keep.

    All guards, conditions and new values read the values before the transition.  States that violate a plant
    invariant do not exist: no initial state is among them.

    Raises ModelError with all mistakes at once, AlphabetClash for an event with two meanings.

    >>> room = ["0 -in-> 1 -out-> 0"]
    >>> cat = Automaton.from_transitions([r.replace("in", "cat_in").replace("out", "cat_out") for r in room],
    ...     initial="0", marked=["0"], name="CAT")
    >>> ExtendedProblem([cat], [invariant("not CAT[1]")], name="no cat")
    ExtendedProblem 'no cat': 1 plant, 0 specs, 0 variables, 1 condition, 2 events (0 uncontrollable)
    """

    name: str
    plants: tuple[ExtendedAutomaton, ...]
    specs: tuple[ExtendedAutomaton, ...]
    variables: tuple[Variable, ...]
    plant_conditions: tuple[Condition, ...]
    spec_conditions: tuple[Condition, ...]
    initial: Expression
    marked: Expression
    alphabet: Alphabet
    description: str

    def __init__(
        self,
        plants: Part | Iterable[Part],
        specs: Part | Iterable[Part] = (),
        *,
        variables: Iterable[Variable] = (),
        initial: Text = TRUE,
        marked: Text = TRUE,
        name: str = "",
        alphabet: Alphabet | None = None,
        description: str = "",
    ) -> None:
        where = f"problem {name!r}" if name else "problem"
        mistakes: list[Mistake] = []
        plants, plant_conditions = _sorted(plants, f"{where}, plants", mistakes)
        specs, spec_conditions = _sorted(specs, f"{where}, specs", mistakes)
        automata, variables = plants + specs, _variables(variables, where, mistakes)
        merged = merge([a.alphabet for a in automata], [a.name or "an automaton without a name" for a in automata])
        if alphabet is not None:
            merge([alphabet, merged], ["the problem's alphabet", "its automata"])
        events = merged if alphabet is None else alphabet
        if not plants:
            mistakes.append(
                Mistake(where, "no plant; a problem needs at least one automaton that says what can happen")
            )
        mistakes += [
            Mistake(where, f"event {e!r} is not in the problem's alphabet") for e in merged.names if e not in events
        ]
        mistakes += name_clashes(automata, variables, where)
        scope = Scope({v.name: v.values for v in variables}, {a.name: dict.fromkeys(a.states) for a in automata})
        for attribute, value in (
            ("name", name),
            ("plants", tuple(scope.automaton(a) for a in plants)),
            ("specs", tuple(scope.automaton(a) for a in specs)),
            ("variables", variables),
            ("plant_conditions", tuple(scope.condition(c, events) for c in plant_conditions)),
            ("spec_conditions", tuple(scope.condition(c, events) for c in spec_conditions)),
            ("initial", scope.truth(initial, f"{where}, initial", "it")),
            ("marked", scope.truth(marked, f"{where}, marked", "it")),
            ("alphabet", events),
            ("description", description),
        ):
            object.__setattr__(self, attribute, value)
        mistakes += [*scope.mistakes, *written_twice(automata), *about_specs(self.plant_conditions, specs)]
        if mistakes:
            raise ModelError(mistakes)

    @classmethod
    def of(cls, problem: Problem | ExtendedProblem) -> ExtendedProblem:
        """Return ``problem`` as an extended one."""
        if isinstance(problem, ExtendedProblem):
            return problem
        return cls(
            problem.plants, problem.specs, name=problem.name, alphabet=problem.alphabet, description=problem.description
        )

    @property
    def automata(self) -> tuple[ExtendedAutomaton, ...]:
        """The plants, then the specifications."""
        return self.plants + self.specs

    def automaton(self, name: str) -> ExtendedAutomaton:
        """Return the plant or specification called ``name``."""
        for a in self.automata:
            if a.name == name:
                return a
        raise UnknownName("automaton", name, [a.name for a in self.automata], self.name)

    def variable(self, name: str) -> Variable:
        """Return the variable called ``name``."""
        for v in self.variables:
            if v.name == name:
                return v
        raise UnknownName("variable", name, [v.name for v in self.variables], self.name)

    def __repr__(self) -> str:
        title = f"ExtendedProblem {self.name!r}" if self.name else "ExtendedProblem"
        free = int(self.alphabet.uncontrollable.sum())
        conditions = len(self.plant_conditions) + len(self.spec_conditions)
        parts = [counted(len(self.plants), "plant"), counted(len(self.specs), "spec")]
        parts += [counted(len(self.variables), "variable"), counted(conditions, "condition")]
        return f"{title}: {', '.join(parts)}, {counted(len(self.alphabet), 'event')} ({free} uncontrollable)"


def _sorted(
    parts: Part | Iterable[Part], where: str, mistakes: list[Mistake]
) -> tuple[tuple[ExtendedAutomaton, ...], tuple[Condition, ...]]:
    """Return the automata and the conditions among ``parts``."""
    automata: list[ExtendedAutomaton] = []
    conditions: list[Condition] = []
    for part in [parts] if isinstance(parts, (Automaton, ExtendedAutomaton, Condition, str)) else parts:
        if isinstance(part, Condition):
            conditions.append(part)
        elif isinstance(part, Automaton):
            automata.append(ExtendedAutomaton.from_automaton(part))
        elif isinstance(part, ExtendedAutomaton):
            automata.append(part)
        else:
            hint = "; a condition is made by invariant, needs or disables" if isinstance(part, str) else ""
            mistakes.append(Mistake(where, f"{part!r} is no automaton and no condition{hint}"))
    return tuple(automata), tuple(conditions)


def _variables(variables: Iterable[Variable], where: str, mistakes: list[Mistake]) -> tuple[Variable, ...]:
    listed = (variables,) if isinstance(variables, Variable) else tuple(variables)
    mistakes += [Mistake(where, f"{v!r} is no variable") for v in listed if not isinstance(v, Variable)]
    return tuple(v for v in listed if isinstance(v, Variable))

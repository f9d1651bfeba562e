"""A problem by other names: what a file could not say is put back."""

from __future__ import annotations

from dataclasses import replace

from thenar.errors import InputError
from thenar.io.foreign.written import ProblemNames
from thenar.model.automaton import Automaton
from thenar.model.events import Alphabet
from thenar.model.expressions import At, Constant, Expression, Name, Operation
from thenar.model.extended import Condition, Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.names import Listed, every_name
from thenar.model.problem import Problem
from thenar.model.variables import Variable

__all__ = ["renamed"]


def renamed(problem: Problem | ExtendedProblem, names: ProblemNames) -> Problem | ExtendedProblem:
    """Return ``problem`` with the names that the model had: ``names`` says what the file calls them.

    Raises InputError for an event or an automaton of the file that is not in ``names``.

    >>> from thenar.model.events import Event
    >>> lamp = Problem(Automaton.from_transitions(["off -on_-> lit"], initial="off", name="LAMP"))
    >>> names = ProblemNames("p", "", (("on_", Event("on!")),), (("LAMP", "a lamp", "", (("lit", "bright"),)),), (), ())
    >>> list(renamed(lamp, names).plants[0].transitions())
    [('off', 'on!', 'bright')]
    """
    return _Renaming(problem, names).problem()


class _Renaming:
    def __init__(self, problem: Problem | ExtendedProblem, names: ProblemNames) -> None:
        self.given, self.names = problem, names
        self.events = dict(names.events)
        self.automata = {label: (name, meaning, dict(states)) for label, name, meaning, states in names.automata}
        self.variables, self.literals = dict(names.variables), dict(names.literals)
        for kind, wanted, known in (
            ("event", problem.alphabet.names, self.events),
            ("automaton", [a.name for a in problem.automata], self.automata),
        ):
            if strange := [name for name in wanted if name not in known]:
                raise InputError(f"{kind} {strange[0]!r} of the file is not in the table of names")

    def problem(self) -> Problem | ExtendedProblem:
        texts = {"name": self.names.name or self.given.name, "description": self.names.description}
        alphabet = Alphabet(event for _, event in self.names.events)
        given = self.given
        if isinstance(given, Problem):
            groups = [[self._plain(a) for a in group] for group in (given.plants, given.specs)]
            return Problem(groups[0], groups[1], alphabet=alphabet, **texts)
        return ExtendedProblem(
            [*map(self._extended, given.plants), *map(self._condition, given.plant_conditions)],
            [*map(self._extended, given.specs), *map(self._condition, given.spec_conditions)],
            variables=[self._variable(v) for v in given.variables],
            initial=self._expression(given.initial),
            marked=self._expression(given.marked),
            alphabet=alphabet,
            **texts,
        )

    def _alphabet(self, own: Alphabet) -> tuple[Alphabet, list[int]]:
        """Return the events by their names, in the order of the table, and the place of each old one among them."""
        order = {label: k for k, label in enumerate(self.events)}
        labels = sorted(own.names, key=order.__getitem__)
        place = {label: k for k, label in enumerate(labels)}
        return Alphabet(self.events[label] for label in labels), [place[label] for label in own.names]

    def _plain(self, automaton: Automaton) -> Automaton:
        name, meaning, states = self.automata[automaton.name]
        alphabet, place = self._alphabet(automaton.alphabet)
        called = tuple(states.get(state, state) for state in every_name(automaton.states))
        moved = Alphabet(alphabet[k] for k in place)
        same = replace(automaton, name=name, meaning=meaning, alphabet=moved, states=Listed(called))
        return same if moved == alphabet else _in_order(same, alphabet)

    def _extended(self, automaton: ExtendedAutomaton) -> ExtendedAutomaton:
        name, meaning, states = self.automata[automaton.name]
        alphabet, place = self._alphabet(automaton.alphabet)
        edges = (
            Edge(
                e.source,
                place[e.event],
                e.target,
                self._expression(e.guard),
                tuple((self.variables.get(v, v), self._expression(x)) for v, x in e.updates),
            )
            for e in automaton.edges
        )
        return ExtendedAutomaton(
            name,
            alphabet,
            tuple(states.get(state, state) for state in automaton.states),
            automaton.initial,
            automaton.marked,
            tuple(edges),
            meaning=meaning,
        )

    def _condition(self, condition: Condition) -> Condition:
        event = None if condition.event is None else self.events[condition.event].name
        return replace(condition, predicate=self._expression(condition.predicate), event=event)

    def _variable(self, variable: Variable) -> Variable:
        def called(values: tuple[int | str, ...]) -> list[int | str]:
            return [self.literals.get(v, v) if isinstance(v, str) else v for v in values]

        name = self.variables.get(variable.name, variable.name)
        return Variable(name, called(variable.values), called(variable.initial), called(variable.marked))

    def _expression(self, x: Expression) -> Expression:
        if isinstance(x, Operation):
            return Operation(x.operator, tuple(map(self._expression, x.operands)))
        if isinstance(x, Name):
            return Name(self.variables.get(x.name, x.name))
        if isinstance(x, At):
            name, _, states = self.automata[x.automaton]
            return At(name, states.get(x.state, x.state))
        return Constant(self.literals.get(x.value, x.value)) if isinstance(x.value, str) else x


def _in_order(automaton: Automaton, alphabet: Alphabet) -> Automaton:
    """Return ``automaton`` with its events in the order of ``alphabet``."""
    from thenar.explicit.rows import rows_in_order_of

    events, targets = rows_in_order_of(alphabet, automaton)
    return replace(automaton, alphabet=alphabet, events=events, targets=targets)

"""Variables, guards, updates and conditions of model files: what they mean together, mistakes with their places."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from thenar.errors import InputError, ModelError
from thenar.io.automata import Actions, Written
from thenar.io.check import Checked
from thenar.io.expressions import MAX_TEXT, read
from thenar.io.schema import RANGE, ConditionTable, VariableTable
from thenar.model.build import KeyPath
from thenar.model.events import Alphabet
from thenar.model.expressions import TRUE, At, Constant, Expression, Name, Operation, Value, conjunction, leaves
from thenar.model.extended import Condition, ExtendedAutomaton, ExtendedProblem
from thenar.model.scope import Scope, about_specs, name_clashes, written_twice
from thenar.model.variables import MAX_VALUES, Variable

__all__ = ["Meaning", "is_extended"]

MAX_ALL_VALUES = 2_000_000  # of all variables together
MAX_MISTAKES = 100  # in expressions; more of them say nothing new
_AT_ONCE = 3  # unknown names that are told of one expression
_LOOKS = 1_000_000  # at known names for those nearest to unknown ones
_PREDICATES = ("invariant", "needs", "disabled_when")
_HERE = "here"  # where a mistake is, until its path is put there


def is_extended(sources: Iterable[Checked], parts: Iterable[Written]) -> bool:
    """Return whether the files say what a :class:`Problem` cannot."""
    files = [source.file for source in sources]
    return any(f.variables or f.conditions or f.model_fields_set & {"initial", "marked"} for f in files) or any(
        part.is_extended for part in parts
    )


class Meaning:
    """What variables, guards, updates and conditions of ``sources`` mean; complains to the sources of what cannot be.

    ``parts`` are the automata, ``faulty`` those of them with mistakes, ``unknown_event`` says what is wrong with an
    event's name, or None.
    """

    def __init__(
        self,
        sources: Sequence[Checked],
        parts: Mapping[str, Written],
        faulty: set[str],
        known: Alphabet,
        unknown_event: Callable[[str], str | None],
    ) -> None:
        self.parts, self.known = parts, known
        self._characters = self._values = self._told = 0
        self._homes: dict[str, tuple[Checked, KeyPath]] = {}  # of variables
        self.variables: dict[str, Variable] = {}
        self._unsure: set[str] = set()  # variables with mistakes
        for source in sources:
            self._read_variables(source)
        states: dict[str, Mapping[str, None]] = {
            name: (_AnyState if part.complaints else dict)(dict.fromkeys(part.state_names()))
            for name, part in parts.items()
        }
        broken = [path for source in sources for path in source.broken]
        states |= {str(path[1]): _AnyState(states.get(str(path[1]), {})) for path in broken if _hides_states(path)}
        self._unsure |= {str(path[1]) for path in broken if path[0:1] == ("variables",) and len(path) > 1}
        self._unsure -= set(self.variables)
        self._unclear = any(path in ((), ("automata",), ("variables",)) for path in broken)
        self._scope = Scope({name: v.values for name, v in self.variables.items()}, states)
        self._literals = {x for v in self.variables.values() for x in v.values if isinstance(x, str)}
        names = len(self.variables) + len(self._literals) + sum(map(len, states.values()))
        self._most = max(1, min(MAX_MISTAKES, _LOOKS // max(1, names)))
        self.conditions: list[tuple[Checked, int, str, Condition]] = []
        self.predicates: dict[str, Expression] = {}
        actions = {name: dict(self._actions(source, name)) for source in sources for name in source.file.automata}
        for source in sources:
            for k, table in enumerate(source.file.conditions):
                self._read_condition(source, k, table, unknown_event)
        for key in ("initial", "marked"):
            texts = [(s, getattr(s.file, key)) for s in sources if key in s.file.model_fields_set]
            found = [self._truth(s, (key,), text, "it") for s, text in texts]
            self.predicates[key] = found[0] if len(found) == 1 else conjunction(found)
        sound = (name for name in parts if name not in faulty)
        self.automata = {name: parts[name].build(name, known, actions[name]) for name in sound}
        self._check_together()

    def problem(self, name: str, description: str) -> ExtendedProblem:
        """Return the problem; there must be no complaints."""

        def of_kind(kind: str) -> list[ExtendedAutomaton | Condition]:
            automata = [a for n, a in self.automata.items() if self.parts[n].table.kind == kind]
            return [*automata, *(c for _, _, own, c in self.conditions if own == kind)]

        return ExtendedProblem(
            of_kind("plant"),
            of_kind("spec"),
            variables=self.variables.values(),
            initial=self.predicates["initial"],
            marked=self.predicates["marked"],
            name=name,
            alphabet=self.known,
            description=description,
        )

    # -- variables -----------------------------------------------------------------------------------------

    def _read_variables(self, source: Checked) -> None:
        for name, table in source.file.variables.items():
            path: KeyPath = ("variables", name)
            if name in self._homes:
                home = self._homes[name][0].document.source
                source.complain(path, f"already given in {home}; rename one of the two")
                continue
            self._homes[name] = (source, path)
            try:
                self.variables[name] = self._variable(name, table)
            except ModelError as error:
                for mistake in error.mistakes:
                    source.complain(path, mistake.what)
                self._unsure.add(name)
            except InputError as error:
                source.complain((*path, "values"), str(error))
                self._unsure.add(name)

    def _variable(self, name: str, table: VariableTable) -> Variable:
        values = _domain(table.values)
        self._values += len(values)
        if self._values > MAX_ALL_VALUES:
            raise InputError(f"the variables up to here have more than {MAX_ALL_VALUES:,} values")
        chosen = {key: getattr(table, key) for key in ("initial", "marked") if key in table.model_fields_set}
        known = {(type(v), v) for v in values}
        for key, given in chosen.items():  # one that is unknown is enough to be told of: each is compared with all
            listed = given if isinstance(given, list) else [given]
            chosen[key] = next(([v] for v in listed if (type(v), v) not in known), listed)
        return Variable(name, values, **chosen)

    # -- expressions ---------------------------------------------------------------------------------------

    def _actions(self, source: Checked, automaton: str) -> Iterator[tuple[int, Actions]]:
        part = self.parts[automaton]
        if part.table is not source.file.automata[automaton]:  # of another file, which has it too
            return
        for k, table in part.guarded.items():
            path: KeyPath = ("automata", automaton, "transitions", k)
            has_guard = "when" in table.model_fields_set
            guard = self._truth(source, (*path, "when"), table.when, "a guard") if has_guard else TRUE
            updates = [(v, self._new_value(source, (*path, "do", v), v, x)) for v, x in table.do.items()]
            yield k, Actions(guard, tuple(updates))

    def _read_condition(
        self, source: Checked, k: int, table: ConditionTable, unknown_event: Callable[[str], str | None]
    ) -> None:
        path: KeyPath = ("conditions", k)
        given = [key for key in _PREDICATES if key in table.model_fields_set]
        has_event = "event" in table.model_fields_set
        wrong_already = any(broken[:2] == path for broken in source.broken)
        if len(given) > 1:
            source.complain(path, f"both {given[0]} and {given[1]}; make it two conditions")
        elif not given and not wrong_already:
            source.complain(path, "no predicate; write an invariant, or what an event needs or is disabled_when")
        elif not has_event and given != ["invariant"] and not wrong_already:
            source.complain(path, f"no event; say which event {'needs it' if given == ['needs'] else 'it disables'}")
        elif has_event and given == ["invariant"]:
            what = "an invariant is of no event; an event needs something, or is disabled_when something holds"
            source.complain((*path, "event"), what)
        elif has_event and (unknown := unknown_event(table.event)):
            source.complain((*path, "event"), unknown)
        for key in given:
            predicate = self._truth(source, (*path, key), getattr(table, key), "a condition")
            if key == "disabled_when":
                predicate = Operation("not", (predicate,))
            condition = Condition(predicate, table.event if has_event else None, table.name, table.says)
            self.conditions.append((source, k, table.kind, condition))

    def _truth(self, source: Checked, path: KeyPath, text: str, what: str) -> Expression:
        return self._understood(source, path, text, lambda x: self._scope.truth(x, _HERE, what))

    def _new_value(self, source: Checked, path: KeyPath, variable: str, text: Value) -> Expression:
        if variable in self._unsure or self._unclear:
            return self._understood(source, path, text, lambda x: x)
        return self._understood(source, path, text, lambda x: self._scope.new_value(variable, x, _HERE))

    def _understood(
        self, source: Checked, path: KeyPath, text: Value, find_out: Callable[[Expression], Expression]
    ) -> Expression:
        """Read ``text`` and find out what its names mean; complain of what cannot be, to the limit of patience."""
        self._characters += len(text) if isinstance(text, str) else 1
        if self._told >= self._most or self._characters > MAX_TEXT:
            if self._characters > MAX_TEXT and self._told < self._most:
                source.complain(path, f"the expressions up to here have more than {MAX_TEXT:,} characters")
                self._told = self._most
            return TRUE
        before = len(self._scope.mistakes)
        try:
            expression = read(text)
            unknown = [x for x in dict.fromkeys(leaves(expression)) if self._is_unknown(x)]
            if self._unclear or (unknown and self._unsure):  # it may be right, and something else is wrong
                return TRUE
            if unknown:  # a few are told of: each is compared with all names that there are
                expression = Operation("and", tuple(unknown[:_AT_ONCE]))
            result = find_out(expression)
        except InputError as error:
            source.complain(path, str(error))
            self._told += 1
            return TRUE
        for mistake in self._scope.mistakes[before:]:
            source.complain(path, mistake.what)
            self._told += 1
        return result

    def _is_unknown(self, leaf: Constant | Name | At) -> bool:
        states = self._scope.states
        if isinstance(leaf, Constant):
            return isinstance(leaf.value, str) and leaf.value not in self._literals
        if isinstance(leaf, At):
            return leaf.state not in states.get(leaf.automaton, ())
        automaton, _, state = leaf.name.rpartition(".")
        return not (
            leaf.name in self.variables
            or state in states.get(automaton, ())
            or (automaton not in states and leaf.name in self._literals)
        )

    # -- the whole -----------------------------------------------------------------------------------------

    def _check_together(self) -> None:
        """Complain of names that stand for two things, and of who may update a variable or speak of what."""
        for name, (source, path) in self._homes.items():
            if name in self.parts:
                source.complain(path, "an automaton is called so too; rename one of the two")
        automata, variables = list(self.automata.values()), list(self.variables.values())
        homes = {f"variable {name!r}": home for name, home in self._homes.items()}
        for mistake in [*name_clashes(automata, variables, _HERE), *written_twice(automata)]:
            if mistake.where in homes:
                source, path = homes[mistake.where]
                source.complain(path, mistake.what)
        specs = [a for name, a in self.automata.items() if self.parts[name].table.kind == "spec"]
        for source, k, kind, condition in self.conditions:
            if kind == "plant" and condition.event is None:
                for mistake in about_specs([condition], specs):
                    source.complain(("conditions", k, "invariant"), mistake.what)


def _hides_states(path: KeyPath) -> bool:
    """Return whether the mistake at ``path`` leaves open which states an automaton has."""
    return path[:1] == ("automata",) and (len(path) == 2 or path[2:3] in (("initial",), ("states",), ("transitions",)))


def _domain(values: str | list[Value]) -> Sequence[Value]:
    """Return the values that a file lists or describes; raise InputError if that cannot be read."""
    if not isinstance(values, str):
        return values
    if values == "bool":
        return (False, True)
    if not (match := re.fullmatch(RANGE, values)):
        raise InputError(f"cannot read {values[:60]!r} as values; write 'lowest..highest', 'bool' or a list of values")
    lowest, highest = int(match[1]), int(match[2])
    if lowest > highest:
        raise InputError(f"no values: {lowest} is above {highest}; write 'lowest..highest'")
    if highest - lowest >= MAX_VALUES:
        raise InputError(f"more than {MAX_VALUES:,} values")
    return range(lowest, highest + 1)


class _AnyState(dict[str, None]):
    """The states of an automaton with mistakes: whichever name is asked for may be one of them."""

    def __contains__(self, state: object) -> bool:
        return True

"""From a problem to a CIF 3 model: declarations, one automaton after the other, then what holds besides."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from thenar.errors import InputError
from thenar.io.cif.formulas import Formulas, inside
from thenar.io.foreign.written import ProblemNames, Written
from thenar.model.expressions import FALSE, TRUE, Constant, Expression, Name, Operation, Value, conjunction
from thenar.model.extended import Condition, ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem
from thenar.model.variables import Variable

__all__ = ["dumps"]

_KEYWORDS = frozenset([
    "abs", "acos", "acosh", "alg", "alphabet", "and", "any", "asin", "asinh", "atan", "atanh", "attr",
    "automaton", "bernoulli", "beta", "binomial", "bool", "break", "case", "cbrt", "ceil", "const", "constant",
    "cont", "continue", "controllable", "cos", "cosh", "def", "del", "der", "dict", "disables", "disc", "dist",
    "div", "do", "edge", "elif", "else", "empty", "end", "enum", "equation", "erlang", "event", "exp",
    "exponential", "external", "false", "file", "final", "floor", "fmt", "for", "func", "gamma", "geometric",
    "goto", "group", "if", "import", "in", "initial", "input", "int", "invariant", "list", "ln", "location",
    "log", "lognormal", "marked", "max", "min", "mod", "monitor", "namespace", "needs", "noinst", "normal",
    "not", "now", "or", "plant", "poisson", "pop", "post", "pow", "pre", "print", "printfile", "random", "real",
    "requirement", "return", "round", "sample", "scale", "self", "set", "sign", "sin", "sinh", "size", "sqrt",
    "string", "sub", "supervisor", "svgcopy", "svgfile", "svgin", "svgmove", "svgout", "switch", "tan", "tanh",
    "tau", "text", "time", "to", "triangle", "true", "tuple", "type", "uncontrollable", "uniform", "urgent",
    "value", "void", "weibull", "when", "while",
])  # fmt: skip
_ROWS = 4_096  # edges that are made text at a time


def dumps(problem: Problem | ExtendedProblem) -> Written:
    """Write ``problem`` as a CIF model: events, enumerations, plants, requirements, conditions, in this order.

    A variable stands in the automaton that updates it (in the first plant if none does).  An update that could
    leave the variable's range gets a guard that keeps it inside, as CIF takes a value out of range for an error.
    Names that CIF does not have (other characters than letters, digits and _; its own words; several dots) are
    changed, and what they were is in the table of names, with what else CIF cannot say: texts, observable, forcible.
    ``//`` and ``%`` round down, CIF's ``div`` and ``mod`` towards zero; where it matters, that is written out.

    Enumerations that share a value are one in CIF, as they may be compared.

    Raises InputError for an automaton without states, and a variable whose values are whole numbers with gaps.

    >>> from thenar.model.automaton import Automaton
    >>> lamp = Automaton.from_transitions(["off -on-> lit -off!-> off"], initial="off", marked=["off"], name="LAMP")
    >>> print("".join(dumps(Problem(lamp)).chunks), end="")
    controllable on;
    controllable off_;
    plant automaton LAMP:
      location off: initial; marked;
        edge on goto lit;
      location lit:
        edge off_ goto off;
    end
    """
    return _Writer(ExtendedProblem.of(problem)).written()


class _Writer:
    """The model, and how CIF calls what is in it."""

    def __init__(self, problem: ExtendedProblem) -> None:
        self.problem = problem
        for automaton in problem.automata:
            if not automaton.states:
                raise InputError(f"automaton {automaton.name!r} has no states; CIF needs an initial location")
        taken: set[str] = set()
        self.events = {e: _free(e, taken) for e in problem.alphabet.names}
        self.automata = {a.name: _free(a.name or "automaton", taken) for a in problem.automata}
        self.owner = self._owners()
        self.enums: dict[tuple[str, ...], str] = {}
        self.literals: dict[Value, str] = {}
        for values in _enumerations(problem.variables):
            self.enums[values] = _free("values", taken)
            self.literals |= {v: _free(str(v), taken) for v in values}
        self.states: dict[str, dict[str, str]] = {}
        self.variables: dict[str, str] = {}
        for automaton in problem.automata:
            inner = set(taken)
            # the only location needs no name, and then has none
            lone = automaton.states == ("*",)
            self.states[automaton.name] = {"*": "*"} if lone else {s: _free(s, inner) for s in automaton.states}
            for name, owner in self.owner.items():
                if owner == automaton.name:
                    local = name.removeprefix(f"{automaton.name}.")
                    self.variables[name] = f"{self.automata[owner]}.{_free(local, inner)}"
        self.say = Formulas(self.variables, self._at, self.literals, {v.name: v.values for v in problem.variables})

    def _owners(self) -> dict[str, str]:
        """Return the automaton in which each variable stands."""
        writers = {v: a.name for a in self.problem.automata for e in a.edges for v, _ in e.updates}
        return {v.name: writers.get(v.name, self.problem.plants[0].name) for v in self.problem.variables}

    def _at(self, automaton: str, state: str) -> str:
        label = self.states[automaton][state]
        return "true" if label == "*" else f"{self.automata[automaton]}.{label}"

    def written(self) -> Written:
        """Return the text, and what it calls otherwise."""
        p = self.problem
        conditions = [("plant", c) for c in p.plant_conditions] + [("requirement", c) for c in p.spec_conditions]
        ends = [("initial", p.initial), *(("marked", wanted) for wanted in [p.marked, *map(_marked, p.variables)])]
        tail = [self._condition(kind, c) for kind, c in conditions]
        tail += [f"{word} {self.say(wanted)};\n" for word, wanted in ends if wanted != TRUE]
        automata = [("plant", a) for a in p.plants] + [("requirement", a) for a in p.specs]
        heads = [self._head(kind, a) for kind, a in automata]  # before anything is written, mistakes are found

        def chunks() -> Iterator[str]:
            yield "".join(self._declarations())
            for head, (_, automaton) in zip(heads, automata, strict=True):
                yield head
                yield from self._locations(automaton)
                yield "end\n"
            yield "".join(tail)

        return Written(chunks(), self._names(), ())

    def _declarations(self) -> Iterator[str]:
        for event in self.problem.alphabet:
            yield f"{'' if event.controllable else 'un'}controllable {self.events[event.name]};\n"
        for values, name in self.enums.items():
            yield f"enum {name} = {', '.join(self.literals[v] for v in values)};\n"

    def _head(self, kind: str, automaton: ExtendedAutomaton) -> str:
        lines = [f"{kind} automaton {self.automata[automaton.name]}:\n"]
        carried = {edge.event for edge in automaton.edges}
        if len(carried) < len(automaton.alphabet):  # what it has and never does, it blocks
            lines.append(f"  alphabet {', '.join(self.events[e] for e in automaton.alphabet.names)};\n")
        for variable in self.problem.variables:
            if self.owner[variable.name] == automaton.name:
                lines.append(f"  disc {self._type(variable)} {self._declared(variable)};\n")
        return "".join(lines)

    def _type(self, variable: Variable) -> str:
        values = variable.values
        if isinstance(values[0], str):
            return next(name for enum, name in self.enums.items() if values[0] in enum)
        if isinstance(values[0], bool):
            return "bool"
        low, high = min(values), max(values)
        if len(values) <= int(high) - int(low):
            raise InputError(f"variable {variable.name!r} has whole numbers with gaps as values; CIF has ranges only")
        return f"int[{low}..{high}]"

    def _declared(self, variable: Variable) -> str:
        name = self.variables[variable.name].rpartition(".")[2]
        first = [self.say(Constant(v)) for v in variable.initial]
        if len(first) == 1:
            return f"{name} = {first[0]}"
        return f"{name} in {{{', '.join(first)}}}"

    def _locations(self, automaton: ExtendedAutomaton) -> Iterator[str]:
        names = self.states[automaton.name]
        rows: list[list[int]] = [[] for _ in automaton.states]
        for k, edge in enumerate(automaton.edges):
            rows[edge.source].append(k)
        lines: list[str] = []
        words = ("initial", "marked")
        for q, state in enumerate(automaton.states):
            flags = [w for w, is_so in zip(words, (automaton.initial[q], automaton.marked[q]), strict=True) if is_so]
            called = "location" if names[state] == "*" else f"location {names[state]}"
            begin = " ".join([f"{called}:", *(f"{word};" for word in flags)])
            lines.append(f"  {begin}\n" if flags or rows[q] else f"  {called};\n")
            lines += [self._edge(automaton, k) for k in rows[q]]
            if len(lines) > _ROWS:
                yield "".join(lines)
                lines = []
        yield "".join(lines)

    def _edge(self, automaton: ExtendedAutomaton, k: int) -> str:
        edge = automaton.edges[k]
        words = [f"    edge {self.events[automaton.alphabet[edge.event].name]}"]
        guard = conjunction([edge.guard, *(self._inside(v, x) for v, x in edge.updates)])
        if guard != TRUE:
            words.append(f"when {self.say(guard)}")
        if edge.updates:
            done = (f"{self.variables[v].rpartition('.')[2]} := {self.say(x)}" for v, x in edge.updates)
            words.append(f"do {', '.join(done)}")
        if edge.target != edge.source:
            words.append(f"goto {self.states[automaton.name][automaton.states[edge.target]]}")
        return " ".join(words) + ";\n"

    def _inside(self, variable: str, value: Expression) -> Expression:
        """Return the condition that ``value`` is one of those of ``variable``."""
        return inside(value, self.say.values[variable], self.say.values)

    def _condition(self, kind: str, condition: Condition) -> str:
        text = self.say(condition.predicate)
        if condition.event is None:
            return f"{kind} invariant {text};\n"
        return f"{kind} {self.events[condition.event]} needs {text};\n"

    def _names(self) -> ProblemNames | None:
        p = self.problem
        automata = tuple(
            (self.automata[a.name], a.name, a.meaning, tuple((label, s) for s, label in self.states[a.name].items()))
            for a in p.automata
        )
        names = ProblemNames(
            p.name,
            p.description,
            tuple((self.events[e.name], e) for e in p.alphabet),
            automata,
            tuple((label, name) for name, label in self.variables.items()),
            tuple((label, str(value)) for value, label in self.literals.items()),
        )
        return None if names.says_nothing() else names


def _enumerations(variables: Iterable[Variable]) -> list[tuple[str, ...]]:
    """Return the enumerations of which the variables have literals; what shares one is joined."""
    found: list[dict[str, None]] = []
    for variable in variables:
        new = dict.fromkeys(v for v in variable.values if isinstance(v, str))
        for other in [enum for enum in found if enum.keys() & new.keys()]:
            found.remove(other)
            new = other | new
        found += [new] if new else []
    return [tuple(enum) for enum in found]


def _free(wanted: str, taken: set[str]) -> str:
    """Return a name near to ``wanted`` that CIF has and nothing else is called; it is taken then."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", wanted)
    plain = f"{plain}_" if plain in _KEYWORDS else plain
    plain = plain if plain and not plain[0].isdigit() else f"_{plain}"
    name, k = plain, 2
    while name in taken:
        name, k = f"{plain}_{k}", k + 1
    taken.add(name)
    return name


def _marked(variable: Variable) -> Expression:
    """Return the condition that ``variable`` has a marked value."""
    if variable.marked == variable.values:
        return TRUE
    chosen = [Operation("==", (Name(variable.name), Constant(v))) for v in variable.marked]
    if not chosen:
        return FALSE
    return chosen[0] if len(chosen) == 1 else Operation("or", tuple(chosen))

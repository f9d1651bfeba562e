"""The control problem: what the plant can do, and what it may do."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from thenar.errors import Mistake, ModelError, UnknownName, counted
from thenar.model.automaton import Automaton
from thenar.model.display import Displayable
from thenar.model.events import Alphabet, merge

__all__ = ["Problem", "compose"]


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class Problem(Displayable):
    """Find the largest controllable, nonblocking part of what ``plants`` can do and ``specs`` allow.

    The plant is the synchronous product of ``plants``; the legal behaviour is that of the synchronous
    product of ``plants`` and ``specs``: an event outside a specification's alphabet is always allowed by it, and
    one outside all plants' alphabets is hindered by none of them.  An event that no automaton has never happens.
    ``alphabet`` orders the events, and so numbers the states; by default, in order of first mention.

    Raises ModelError for no plant or two automata of one name, AlphabetClash for an event with two meanings.

    >>> from thenar.library.classics import small_factory
    >>> small_factory()
    Problem 'small_factory(2)': 2 plants, 1 spec, 8 events (4 uncontrollable)
    """

    name: str
    plants: tuple[Automaton, ...]
    specs: tuple[Automaton, ...]
    alphabet: Alphabet
    description: str

    def __init__(
        self,
        plants: Automaton | Iterable[Automaton],
        specs: Automaton | Iterable[Automaton] = (),
        *,
        name: str = "",
        alphabet: Alphabet | None = None,
        description: str = "",
    ) -> None:
        plants = (plants,) if isinstance(plants, Automaton) else tuple(plants)
        specs = (specs,) if isinstance(specs, Automaton) else tuple(specs)
        automata = (*plants, *specs)
        where = f"problem {name!r}" if name else "problem"
        mistakes = (
            []
            if plants
            else [Mistake(where, "no plant; a problem needs at least one automaton that says what can happen")]
        )
        counts = Counter(a.name for a in automata if a.name)
        mistakes += [Mistake(where, f"two automata are called {n!r}") for n, count in counts.items() if count > 1]
        merged = merge([a.alphabet for a in automata], [a.name or "an automaton without a name" for a in automata])
        if alphabet is not None:
            merge([alphabet, merged], ["the problem's alphabet", "its automata"])
            mistakes += [
                Mistake(where, f"event {e!r} is not in the problem's alphabet")
                for e in merged.names
                if e not in alphabet
            ]
        if mistakes:
            raise ModelError(mistakes)
        for field, value in (
            ("name", name),
            ("plants", plants),
            ("specs", specs),
            ("alphabet", merged if alphabet is None else alphabet),
            ("description", description),
        ):
            object.__setattr__(self, field, value)

    @property
    def automata(self) -> tuple[Automaton, ...]:
        """The plants, then the specifications."""
        return self.plants + self.specs

    def automaton(self, name: str) -> Automaton:
        """Return the plant or specification called ``name``."""
        for a in self.automata:
            if a.name == name:
                return a
        raise UnknownName("automaton", name, [a.name for a in self.automata], self.name)

    def __repr__(self) -> str:
        title = f"Problem {self.name!r}" if self.name else "Problem"
        free = int(self.alphabet.uncontrollable.sum())
        parts = f"{counted(len(self.plants), 'plant')}, {counted(len(self.specs), 'spec')}"
        return f"{title}: {parts}, {counted(len(self.alphabet), 'event')} ({free} uncontrollable)"


def compose(problems: Sequence[Problem]) -> Problem:
    """Return one problem of all plants and specifications of ``problems``, alphabets and texts joined in order.

    Raises AlphabetClash for an event with two meanings, ModelError for two automata of one name.

    >>> from thenar.library.classics import chain, dining
    >>> compose([chain(2), dining(3)])
    Problem 'chain(2) + dining(3)': 5 plants, 4 specs, 13 events (5 uncontrollable)
    """
    if len(problems) == 1:
        return problems[0]
    return Problem(
        [a for p in problems for a in p.plants],
        [a for p in problems for a in p.specs],
        name=" + ".join(p.name for p in problems if p.name),
        alphabet=merge([p.alphabet for p in problems], [p.name or "a problem without a name" for p in problems]),
        description="\n".join(p.description for p in problems if p.description),
    )

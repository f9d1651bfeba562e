"""Variables that several components update: what is read does what the components do together, by definition."""

from __future__ import annotations

from random import Random

import pytest

from thenar import ExtendedProblem, synthesize
from thenar.errors import InputError
from thenar.io.foreign import waters
from thenar.testing import extended_oracle
from thenar.testing.waters_oracle import Component, Edge, Joint, explore

EVENTS = ("a", "b", "u")
UNCONTROLLABLE = ("u",)
ACTIONS: list[tuple[str, int | str]] = [("=", 0), ("=", 1), ("+=", 1), ("-=", 1), ("=", "y")]


def simple(name: str) -> str:
    return f'<SimpleIdentifier Name="{name}"/>'


def term(value: int | str) -> str:
    return simple(value) if isinstance(value, str) else f'<IntConstant Value="{value}"/>'


def binary(operator: str, left: str, right: str) -> str:
    quoted = operator.replace("<", "&lt;").replace(">", "&gt;")
    return f'<BinaryExpression Operator="{quoted}">{left}{right}</BinaryExpression>'


def xml(components: list[Component], ranges: dict[str, range], start: dict[str, int]) -> bytes:
    """Return the module of the components."""
    kinds = {e: "UNCONTROLLABLE" if e in UNCONTROLLABLE else "CONTROLLABLE" for e in EVENTS}
    parts = [f'<EventDecl Kind="{kind}" Name="{e}"/>' for e, kind in kinds.items()]
    parts = ["<Module><EventDeclList>", *parts, "</EventDeclList><ComponentList>"]
    for v, values in ranges.items():
        domain = binary("..", term(values[0]), term(values[-1]))
        first = binary("==", term(v), term(start[v]))
        parts.append(f'<VariableComponent Name="{v}"><VariableRange>{domain}</VariableRange>')
        parts.append(f"<VariableInitial>{first}</VariableInitial></VariableComponent>")
    for c in components:
        nodes = dict.fromkeys([c.initial, *(q for e in c.edges for q in (e.source, e.target))])
        parts.append(f'<SimpleComponent Kind="{"PLANT" if c.is_plant else "SPEC"}" Name="{c.name}"><Graph><NodeList>')
        parts += [f'<SimpleNode Name="{q}" Initial="{str(q == c.initial).lower()}"/>' for q in nodes]
        parts.append("</NodeList><EdgeList>")
        for e in c.edges:
            guard = f"<Guards>{binary(e.guard[1], term(e.guard[0]), term(e.guard[2]))}</Guards>" if e.guard else ""
            actions = "".join(binary(operator, term(v), term(new)) for v, operator, new in e.updates)
            block = f"<GuardActionBlock>{guard}<Actions>{actions}</Actions></GuardActionBlock>"
            parts.append(f'<Edge Source="{e.source}" Target="{e.target}"><LabelBlock>{simple(e.event)}</LabelBlock>')
            parts.append(f"{block}</Edge>")
        parts.append("</EdgeList></Graph></SimpleComponent>")
    return "".join([*parts, "</ComponentList></Module>"]).encode()


def drawn(rng: Random) -> tuple[list[Component], dict[str, range], dict[str, int]]:
    """Draw components that know what to do: by an event one edge, or two with guards of which one is true."""
    ranges = {"x": range(rng.randint(-1, 0), 3), "y": range(2)}
    components = []
    for k in range(rng.randint(2, 3)):
        edges = []
        nodes = ["p", "q"][: rng.randint(1, 2)]
        for node in nodes:
            for event in EVENTS:
                if rng.random() < 0.4:
                    continue
                bound = rng.randint(0, 2)
                guards = [None] if rng.random() < 0.6 else [("x", "<", bound), ("x", ">=", bound)]
                for guard in guards:
                    updates: list[tuple[str, str, int | str]] = [
                        (v, *rng.choice(ACTIONS)) for v in ranges if rng.random() < 0.5
                    ]
                    edges.append(Edge(node, event, rng.choice(nodes), guard, tuple(updates)))
        components.append(Component(f"C{k}", k == 0 or rng.random() < 0.5, nodes[0], tuple(edges)))
    return components, ranges, {"x": 0, "y": 0}


def joint(problem: ExtendedProblem, components: list[Component], variables: list[str]) -> Joint:
    """Return what the problem does, seen by the components and variables of the file."""
    system = extended_oracle.explore(problem)
    names = [a.name for a in problem.automata] + [v.name for v in problem.variables]
    order = [names.index(n) for n in [*(c.name for c in components), *variables]]

    def seen(x: tuple[str | int, ...]) -> tuple[str | int, ...]:
        return tuple(x[k] for k in order)

    moves = {(seen(x), e, seen(y)) for x, row in system.step.items() for e, ys in row.items() for y in ys}
    (initial,) = system.initial
    states = frozenset(map(seen, system.states))
    return Joint(seen(initial), states, frozenset(moves), frozenset(map(seen, system.illegal)))


def test_components_that_update_a_variable_agree_or_stay() -> None:
    shared = 0
    for seed in range(1000):
        components, ranges, start = drawn(Random(seed))
        problem = ExtendedProblem.of(waters.loads(xml(components, ranges, start), "m.wmod"))
        shared += len(problem.automata) > len(components)
        assert joint(problem, components, list(ranges)) == explore(components, ranges, start, UNCONTROLLABLE), seed
        if seed % 20 == 0:
            assert synthesize(problem, "explicit").size == synthesize(problem, "symbolic").size, seed
    assert shared > 700


def test_a_choice_beside_another_component_is_refused() -> None:
    chooses = Component("A", True, "p", (Edge("p", "a", "p", None, (("x", "=", 0),)), Edge("p", "a", "p")))
    other = Component("B", True, "p", (Edge("p", "b", "p", None, (("x", "=", 1),)),))
    with pytest.raises(InputError, match="may choose here what it becomes"):
        waters.loads(xml([chooses, other], {"x": range(2)}, {"x": 0}), "m.wmod")

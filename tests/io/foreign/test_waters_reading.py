"""The language of Waters modules, construct by construct."""

from __future__ import annotations

import pytest
from tests.io.foreign.wmod import (
    ACCEPTING,
    LOOP,
    NEXT,
    ONE,
    X,
    between,
    binary,
    call,
    component,
    constant,
    edge,
    foreach,
    group,
    indexed,
    loads,
    module,
    moves,
    name,
    node,
    number,
    run,
    unary,
    variable,
)

from thenar import ExtendedProblem, Problem, synthesize
from thenar.errors import ModelError
from thenar.io.foreign import waters

# -- marking, kinds, alphabets -------------------------------------------------------------------------------


def test_a_component_without_accepting_nodes_marks_all() -> None:
    some = component("S", ONE + node("q", ":accepting"))
    none = component("N", ONE + node("q"))
    blocked = component("B", ONE + node("q"), blocked=name(":accepting"))
    problem = loads(some, none, blocked)
    assert [list(a.marked) for a in problem.automata] == [[False, True], [True, True], [False, False]]


def test_another_proposition_marks_if_it_is_the_only_one() -> None:
    events = '<EventDecl Kind="PROPOSITION" Name="omega"/>'
    text = module(component("S", ONE + node("q", "omega")), events=events).decode().replace(ACCEPTING, "")
    assert list(waters.loads(text.encode(), "m.wmod").automata[0].marked) == [False, True]
    both = loads(component("S", ONE + node("q", "omega")), events=events)
    assert list(both.automata[0].marked) == [True, True]
    assert both.description == "Not read: the proposition 'omega'; states are marked by ':accepting'."


def test_kinds() -> None:
    kinds = ("PLANT", "SPEC", "SUPERVISOR", "PROPERTY")
    problem = loads(*(component(k, ONE, kind=k) for k in kinds))
    assert [a.name for a in problem.plants] == ["PLANT"]
    assert [a.name for a in problem.specs] == ["SPEC", "SUPERVISOR"]
    assert problem.description == "Not read: property 'PROPERTY', a question about the system."


def test_blocked_events_and_edges_that_are_never_possible_are_in_the_alphabet() -> None:
    never = edge("p", "p", name("u"), number(0))
    problem = loads(component("A", ONE, edge("p", "p", name("a"))), component("B", ONE, never, blocked=name("a")))
    assert isinstance(problem, Problem)
    assert problem.plants[1].alphabet.names == ("a", "u")
    assert problem.plants[1].n_transitions == 0


def test_forbidden_nodes_of_a_plain_problem() -> None:
    drawn = ONE + node("q", ":forbidden"), edge("p", "q", name("a")) + edge("p", "p", name("u"))
    problem = loads(component("A", *drawn), component("B", *drawn, kind="SPEC"))
    assert isinstance(problem, Problem)
    assert [(a.name, a.n_states) for a in problem.specs] == [("B", 1), ("A without forbidden states", 1)]
    assert synthesize(problem).size.states == 1


def test_forbidden_nodes_and_values_of_an_extended_problem() -> None:
    counter = variable("n", between(0, 3), binary("==", name("n"), number(0)))
    marking = f"<VariableMarking>{name(':forbidden')}{binary('==', name('n'), number(2))}</VariableMarking>"
    counter = counter.replace("</VariableComponent>", f"{marking}</VariableComponent>")
    drawn = component(
        "A", ONE + node("q", ":forbidden"), edge("p", "p", name("a"), "", binary("+=", name("n"), number(1)))
    )
    problem = loads(counter, drawn)
    assert isinstance(problem, ExtendedProblem)
    assert [str(c) for c in problem.spec_conditions] == ["not n == 2", "not A.q"]
    for engine in ("explicit", "symbolic"):
        assert synthesize(problem, engine).size.states == 2


# -- constants, loops, arrays --------------------------------------------------------------------------------


def test_arrays_loops_and_constants_are_unfolded() -> None:
    before = f"<ConstantAliasList>{constant('M', binary('+', name('K'), number(1)))}{constant('K', number(1))}"
    before += f"{constant('ROBOTS', between(1, name('M')))}</ConstantAliasList>"
    events = (
        f'<EventDecl Kind="CONTROLLABLE" Name="go"><RangeList>{name("ROBOTS")}{between(0, 1)}</RangeList></EventDecl>'
    )
    aliases = f'<EventAliasList><EventAlias Name="all"><EventAliasExpression><PlainEventList>{name("go")}'
    aliases += "</PlainEventList></EventAliasExpression></EventAlias>"
    each = f"<EventAlias>{indexed('of', name('i'))}<EventAliasExpression>{indexed('go', name('i'))}"
    each += "</EventAliasExpression></EventAlias>"
    aliases += foreach("ForeachEventAlias", "i", name("ROBOTS"), each) + "</EventAliasList>"
    robot = component(
        indexed("R", name("i")),
        ONE + node("q"),
        edge("p", "q", indexed("go", name("i"), number(0)))
        + edge("q", "p", foreach("ForeachEvent", "k", between(0, 1), indexed("go", name("i"), name("k"))))
        + edge("q", "q", indexed("of", name("i"))),
    )
    robots = foreach("ForeachComponent", "i", name("ROBOTS"), f"<ComponentList>{robot}</ComponentList>")
    problem = loads(
        robots, component("A", ONE, edge("p", "p", name("all"))), before=before, events=events, aliases=aliases
    )
    assert [a.name for a in problem.automata] == ["R[1]", "R[2]", "A"]
    assert problem.alphabet.names == ("go[1][0]", "go[1][1]", "go[2][0]", "go[2][1]")
    assert problem.automata[2].alphabet.names == problem.alphabet.names
    edges = ExtendedProblem.of(problem).automata[1].edges
    assert sorted((e.source, e.event, e.target) for e in edges) == [
        (0, 0, 1),
        (1, 0, 0),
        (1, 0, 1),
        (1, 1, 0),
        (1, 1, 1),
    ]


def test_a_loop_with_a_condition() -> None:
    inner = (
        f"<Guard>{binary('!=', name('i'), number(2))}</Guard><ComponentList>{component(indexed('A', name('i')), ONE)}"
    )
    problem = loads(foreach("ForeachComponent", "i", between(1, 3), f"{inner}</ComponentList>"))
    assert [a.name for a in problem.automata] == ["A[1]", "A[3]"]


def test_arrays_over_atoms() -> None:
    colours = f"<EnumSetExpression>{name('red')}{name('green')}</EnumSetExpression>"
    events = f'<EventDecl Kind="UNCONTROLLABLE" Name="see"><RangeList>{colours}</RangeList></EventDecl>'
    problem = loads(component("A", ONE, edge("p", "p", indexed("see", name("red")))), events=events)
    assert problem.alphabet.names == ("see[red]", "see[green]")


# -- groups of nodes -----------------------------------------------------------------------------------------


def test_an_edge_of_a_group_is_one_of_each_node_unless_the_node_has_its_own() -> None:
    nodes = ONE + node("q") + node("r") + node("s") + group("G", "p", "H") + group("H", "q", "r")
    edges = (
        edge("G", "s", name("a")) + edge("H", "p", name("a")) + edge("r", "r", name("a")) + edge("G", "G", name("u"))
    )
    problem = loads(component("A", nodes, edges))
    assert isinstance(problem, Problem)
    assert set(problem.plants[0].transitions()) == {
        ("p", "a", "s"), ("q", "a", "p"), ("r", "a", "r"), ("p", "u", "p"), ("q", "u", "q"), ("r", "u", "r")
    }  # fmt: skip


def test_groups_that_are_not_read() -> None:
    with pytest.raises(ModelError, match="an edge that leads into group 'G'; let it lead to one of its nodes"):
        loads(component("A", ONE + group("G", "p"), edge("p", "G", name("a"))))
    guarded = edge("G", "p", name("a"), binary("==", name("n"), number(0))) + edge("p", "p", name("a"))
    with pytest.raises(ModelError, match="an edge of group 'G' and one within it have guards for the same event 'a'"):
        loads(component("A", ONE + group("G", "p"), guarded), variable("n", between(0, 1)))
    with pytest.raises(ModelError, match="group 'G' has an unknown node 'z'"):
        loads(component("A", ONE + group("G", "z")))


# -- guards and actions --------------------------------------------------------------------------------------


def test_actions() -> None:
    assert run("", binary("+=", name("x"), number(1))) == {(0, 1), (1, 2), (2, 3)}
    assert run("", binary("=", name("x"), binary("-", number(3), name("x")))) == {(0, 3), (3, 0)}
    assert run("", binary("=", name("x"), number(7))) == set()
    assert run("", binary("=", name("x"), unary("!", binary("==", name("x"), number(1))))) == {(0, 1), (1, 0)}
    twice = [binary("=", name("x"), number(1)), binary("=", name("x"), binary("-", number(2), name("x")))]
    assert run("", *twice) == set()  # at 0 the two do not agree


def test_actions_of_an_edge_read_the_values_before() -> None:
    y = variable("y", between(0, 3), binary("==", name("y"), number(2)))
    swap = [binary("=", name("x"), name("y")), binary("=", name("y"), name("x"))]
    problem = loads(X, y, component("A", ONE, edge("p", "p", name("a"), "", *swap)))
    assert moves(problem) == {((0, 2), "a", (2, 0)), ((2, 0), "a", (0, 2))}


def test_next_values_in_guards() -> None:
    assert run(binary("==", NEXT, binary("+", name("x"), number(1)))) == {(0, 1), (1, 2), (2, 3)}
    assert run(binary("==", number(2), NEXT)) == {(0, 2), (2, 2)}
    assert run(binary("<", name("x"), NEXT)) == {(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)}
    either = binary("|", binary("&", binary("==", name("x"), number(0)), binary("==", NEXT, number(3))),
                    binary("&", binary("==", name("x"), number(3)), binary("==", NEXT, number(0))))  # fmt: skip
    assert run(either) == {(0, 3), (3, 0)}
    with_action = binary("&", binary(">", NEXT, number(1)), binary("<", name("x"), number(3)))
    assert run(with_action, binary("=", name("x"), number(2))) == {(0, 2), (2, 2)}
    with pytest.raises(ModelError, match="the next value x' can be asked for in guards only"):
        run("", binary("=", name("x"), NEXT))


def test_a_relation_that_leaves_too_many_values_open_is_refused() -> None:
    wide = variable("y", between(0, 20000), binary("==", name("y"), number(0)))
    with pytest.raises(ModelError, match="the guard leaves y' more than 10,000 values; write an action"):
        run(binary("<", name("y"), unary("'", name("y"))), others=wide)


@pytest.mark.parametrize(
    ("guard", "true_for"),
    [
        (binary("&", binary(">=", name("x"), number(1)), unary("!", binary("==", name("x"), number(2)))), {1, 3}),
        (binary("!=", binary("%", name("x"), number(2)), number(0)), {1, 3}),
        (binary("==", binary("/", binary("-", name("x"), number(3)), number(2)), number(-1)), {0, 1}),  # towards zero
        (binary("==", binary("%", binary("-", name("x"), number(3)), number(2)), number(-1)), {0, 2}),
        (binary("==", unary("-", name("x")), binary("*", name("x"), number(-1))), {0, 1, 2, 3}),
        (binary(">", call(r"\max", name("x"), number(2)), number(2)), {3}),
        (binary("==", call(r"\min", name("x"), number(2)), number(2)), {2, 3}),
        (call(r"\ite", binary("<", name("x"), number(2)), number(0), binary("==", name("x"), number(3))), {3}),
        (binary("==", binary("<", name("x"), number(2)), binary(">", name("x"), number(0))), {1}),
        (binary("|", *[number(0)] * 2), set()),
        (binary("==", binary("/", number(6), binary("+", name("x"), number(1))), number(3)), {1}),
        (binary("==", name("A"), name("p")), {0, 1, 2, 3}),
        (binary("!=", name("p"), name("A")), set()),
    ],
)
def test_expressions(guard: str, true_for: set[int]) -> None:
    anything = binary(">=", NEXT, number(0))  # x takes any value, wherever the guard is true
    free = variable("x", between(0, 3), number(1))
    problem = loads(free, component("A", ONE, edge("p", "p", name("a"), binary("&", guard, anything))))
    assert {x[0] for x, _, _ in moves(problem)} == true_for  # type: ignore[index]


def test_a_long_conjunction_is_not_too_deep() -> None:
    guard = binary("==", name("x"), number(0))
    for k in range(200):
        guard = binary("&", guard, binary("!=", name("x"), number(4 + k)))
    assert run(guard) == {(0, 0)}


def test_a_division_that_may_be_by_zero_is_refused() -> None:
    with pytest.raises(ModelError, match="a division by x, which may be 0"):
        run(binary("==", binary("/", number(1), name("x")), number(1)))


def test_enumerations() -> None:
    domain = f"<EnumSetExpression>{name('red')}{name('green')}</EnumSetExpression>"
    more = f"<EnumSetExpression>{name('green')}{name('blue')}</EnumSetExpression>"
    lamp = variable("lamp", domain, binary("==", name("lamp"), name("green")), binary("!=", name("lamp"), name("red")))
    other = variable("other", more, binary("==", name("other"), name("green")))
    guard = binary("&", binary("==", name("lamp"), name("other")), binary("!=", name("lamp"), name("blue")))
    drawn = component("A", ONE, edge("p", "p", name("a"), guard, binary("=", name("lamp"), name("red"))))
    problem = ExtendedProblem.of(loads(lamp, other, drawn))
    assert problem.variables[0].initial == problem.variables[0].marked == ("green",)
    assert moves(problem) == {(("green", "green"), "a", ("red", "green"))}
    copied = component("A", ONE, edge("p", "p", name("a"), "", binary("=", name("lamp"), name("other"))))
    free = variable("other", more, number(1))
    assert moves(loads(lamp, free, copied)) == {(("green", "green"), "a", ("green", "green"))}


def test_names_of_variables_are_made_writable() -> None:
    i = constant("i", number(1))
    arrays = variable("v", between(0, 1)).replace(' Name="v">', f">{indexed('v', number(1))}")
    guard = binary("&", binary("==", indexed("v", name("i")), number(0)), binary("==", name("buf:in"), number(0)))
    drawn = component("buf", ONE, edge("p", "p", name("a"), guard))
    clash = component("v_1", ONE)
    before = f"<ConstantAliasList>{i}</ConstantAliasList>"
    problem = loads(arrays, variable("buf:in", between(0, 1)), drawn, clash, before=before)
    assert isinstance(problem, ExtendedProblem)
    assert [v.name for v in problem.variables] == ["v_1_", "buf.in_"]


def test_predicates_about_several_variables_are_those_of_the_problem() -> None:
    both = binary("==", name("y"), name("x"))
    problem = loads(variable("x", between(0, 2)), variable("y", between(0, 2), both, both), LOOP)
    assert isinstance(problem, ExtendedProblem)
    assert (str(problem.initial), str(problem.marked)) == ("y == x", "y == x")

"""CIF models, construct by construct: small texts, and exactly what they become."""

from __future__ import annotations

import pytest

from thenar.io import cif
from thenar.model.extended import Edge, ExtendedAutomaton, ExtendedProblem
from thenar.testing.extended_oracle import supcon


def guards(problem: ExtendedProblem, name: str | None = None) -> list[str]:
    """Return the edges of an automaton (of the first plant without a name), written down."""
    a = problem.plants[0] if name is None else problem.automaton(name)
    return [arrow(a, edge) for edge in a.edges]


def arrow(a: ExtendedAutomaton, edge: Edge) -> str:
    guard = "" if str(edge.guard) == "true" else f" when {edge.guard}"
    updates = "".join(f" {v} := {x}" for v, x in edge.updates)
    return f"{a.states[edge.source]} -{a.alphabet[edge.event].name}-> {a.states[edge.target]}{guard}{updates}"


def conditions(problem: ExtendedProblem) -> tuple[list[str], list[str]]:
    return [str(c) for c in problem.plant_conditions], [str(c) for c in problem.spec_conditions]


def one_location(declarations: str, edges: str, before: str = "controllable c; uncontrollable u;") -> ExtendedProblem:
    return cif.loads(f"{before} plant p: {declarations} location: initial; marked; {edges} end")


def guard(expression: str, declarations: str = "disc int[-9..9] n; disc int[0..9] m; disc bool b;") -> str:
    """Return what a guard becomes."""
    return str(one_location(declarations, f"edge c when {expression};").plants[0].edges[0].guard)


# -- automata -------------------------------------------------------------------------------------------------


def test_an_automaton_keeps_its_locations_events_and_edges() -> None:
    problem = cif.loads(
        """
        // a lamp
        plant automaton lamp:
          controllable event c_on, c_off;
          uncontrollable u_break;
          location Off: initial; marked; edge c_on goto On;
          location On: edge c_off goto Off; edge u_break, c_on; /* stays on */
          location Never;
        end
        """
    )
    (lamp,) = problem.plants
    assert lamp.name == "lamp"
    assert (lamp.states, lamp.initial, lamp.marked) == (("Off", "On", "Never"), (True, False, False), lamp.initial)
    assert guards(problem) == [
        "Off -lamp.c_on-> On",
        "On -lamp.c_off-> Off",
        "On -lamp.u_break-> On",
        "On -lamp.c_on-> On",
    ]
    assert [(e.name, e.controllable) for e in problem.alphabet] == [
        ("lamp.c_on", True),
        ("lamp.c_off", True),
        ("lamp.u_break", False),
    ]


def test_requirements_and_supervisors_are_specs_and_what_has_no_kind_is_a_plant() -> None:
    body = "location: initial; marked; edge c; end"
    problem = cif.loads(
        f"""controllable c; plant p: {body} automaton a: {body} requirement r: {body} supervisor automaton s: {body}
        plant q: disc int[0..1] n; location: initial; end invariant q.n = 0; plant invariant q.n = 1;
        requirement invariant q.n = 2; requirement q.n = 3; supervisor invariant q.n = 4;"""
    )
    assert [a.name for a in problem.plants] == ["p", "a", "q"]
    assert [a.name for a in problem.specs] == ["r", "s"]
    assert conditions(problem) == (["q.n == 0", "q.n == 1"], ["q.n == 2", "q.n == 3", "q.n == 4"])


def test_a_location_without_a_name_is_called_star() -> None:
    assert one_location("", "edge c;").plants[0].states == ("*",)


def test_an_alphabet_blocks_the_events_that_have_no_edge() -> None:
    problem = cif.loads("controllable a, b; plant p: alphabet b, a; location: initial; edge a; end")
    assert problem.plants[0].alphabet.names == ("a", "b")
    assert guards(problem) == ["* -a-> *"]
    assert cif.loads("plant p: alphabet; location: initial; end").plants[0].alphabet.names == ()


def test_a_monitor_follows_its_events_where_it_has_no_edge_for_them() -> None:
    text = """controllable a, b; requirement r: {} disc int[0..5] n;
      location l: initial; marked; edge a when n = 0 do n := 1; edge a when n > 2 goto m; edge b;
      location m; end plant p: location: initial; marked; edge a, b; end"""
    assert guards(cif.loads(text.format("monitor a;")), "r") == [
        "l -a-> l when r.n == 0 r.n := 1",
        "l -a-> m when r.n > 2",
        "l -b-> l",
        "l -a-> l when not (r.n == 0 or r.n > 2)",
        "m -a-> m",
    ]
    every = guards(cif.loads(text.format("monitor;")), "r")
    assert every[3:] == ["l -a-> l when not (r.n == 0 or r.n > 2)", "m -a-> m", "m -b-> m"]


def test_predicates_of_locations_become_predicates_of_the_problem() -> None:
    problem = cif.loads(
        """plant p: disc int[0..3] n in any;
        initial n < 3; marked n != 1, n != 2;
        location a: initial n = 1, true; marked; location b: initial; marked n = 0; location c: initial false; end
        marked p.a;"""
    )
    assert problem.plants[0].initial == (True, True, False)
    assert problem.plants[0].marked == (True, True, False)
    assert str(problem.initial) == "p.n < 3 and (not p.a or p.n == 1)"
    assert str(problem.marked) == "p.a and p.n != 1 and p.n != 2 and (not p.b or p.n == 0)"


# -- variables ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("declaration", "values", "initial"),
    [
        ("disc bool v", (False, True), (False,)),
        ("disc bool v = 1 < 2", (False, True), (True,)),
        ("disc bool v in any", (False, True), (False, True)),
        ("disc int[-1..2] v", (-1, 0, 1, 2), (0,)),
        ("disc int[2..4] v", (2, 3, 4), (2,)),
        ("disc int[-4..-2] v", (-4, -3, -2), (-2,)),
        ("disc int[0..3] v = N - 1", (0, 1, 2, 3), (2,)),
        ("disc int[0..3] v in {3, 1 + 0, 1}", (0, 1, 2, 3), (1, 3)),
        ("disc E v", ("X", "Y"), ("X",)),
        ("disc E v = Y", ("X", "Y"), ("Y",)),
        ("disc T v", (0, 1, 2), (0,)),
    ],
)
def test_a_variable_has_the_values_of_its_type_and_begins_as_cif_says(
    declaration: str, values: tuple[object, ...], initial: tuple[object, ...]
) -> None:
    before = "const int N = 3; enum E = X, Y; type T = int[0..N - 1];"
    (variable,) = one_location(f"{declaration};", "", before).variables
    assert (variable.name, variable.values, variable.initial) == ("p.v", values, initial)


def test_an_initial_value_may_be_that_of_another_variable() -> None:
    problem = one_location("disc int[0..3] v in {1, w}; disc int[0..3] w in {2, 3}; disc int[0..9] x = v + w;", "")
    assert [v.initial for v in problem.variables[:2]] == [(0, 1, 2, 3), (2, 3)]
    assert str(problem.initial) == "(p.v == 1 or p.v == p.w) and p.x == p.v + p.w"
    assert len(supcon(problem).initial) == 4  # (1, 2), (1, 3), (2, 2), (3, 3)


def test_an_input_variable_changes_at_any_time_to_any_other_value() -> None:
    problem = cif.loads("group io: input bool on; input int[1..3] n; end plant p: location: initial; marked; end")
    assert [v.initial for v in problem.variables] == [(False, True), (1, 2, 3)]
    assert [(e.name, e.controllable) for e in problem.alphabet] == [("io.on", False), ("io.n", False)]
    assert guards(problem, "io.on.input") == ["* -io.on-> * io.on := not io.on"]
    assert guards(problem, "io.n.input") == [f"* -io.n-> * when io.n != {v} io.n := {v}" for v in (1, 2, 3)]
    assert supcon(problem).n_states == 6


def test_a_name_that_is_a_word_of_python_gets_an_underscore() -> None:
    problem = cif.loads("plant p: disc bool from, $is; location: initial; marked from and is; end")
    assert [v.name for v in problem.variables] == ["p.from_", "p.is_"]
    assert str(problem.marked) == "p.from_ and p.is_"


def test_updates_are_made_at_once_and_an_if_is_one_value_or_another() -> None:
    problem = one_location(
        "disc int[0..3] n, m; disc bool b;",
        """edge c do n := m, m := n;
        edge c do if b: n := 1, m := 2 elif n = 2: n := 3 else b := true end;
        edge c do n := n;""",
    )
    first, second, third = guards(problem)
    assert first == "* -c-> * p.n := p.m p.m := p.n"
    n, m = "1 if p.b else (3 if p.n == 2 else p.n)", "2 if p.b else p.m"
    assert second == f"* -c-> * p.n := {n} p.m := {m} p.b := p.b if p.b else not p.n == 2 or p.b"
    assert third == "* -c-> *"


def test_an_uncontrollable_event_that_leaves_a_range_makes_a_state_bad() -> None:
    """A controllable event is not possible then; an uncontrollable one is an error that has to be prevented."""
    free = one_location("disc int[0..3] n;", "edge c do n := n + 1; edge u when n = 3 do n := n + 1;")
    assert conditions(free) == ([], ["not (p.n == 3 and p.n + 1 > 3)"])
    assert supcon(free).n_states == 3
    bounded = one_location("disc int[0..3] n;", "edge c do n := n + 1; edge u do n := n div 2;")
    assert conditions(bounded) == ([], [])
    assert supcon(bounded).n_states == 4


def test_an_event_that_another_plant_blocks_leaves_no_range() -> None:
    problem = cif.loads(
        """uncontrollable u; controllable c;
        plant p: disc int[0..3] n = 3; location: initial; marked; edge u do n := n + 1; end
        plant q: location a: initial; marked; edge c goto b; location b: edge u; end"""
    )
    assert conditions(problem) == ([], ["not (p.n + 1 > 3 and q.b)"])
    assert supcon(problem).n_states == 1


# -- expressions ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("b and n = 1 or not b", "p.b and p.n == 1 or not p.b"),
        ("b => n != 1", "not p.b or p.n != 1"),
        ("b <=> n <= 1", "p.b == (p.n <= 1)"),
        ("b = not b", "p.b == (not p.b)"),
        ("n + m * 2 - 1 >= -n", "p.n + p.m * 2 - 1 >= -p.n"),
        ("n - (m - 1) > +3", "p.n - (p.m - 1) > 3"),
        ("m div 2 = m mod 3", "p.m // 2 == p.m % 3"),
        ("if b: n elif n > 1: 2 else m end < 4", "(p.n if p.b else (2 if p.n > 1 else p.m)) < 4"),
        ("if b: true else n = 1 end", "p.b or p.n == 1"),
        ("switch m: case 1: n case 2: 3 else 4 end = n", "(p.n if p.m == 1 else (3 if p.m == 2 else 4)) == p.n"),
        ("abs(m) = 1", "p.m == 1"),
        ("min(n, m) = 1", "(p.n if p.n <= p.m else p.m) == 1"),
        ("max(1, 3, 2) = m", "3 == p.m"),
        ("true and (false or b)", "p.b"),
        ("1 + 2 * 3 = m", "7 == p.m"),
        ("not not b", "p.b"),
    ],
)
def test_expressions_keep_their_meaning(text: str, expected: str) -> None:
    assert guard(text) == expected


@pytest.mark.parametrize("divisor", [-3, -2, -1, 1, 2, 3])
@pytest.mark.parametrize("bounds", ["-7..7", "-7..-1", "0..7", "-7..0"])
def test_division_rounds_towards_zero_and_the_remainder_has_the_sign_of_the_dividend(divisor: int, bounds: str) -> None:
    low, high = (int(x) for x in bounds.split(".."))
    for n in range(low, high + 1):
        quotient = abs(n) // abs(divisor) * (1 if (n < 0) == (divisor < 0) else -1)
        problem = cif.loads(
            f"""plant p: disc int[{bounds}] n = {n}; location: initial; marked; end
            requirement p.n div {divisor} = {quotient} and p.n mod {divisor} = {n - quotient * divisor}
              and {n} div {divisor} = {quotient} and {n} mod {divisor} = {n - quotient * divisor};"""
        )
        assert supcon(problem).n_states == 1, n


@pytest.mark.parametrize("n", range(-3, 4))
def test_sign_and_abs_minimum_and_maximum(n: int) -> None:
    sign, most = (n > 0) - (n < 0), max(n, 0)
    problem = cif.loads(
        f"""plant p: disc int[-3..3] n = {n}; location: initial; marked; end
        requirement sign(p.n) = {sign}, abs(p.n) = {abs(n)}, min(p.n, 1) = {min(n, 1)}, max(0, p.n, -2) = {most};"""
    )
    assert supcon(problem).n_states == 1


def test_algebraic_variables_and_constants_are_written_out() -> None:
    problem = cif.loads(
        """const int N = 2 * M, M = 3; const bool yes = true; controllable c;
        alg int[0..99] twice = 2 * p.n; alg bool high; equation high = twice > N;
        plant p: disc int[0..9] n; alg int a; location: initial; marked; equation a = n + 1;
          edge c when high and yes do n := a; end"""
    )
    assert guards(problem) == ["* -c-> * when 2 * p.n > 6 p.n := p.n + 1"]


def test_an_algebraic_variable_may_depend_on_the_location() -> None:
    problem = cif.loads(
        """plant p: alg bool up; alg int height; controllable c;
        location a: initial; marked; equation up = false, height = 1; edge c goto b;
        location b: equation up = true; equation height = 2; edge c goto d;
        location d: equation up = true; equation height = 1; edge c when up and height < 2 goto a;
        end"""
    )
    assert guards(problem)[2] == "d -p.c-> a when not p.a and (1 if p.a or p.d else 2) < 2"


def test_literals_are_compared_where_no_variable_has_them() -> None:
    """The value of an enumeration that only an expression has is one that no variable knows."""
    problem = cif.loads(
        """enum E = X, Y, Z; controllable c;
        plant p: alg E e = if a: X elif b: Y else Z end;
        location a: initial; marked; edge c when e = Y or Z != e goto b; location b: edge c goto a; end"""
    )
    assert guards(problem)[0] == "a -c-> b when not p.a and p.b or p.a or p.b"


def test_a_switch_on_an_automaton_chooses_by_its_location() -> None:
    problem = cif.loads(
        """controllable c; plant p: location a: initial; marked; edge c goto b; location b: edge c goto a; end
        plant q: disc int[0..9] n; location: initial; marked;
          edge c do n := switch p: case a: 3 case b: 4 end; end"""
    )
    assert guards(problem, "q") == ["* -c-> * q.n := 3 if p.a else 4"]


def test_many_cases_do_not_nest_deep() -> None:
    cases = " ".join(f"case {k}: {k * 7 % 1000}" for k in range(900))
    problem = one_location("disc int[0..999] n;", f"edge c do n := switch n: {cases} else 5 end;")
    assert len(problem.plants[0].edges) == 1
    total = one_location("disc int[0..9] n;", f"edge c when {' + '.join(['n'] * 1000)} > 3;")
    assert len(total.plants[0].edges) == 1


# -- invariants -----------------------------------------------------------------------------------------------


def test_invariants_of_every_kind() -> None:
    problem = cif.loads(
        """controllable a, b; uncontrollable u;
        plant p: disc int[0..3] n; location l: initial; edge a, b, u; plant invariant n < 3; requirement a needs n = 1;
          location m: requirement n > 0; end
        plant invariant no_u: p.l disables u;
        requirement invariant p.n != 2, named: a needs p.n = 0, {a, b} needs p.l;
        group g: requirement x: p.n = 3; requirement p.n = 1 disables {a, b}; end"""
    )
    plants, specs = conditions(problem)
    assert sorted(plants) == ["not p.l or p.n < 3", "u needs not p.l"]
    assert sorted(specs) == sorted(
        [
            "p.n != 2",
            "a needs p.n == 0",
            "a needs p.l",
            "b needs p.l",
            "a needs not p.l or p.n == 1",
            "not p.m or p.n > 0",
            "p.n == 3",
            "a needs not p.n == 1",
            "b needs not p.n == 1",
        ]
    )
    assert {c.name for c in (*problem.plant_conditions, *problem.spec_conditions)} == {"", "no_u", "named", "g.x"}


def test_what_an_event_needs_that_no_automaton_knows_is_left_out() -> None:
    problem = cif.loads("controllable a, b; plant p: location: initial; edge a; end requirement b needs false;")
    assert conditions(problem) == ([], [])
    assert problem.alphabet.names == ("a",)

"""Modules of Waters, put together piece by piece for tests."""

from __future__ import annotations

from thenar import ExtendedProblem, Problem
from thenar.io.foreign import waters
from thenar.testing.extended_oracle import explore

EVENTS = '<EventDecl Kind="CONTROLLABLE" Name="a"/><EventDecl Kind="UNCONTROLLABLE" Name="u"/>'
ACCEPTING = '<EventDecl Kind="PROPOSITION" Name=":accepting"/><EventDecl Kind="PROPOSITION" Name=":forbidden"/>'


def name(text: str) -> str:
    return f'<SimpleIdentifier Name="{text}"/>'


def number(n: int) -> str:
    return f'<IntConstant Value="{n}"/>'


def binary(operator: str, *sides: str) -> str:
    quoted = operator.replace("&", "&amp;").replace("<", "&lt;")
    return f'<BinaryExpression Operator="{quoted}">{"".join(sides)}</BinaryExpression>'


def unary(operator: str, side: str) -> str:
    return f'<UnaryExpression Operator="{operator}">{side}</UnaryExpression>'


def indexed(of: str, *indexes: str) -> str:
    return f'<IndexedIdentifier Name="{of}">{"".join(indexes)}</IndexedIdentifier>'


def call(function: str, *given: str) -> str:
    return f'<FunctionCallExpression FunctionName="{function}">{"".join(given)}</FunctionCallExpression>'


def between(low: str | int, high: str | int) -> str:
    return binary("..", *(number(end) if isinstance(end, int) else end for end in (low, high)))


def node(title: str, *propositions: str, initial: bool = False) -> str:
    listed = "".join(map(name, propositions))
    return f'<SimpleNode Name="{title}" Initial="{str(initial).lower()}"><EventList>{listed}</EventList></SimpleNode>'


def edge(source: str, target: str, labels: str, guard: str = "", *actions: str) -> str:
    guards = f"<Guards>{guard}</Guards>" if guard else ""
    block = f"<GuardActionBlock>{guards}<Actions>{''.join(actions)}</Actions></GuardActionBlock>"
    return f'<Edge Source="{source}" Target="{target}"><LabelBlock>{labels}</LabelBlock>{block}</Edge>'


def component(title: str, nodes: str, edges: str = "", *, kind: str = "PLANT", blocked: str = "") -> str:
    called = f'Name="{title}"' if not title.startswith("<") else ""
    labels = f"<LabelBlock>{blocked}</LabelBlock>" if blocked else ""
    graph = f"<Graph>{labels}<NodeList>{nodes}</NodeList><EdgeList>{edges}</EdgeList></Graph>"
    return f'<SimpleComponent Kind="{kind}" {called}>{title if not called else ""}{graph}</SimpleComponent>'


def variable(title: str, domain: str, first: str = "", *marks: str) -> str:
    start = f"<VariableInitial>{first}</VariableInitial>" if first else ""
    marking = "".join(f"<VariableMarking>{name(':accepting')}{m}</VariableMarking>" for m in marks)
    return (
        f'<VariableComponent Name="{title}"><VariableRange>{domain}</VariableRange>{start}{marking}</VariableComponent>'
    )


def module(*components: str, events: str = EVENTS, before: str = "", aliases: str = "") -> bytes:
    listed = f"<EventDeclList>{events}{ACCEPTING}</EventDeclList>{aliases}"
    return f'<Module Name="m">{before}{listed}<ComponentList>{"".join(components)}</ComponentList></Module>'.encode()


def loads(*components: str, events: str = EVENTS, before: str = "", aliases: str = "") -> Problem | ExtendedProblem:
    return waters.loads(module(*components, events=events, before=before, aliases=aliases), "m.wmod")


ONE = node("p", initial=True)
LOOP = component("L", ONE, edge("p", "p", name("a") + name("u")))


def moves(problem: Problem | ExtendedProblem) -> set[tuple[object, str, object]]:
    """Return the moves by the values of the variables alone."""
    extended = ExtendedProblem.of(problem)
    n = len(extended.automata)
    step = explore(extended).step
    return {(x[n:], e, y[n:]) for x, row in step.items() for e, ys in row.items() for y in ys}


def foreach(tag: str, index: str, domain: str, inner: str) -> str:
    return f'<{tag} Name="{index}">{domain}{inner}</{tag}>'


def constant(title: str, value: str) -> str:
    return f'<ConstantAlias Name="{title}"><ConstantAliasExpression>{value}</ConstantAliasExpression></ConstantAlias>'


def group(title: str, *members: str) -> str:
    listed = "".join(f'<NodeRef Name="{m}"/>' for m in members)
    return f'<GroupNode Name="{title}"><NodeList>{listed}</NodeList></GroupNode>'


X = variable("x", between(0, 3), binary("==", name("x"), number(0)))
NEXT = unary("'", name("x"))


def run(guard: str, *actions: str, others: str = "") -> set[tuple[int, int]]:
    """Return from which to which value of x event a leads."""
    problem = loads(X, others, component("A", ONE, edge("p", "p", name("a"), guard, *actions)))
    return {(x[0], y[0]) for x, _, y in moves(problem)}  # type: ignore[index]

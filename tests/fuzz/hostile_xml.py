"""Hostile files of the formats that are XML: what XML itself brings, and what each of them adds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from tests.fuzz.hostile_models import HUGE, MANY

__all__ = ["OWN", "entities"]

_ROOTS = {
    "wmod": 'Module xmlns="http://waters.sourceforge.net/xsd/module" Name="m"',
    "supremica": 'SupremicaProject name="m"',
    "faudes-xml": 'Generator name="m"',
    "ides": 'model version="2.1" type="FSA" id="m"',
}


def entities(format: str) -> Iterator[tuple[str, bytes]]:
    """Yield files of the format called ``format`` that try what XML allows."""
    root = _ROOTS[format]
    tag = root.split(maxsplit=1)[0]
    laughs = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 10))
    large = f'<!ENTITY l9 "{"x" * 100_000}">'
    for name, internal, inner in (
        ("a billion laughs", f'<!ENTITY l0 "ha">{laughs}', "&l9;"),
        ("a quadratic blow-up", large, "&l9;" * 100_000),
        ("an entity that holds itself", '<!ENTITY l9 "&l9;">', "&l9;"),
        ("a file as an entity", '<!ENTITY l9 SYSTEM "file:///etc/passwd">', "&l9;"),
        ("an address as an entity", '<!ENTITY l9 SYSTEM "http://127.0.0.1:9/a">', "&l9;"),
        ("a parameter entity", '<!ENTITY % p SYSTEM "file:///etc/passwd"> %p;', ""),
        ("a notation", '<!NOTATION n SYSTEM "n"><!ENTITY l9 SYSTEM "a" NDATA n>', ""),
    ):
        yield name, f"<!DOCTYPE {tag} [{internal}]><{root}>{inner}</{tag}>".encode()
        yield f"{name} in an attribute", f'<!DOCTYPE {tag} [{internal}]><{root} x="{inner}"></{tag}>'.encode()
    default = f'<!DOCTYPE {tag} [<!ATTLIST a x CDATA "{"x" * 100_000}">]>'
    yield "an attribute by default", f"{default}<{root}>{'<a/>' * 100_000}</{tag}>".encode()
    many = "".join(f'<!ATTLIST a x{k} CDATA "">' for k in range(1_000))
    yield "attributes by default", f"<!DOCTYPE {tag} [{many}]><{root}>{'<a/>' * 50_000}</{tag}>".encode()
    yield "an external document type", f'<!DOCTYPE {tag} SYSTEM "file:///etc/passwd"><{root}></{tag}>'.encode()
    yield "a tag without end", f"<{root}><{'a' * 500_000}".encode()
    yield "a tag with words and no end", f"<{root}><a {'a ' * 250_000}".encode()
    yield "a closing tag without end", f"<{root}></{'a' * 500_000}".encode()
    yield "an attribute that is one long word", f"<{root}><a {'a' * 500_000}/></{tag}>".encode()
    attributes = " ".join(f"a{k}='1'" for k in range(200_000))
    yield "many attributes", f"<{root} {attributes}></{tag}>".encode()
    yield "two million comments", f"<{root}>{'<!---->' * 1_000_000}</{tag}>".encode()
    for encoding in ("utf-7", "idna", "punycode", "unicode_escape", "undefined", "rot13", "zlib", "utf-16", "nonsense"):
        yield f"declared {encoding}", f'<?xml version="1.0" encoding="{encoding}"?><{root}></{tag}>'.encode()


def _wmod() -> Iterator[tuple[str, str]]:
    def module(constants: str = "", events: str = "", aliases: str = "", components: str = "") -> str:
        return (
            f'<Module xmlns="http://waters.sourceforge.net/xsd/module" Name="m"><ConstantAliasList>{constants}'
            f"</ConstantAliasList><EventDeclList>{events}</EventDeclList><EventAliasList>{aliases}</EventAliasList>"
            f"<ComponentList>{components}</ComponentList></Module>"
        )

    def constant(name: str, value: str) -> str:
        return (
            f'<ConstantAlias Name="{name}"><ConstantAliasExpression>{value}</ConstantAliasExpression></ConstantAlias>'
        )

    def number(value: object) -> str:
        return f'<IntConstant Value="{value}"/>'

    def binary(operator: str, a: str, b: str) -> str:
        return f'<BinaryExpression Operator="{operator}">{a}{b}</BinaryExpression>'

    def span(last: object) -> str:
        return binary("..", number(0), number(last))

    def variable(name: str, span: str, initial: str = number(0)) -> str:
        first = binary("==", f'<SimpleIdentifier Name="{name}"/>', initial)
        return (
            f'<VariableComponent Name="{name}"><VariableRange>{span}</VariableRange>'
            f"<VariableInitial>{first}</VariableInitial></VariableComponent>"
        )

    def automaton(name: str, nodes: str, edges: str) -> str:
        return (
            f'<SimpleComponent Kind="PLANT" Name="{name}"><Graph><NodeList><SimpleNode Name="q" Initial="true"/>{nodes}'
            f"</NodeList><EdgeList>{edges}</EdgeList></Graph></SimpleComponent>"
        )

    def edge(source: str, guard: str = "") -> str:
        guards = f"<GuardActionBlock><Guards>{guard}</Guards></GuardActionBlock>" if guard else ""
        return f'<Edge Source="{source}" Target="{source}"><LabelBlock>{name("e")}</LabelBlock>{guards}</Edge>'

    def name(text: str) -> str:
        return f'<SimpleIdentifier Name="{text}"/>'

    event = '<EventDecl Kind="CONTROLLABLE" Name="{}"><RangeList>{}</RangeList></EventDecl>'
    one = event.format("e", "")
    loop = '<ForeachComponent Name="i{}">{}{}</ForeachComponent>'
    for huge in HUGE:
        yield f"a range up to {huge}", module(components=variable("v", span(huge)))
        yield f"a constant range up to {huge}", module(constant("c", span(huge)))
        yield f"events up to {huge}", module(events=event.format("e", span(huge)))
        yield f"a loop up to {huge}", module(components=loop.format(0, span(huge), automaton("A", "", "")))
    million = span(999_999)
    yield "many constant ranges", module("".join(constant(f"c{k}", million) for k in range(300)))
    yield "variables of many values", module(components="".join(variable(f"v{k}", million) for k in range(300)))
    yield "events by many ranges", module(events=event.format("e", million * 100))
    yield "events of many indexes", module(events=event.format("e", span(0) * 400 + span(9_999)))
    yield "billions of events", module(events=event.format("e", span(99_999) * 2))
    yield "no events by many ranges", module(events=event.format("e", million * 100 + span(-1)))
    nested = ""
    for k in range(99):
        nested = loop.format(k, million, nested)
    yield "loops in loops", module(components=nested)
    nested = automaton("A", "", "")
    for k in range(99):
        nested = loop.format(k, million if k % 2 else span(0), nested)
    yield "loops in loops around an automaton", module(components=nested)
    yield "constants in a circle", module(constant("a", name("b")) + constant("b", name("a")))
    yield "a constant of itself", module(constant("a", binary("+", name("a"), number(1))))
    chain = "".join(constant(f"c{k}", name(f"c{k + 1}")) for k in range(MANY))
    yield "constants in a long chain", module(chain + constant(f"c{MANY}", number(1)))
    doubled = "".join(constant(f"c{k}", binary("*", name(f"c{k - 1}"), name(f"c{k - 1}"))) for k in range(1, 60))
    yield "numbers that grow", module(constant("c0", number(2)) + doubled)
    aliases = "".join(
        f'<EventAlias Name="a{k}"><EventAliasExpression><List>{name(f"a{k - 1}") * 10}</List></EventAliasExpression>'
        "</EventAlias>"
        for k in range(1, 60)
    )
    first = f'<EventAlias Name="a0"><EventAliasExpression>{name("e")}</EventAliasExpression></EventAlias>'
    yield "lists of lists of events", module(events=one, aliases=first + aliases)
    many = event.format("e", span(49_999))
    listed = f"<EventAliasExpression><List>{name('e') * MANY}</List></EventAliasExpression>"
    again = f'<EventAlias Name="a">{listed}</EventAlias>'
    yield "a list of many arrays", module(events=many, aliases=again)
    arrays = f'<Edge Source="q" Target="q"><LabelBlock>{name("e") * 1_000}</LabelBlock></Edge>'
    yield "an edge of many arrays", module(events=many, components=automaton("A", "", arrays))
    deep = number(1)
    for _ in range(450):
        deep = f'<UnaryExpression Operator="-">{deep}</UnaryExpression>'
    yield "signs in one another", module(constant("c", deep))
    yield "a guard in brackets", module(events=one, components=automaton("A", "", edge("q", deep)))
    indexed = number(1)
    for _ in range(450):
        indexed = f'<IndexedIdentifier Name="e">{indexed}</IndexedIdentifier>'
    yield "indexes in indexes", module(constant("c", indexed))
    groups = "".join(
        f'<SimpleNode Name="n{k}"/><GroupNode Name="g{k}"><NodeRef Name="n{k}"/><NodeRef Name="g{k - 1}"/></GroupNode>'
        for k in range(1, 10_000)
    )
    yield (
        "groups in groups",
        module(events=one, components=automaton("A", '<GroupNode Name="g0"/>' + groups, edge("g9999"))),
    )
    circle = '<GroupNode Name="g"><NodeRef Name="h"/></GroupNode><GroupNode Name="h"><NodeRef Name="g"/></GroupNode>'
    yield "groups in a circle", module(events=one, components=automaton("A", circle, edge("g")))
    next_ = '<UnaryExpression Operator="\'">{}</UnaryExpression>'
    guard = binary("&lt;", next_.format(name("v")), next_.format(name("w")))
    wide = variable("v", span(9_999)) + variable("w", span(9_999))
    yield "next values without number", module(events=one, components=wide + automaton("A", "", edge("q", guard)))
    guard = binary("==", next_.format(name("v")), binary("/", name("v"), name("w")))
    yield "a division by 0", module(events=one, components=wide + automaton("A", "", edge("q", guard)))
    parts = "".join(
        automaton(f"A{k}", "", edge("q", binary("==", next_.format(name("v")), number(1)))) for k in range(99)
    )
    yield "a variable of many", module(events=one, components=variable("v", span(9)) + parts)
    many = name("w0")
    for k in range(1, 70):
        many = binary("+", many, name(f"w{k}"))
    chosen = [edge("q", binary("==", many, number(0))), edge("q", binary("&gt;", many, number(0)))]
    for k, text in enumerate(chosen):
        action = binary("=", name("v"), number(k))
        chosen[k] = text.replace("</GuardActionBlock>", f"<Actions>{action}</Actions></GuardActionBlock>")
    single = "".join(variable(f"w{k}", span(0)) for k in range(70)) + variable("v", span(3))
    both = automaton("A", "", "".join(chosen)) + automaton("B", "", "".join(chosen))
    yield "guards about seventy variables", module(events=one, components=single + both)
    yield "many groups of nothing", module(components=automaton("A", '<GroupNode Name="g"/>' * MANY, ""))
    yield (
        "an initial value to search for",
        module(
            components="".join(variable(f"v{k}", span(99_999), name(f"v{k + 1}")) for k in range(15))
            + variable("v15", span(9))
        ),
    )
    for path in ("../../etc/passwd", "/etc/passwd", "a"):
        yield f"an instance of {path}", module(components=f'<Instance Name="i" ModuleName="{path}"/>')
    uri = f'<?xml-stylesheet href="file:///etc/passwd"?>{module()}'
    yield "a style sheet", uri


def _supremica() -> Iterator[tuple[str, str]]:
    def project(states: str = "", events: str = "", transitions: str = "", n: int = 1) -> str:
        drawn = (
            f"<Events>{events}</Events><States>{states}</States><Transitions>{transitions}</Transitions></Automaton>"
        )
        listed = "".join(f'<Automaton name="A{k}" type="Plant">{drawn}' for k in range(n))
        return f'<SupremicaProject name="p">{listed}</SupremicaProject>'

    state, event = '<State id="{0}" name="q{0}" initial="true" forbidden="true"/>', '<Event id="{0}" label="e{0}"/>'
    step = '<Transition source="{0}" dest="{0}" event="{0}"/>'
    numbers = range(MANY)
    yield "many initial and forbidden states", project("".join(map(state.format, numbers)), event.format(0))
    yield (
        "unknown states without number",
        project(state.format(-1), event.format(-1), "".join(map(step.format, numbers))),
    )
    yield "a state again and again", project(state.format(0) * MANY, event.format(0) * MANY)
    loose = '<Event id="{0}" label="e{0}" prioritized="false"/>'
    only = '<State id="{0}" name="q{0}" initial="true"/>'
    states = only.format(0) + "".join(f'<State id="{k}" name="{k}"/>' for k in range(1, 3_000))
    yield "loose events and states", project(states, "".join(map(loose.format, range(3_000))))
    tight = f'<Automaton name="T">{project("", "".join(map(event.format, range(3_000)))).partition("Plant")[2][2:]}'
    loosened = project(states, "".join(map(loose.format, range(3_000))))
    yield "loose events and states, tight elsewhere", loosened.replace("</SupremicaProject>", tight)
    yield "automata of one name", project(only.format(0), event.format(0), n=5_000).replace("A1", "A2")
    for huge in HUGE:
        yield f"an id of {huge}", project(state.format(huge), event.format(huge), step.format(huge))


def _faudes_xml() -> Iterator[tuple[str, str]]:
    text = (
        "<Generator><Alphabet><Event name='a'/></Alphabet><StateSet>{}</StateSet>"
        "<TransitionRelation>{}</TransitionRelation></Generator>"
    )
    state = '<State id="{}"><Initial/></State>'
    for huge in HUGE:
        yield f"states up to {huge}", text.format(state.format(1) + f'<Consecutive from="2" to="{huge}"/>', "")
        yield f"state {huge}", text.format(state.format(huge), "")
        yield f"a transition to {huge}", text.format(state.format(1), f'<Transition x1="1" event="a" x2="{huge}"/>')
    spans = "".join(f'<Consecutive from="{k}" to="{k}"/>' for k in range(2, 50_000))
    yield "many short ranges", text.format(state.format(1) + spans, "")
    yield "many states", text.format("".join(map(state.format, range(1, 50_000))), "")
    step = '<Transition x1="1" event="a" x2="1"><Timing/></Transition>'
    yield "many transitions with more in them", text.format(state.format(1), step.replace("Timing", "x") * 100_000)
    yield (
        "transitions of states by name",
        text.format(
            "".join(f'<State id="{k}" name="n{k}"><Initial/></State>' for k in range(1, 20_000)),
            "".join(f'<Transition x1="n{k}" event="a" x2="n{k}"/>' for k in range(1, 20_000)),
        ),
    )
    yield "an attribute without a value", text.format(f"<State {'a' * 500_000}/>", "")
    yield "attributes of nothing", text.format(f"<State {'=' * 500_000}/>", "")


def _ides() -> Iterator[tuple[str, str]]:
    text = '<model version="2.1" type="FSA" id="m"><data>{}</data></model>'
    state = '<state id="{}"><properties><initial/></properties><name>q</name></state>'
    numbers = range(MANY)
    yield "many initial states of one name", text.format("".join(map(state.format, numbers)))
    step = '<transition id="0" source="{0}" target="{0}" event="{0}"/>'
    yield "unknown states without number", text.format("".join(map(step.format, numbers)))
    event = '<event id="{0}"><properties/><name>e</name></event>'
    yield "many events of one name", text.format("".join(map(event.format, numbers)))
    yield "layouts", text.format("") + "<meta>" * 100_000
    yield "layouts and an end", text.format("") + "<meta <" * 100_000 + "</meta>"
    yield "a layout without end", text.format("").replace("</model>", "<meta " + "a" * 1_000_000)
    for huge in HUGE:
        yield f"an id of {huge}", text.format(state.format(huge) + event.format(huge) + step.format(huge))


OWN: Mapping[str, Callable[[], Iterator[tuple[str, str]]]] = {
    "wmod": _wmod,
    "supremica": _supremica,
    "faudes-xml": _faudes_xml,
    "ides": _ides,
}

"""What fuzzing begins with: valid files of every format, made by our own writers, and words that their readers know."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

import thenar
from thenar.errors import InputError
from thenar.io.foreign import tct
from thenar.io.formats import Format
from thenar.library import classics, glr
from thenar.model.automaton import Automaton
from thenar.model.extended import ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem
from thenar.testing.random_models import random_extended_problem, random_problem

__all__ = ["dictionary", "seeds", "small_seeds"]

_NUMBERS = "0 1 -1 999999999 1000000000000000000 0x1f 1e9 0.5"
_XML = "<?xml version='1.0' encoding='UTF-8'?>|<!DOCTYPE a>|<!ENTITY a 'b'>|<![CDATA[|]]>|<!--|-->|&amp;|&#0;|/>|</|='"
_TABLES = """events automata variables conditions computed published controllable observable forcible meaning kind plant
    spec initial marked states transitions alphabet values bool 0..3 says nondeterministic when do invariant event needs
    disabled true false not and or in if else == != <= // % null"""
# Words are separated by blanks, or by | where there is one; \\xNN is a byte.
_WORDS = {
    "toml": f"{_TABLES} [events] [automata.A] [[conditions]] \"\"\" ''' = {{ }} -> \\x5cu0000 \\x5c",
    "json": f'{_TABLES} {{" ": [] -> \\x5cud800 1e999 NaN',
    "cif": """import namespace group plant requirement supervisor automaton def end event controllable uncontrollable
        const alg disc input enum type bool int[0..3] location initial marked edge when do goto if elif else
        invariant needs disables alphabet monitor in any switch case cast func real string list set dict tuple
        sample der time tau self .. := <=> => div mod and or not true false // /* */ "a.cif" """,
    "tct": "CTCT DES file. Version 1.0\\x1a|Z8^0L;1|Z8^0L;2|\\x55\\xaa\\x00\\xff|\\xff\\xff\\xff\\xff|"
    "\\xa4name\\xa6libtct|"
    "\\xa7version\\xa32.0|\\xa4size|\\xa4init|\\xa6states|\\xa6marked|\\xa4next|\\xa5vocal|\\xc0|\\xc3|"
    "\\xdd\\xff\\xff\\xff\\xff|\\xdf\\xff\\xff\\xff\\xff",
    "ads": "State size|Marker states|Vocal states|Transitions|:\\x0a|*|#|+|DES",
    "wmod": f"""{_XML}|Module|ConstantAliasList|ConstantAlias|ConstantAliasExpression|ParameterList|SimpleParameter|
        EventDeclList|EventDecl|RangeList|EventAliasList|EventAlias|ComponentList|SimpleComponent|VariableComponent|
        VariableRange|VariableInitial|VariableMarking|Instance|ForeachComponent|ForeachEvent|ConditionalComponent|
        Guards|Actions|GuardActionBlock|Graph|NodeList|SimpleNode|GroupNode|EdgeList|Edge|LabelBlock|EventList|
        SimpleIdentifier|IndexedIdentifier|QualifiedIdentifier|IntConstant|BinaryExpression|UnaryExpression|
        EnumSetExpression|FunctionCallExpression|Operator=".."|Operator="=="|Operator="\'"|Operator="="|Operator="/"|
        Kind="PLANT"|Kind="SPEC"|Kind="CONTROLLABLE"|Kind="PROPOSITION"|Name=":accepting"|Name=":forbidden"|
        Initial="true"|Value="1000000000"|Source=|Target=|FunctionName="ite"|Observable="false\"""",
    "supremica": f"""{_XML}|SupremicaProject|Automata|Automaton|Events|Event|States|State|Transitions|Transition|Layout|
        Execution|name=|type="Plant"|type="Specification"|type="Property"|id=|label=|controllable="false"|
        observable="false"|prioritized="false"|initial="true"|accepting="true"|forbidden="true"|cost=|source=|dest=|
        event=""",
    "faudes": """<Generator> </Generator> <cGenerator> </cGenerator> <Alphabet> </Alphabet> <A> <States> </States> <S>
        <TransRel> </TransRel> <T> </T> <InitStates> <I> <MarkedStates> <M> <Consecutive> </Consecutive> +C+ +o+ +F+ +P+
        <Clocks> <Invariant> <Timing> <Colors> <Flags <Priority value="7" % #3 &lt; &amp; true inf =b= <StateSet> <!--
        --> <![CDATA[ ]]>""",
    "faudes-xml": f"""{_XML}|<Generator|ftype="System"|<Alphabet>|<Event|<Controllable/>|<Observable|<Forcible/>|
        <StateSet>|<State|<Initial/>|<Marked/>|<Consecutive|<TransitionRelation>|<Transition|id=|from=|to=|x1=|x2=|
        event=|name=|value="0"|<Timing>|%""",
    "ides": f"""{_XML}|<model|version="2.1"|type="FSA"|<automaton>|<data>|<state|<event|<transition|<properties>|
        <initial/>|<marked/>|<controllable/>|<observable/>|<name>|id=|source=|target=|event=|<meta|tag="layout"|
        tag="annotation"|<workspace""",
    "desuma": "\\x09|\\x0a\\x0a|EVENTS|EMPTY_TRACE|\\x09c\\x09o|\\x09uc\\x09uo|0.5",
    "dot": """strict digraph graph subgraph node edge -> -- { } [ ] = ; , : + label= shape=doublecircle shape=point
        shape=none style=invis peripheries=2 comment= alphabet= <b> </b> \\x22 \\x5c\\x22 \\x5cN \\x5cn &amp; &#65; //
        /* */ # init start""",
    "mermaid": r"""---|title: |stateDiagram-v2|stateDiagram|[*]| --> |: |state | as |:::marked|class |classDef |
        note right of |end note|direction LR|%% alphabet: |%% meaning: |<<fork>>|<<choice>>|accDescr {|}|{|--|#33;|
        #amp;|#\xc2\xb2;|<br/>|\x0a""",
}


def seeds(format: Format) -> Iterator[bytes]:
    """Yield files of ``format``: small ones first, then models of the library and random problems."""
    yield from small_seeds(format)
    rng = Random(5)
    models: list[Problem | ExtendedProblem] = [
        classics.transfer_line(1),
        classics.cat_and_mouse(),
        classics.dining(3),
        glr.problem(),
        *(random_problem(rng) for _ in range(4)),
    ]
    if not format.one:
        models += [random_extended_problem(rng) for _ in range(8)]
    for model in models:
        for part in model.automata if format.one else (model,):
            yield from _files(part, format)


def small_seeds(format: Format) -> Iterator[bytes]:
    """Yield files of some hundred bytes, small enough to be cut and damaged everywhere."""
    lamp = Automaton.from_transitions(
        ["dark -on-> lit -off-> dark"], initial="dark", marked=["dark"], uncontrollable=["off"], name="LAMP"
    )
    yield from _files(lamp, format)
    cup = ExtendedAutomaton.from_edges(
        "CUP",
        [("up", "fill", "up", "n < 3", {"n": "n + 1"}), ("up", "pour", "down"), ("up", "pour", "up", "n > 0")],
        initial="up",
    )
    if not format.one:
        variables = [thenar.Variable("n", range(4)), thenar.Variable("lid", ["open", "shut"])]
        yield from _files(
            ExtendedProblem([cup], [thenar.invariant("lid == 'shut' or n < 2")], variables=variables), format
        )


def _files(model: Problem | ExtendedProblem | Automaton | ExtendedAutomaton, format: Format) -> Iterator[bytes]:
    """Yield the files that say ``model``, none if the format has no words for it."""
    try:
        if format.name == "tct" and isinstance(model, Automaton):
            for generation in ("pitct", "x64", "ctct"):
                chunks = tct.dumps(model, generation=generation).chunks
                yield b"".join(chunk if isinstance(chunk, bytes) else chunk.encode() for chunk in chunks)
        else:
            text = thenar.dumps(model, format.name)
            yield text if isinstance(text, bytes) else text.encode()
    except InputError:
        return


def dictionary(name: str) -> str:
    r"""Return the words of the format called ``name`` as libFuzzer reads them.

    >>> print(dictionary("ads").splitlines()[3])
    "Transitions"
    """
    text = _WORDS[name]
    words = [*(text.split("|") if "|" in text else text.split()), *_NUMBERS.split()]
    lines = (word.strip("\n").replace("        ", "").replace('"', '\\"') for word in words)
    return "".join(f'"{line}"\n' for line in lines if line)

"""Waters modules, the ``.wmod`` files of Supremica: automata with variables, guards, actions, arrays and loops.

What is in a module, and what it becomes:

* ``PLANT`` is a plant; ``SPEC`` and ``SUPERVISOR`` are specifications, as Supremica treats supervisors; a ``PROPERTY``
  is a question, left out, and the problem's description says so
* ``:accepting`` marks.  A component none of whose nodes has it marks all of them, unless its list of blocked events
  has it; a variable without a marking marks all its values.  If a module has no ``:accepting`` and one other
  proposition, that one marks; further ones are left out, and the description says so
* ``:forbidden`` nodes must not be entered: in a plain problem by a specification ``NAME without forbidden states``,
  the plant without them, and left away in specifications; in an extended one by invariants, as for variables
* the events of the list of blocked events, and of edges whose guard is never true, are in the alphabet
* constants, loops, arrays of events and lists of events are unfolded: event ``e[1][2]``, automaton ``M[1]``;
  a parameter is the value that the module gives it
* a variable's name is made writable: ``buf:count`` is ``buf.count``, ``R[1].x`` is ``R_1.x``; it stays if it can
* guards and actions read the values before, all actions of an edge at once; what no action changes keeps its value.
  An action to a value out of range makes the edge impossible.  ``x' == e`` in a guard is the action ``x = e``;
  any other relation of next values becomes an edge for each value
* truths are 0 and 1; ``/`` and ``%`` round towards zero; a comparison ``A == q`` asks for the state of an automaton
* a variable that several components update gets an automaton of one node, ``NAME.updates``, for all of its updates;
  by an event that several of them update it with, it takes the value that they agree on, and if they do not, the
  event is not possible, or not allowed if it is a specification that differs
* layout, colours, comments of parts and attribute maps are passed over

Refused, with file, line and column: instances of other modules (files of their own), edges into groups of nodes,
divisors that may be 0, next values outside guards, kinds and operators that are not known, and a component that may
choose what becomes of a variable that others update too.
"""

from __future__ import annotations

from thenar.io.foreign.waters.read import read
from thenar.io.foreign.waters.write import write
from thenar.io.foreign.written import Written
from thenar.model.extended import ExtendedProblem
from thenar.model.problem import Problem

__all__ = ["dumps", "loads"]


def loads(data: bytes, source: str) -> Problem | ExtendedProblem:
    """Read a Waters module; what becomes of its parts is said above.

    A :class:`Problem` comes out if there are no variables and guards and all is deterministic.  The alphabet is that
    of the declarations.  O(size of the file, loops unfolded), at most 2,000,000 edges, labels and components.
    Raises ModelError with line and column of all that is wrong.

    >>> text = '''<Module xmlns="http://waters.sourceforge.net/xsd/module" Name="lamp"><EventDeclList>
    ...   <EventDecl Kind="CONTROLLABLE" Name="on"/><EventDecl Kind="PROPOSITION" Name=":accepting"/>
    ... </EventDeclList><ComponentList><SimpleComponent Kind="PLANT" Name="LAMP"><Graph>
    ...   <NodeList><SimpleNode Initial="true" Name="dark"/><SimpleNode Name="lit"/></NodeList>
    ...   <EdgeList><Edge Source="dark" Target="lit">
    ...     <LabelBlock><SimpleIdentifier Name="on"/></LabelBlock></Edge></EdgeList>
    ... </Graph></SimpleComponent></ComponentList></Module>'''
    >>> loads(text.encode(), "lamp.wmod").plants
    (Automaton 'LAMP': 2 states (2 marked), 1 transition, 1 event,)
    """
    return read(data, source)


def dumps(problem: Problem | ExtendedProblem) -> Written:
    """Write ``problem`` as a Waters module.

    Said otherwise, with a sentence in ``notes``: truths are 0 and 1; what an event needs is an automaton of one
    node with a guard; an invariant of the specifications is an uncontrollable event ``violation`` that is possible
    where it does not hold, and a specification that forbids it (*not in state q of A* is a ``:forbidden`` node); an
    invariant of the plants is an automaton ``physics`` whose guards keep events from leading to where it is false;
    the state of an automaton in a guard is a comparison, which Supremica reads with automaton variables switched on.
    An ``if`` makes several edges or a disjunction, division by a number rounds down by what is added before it, a
    range with gaps is a guard.  Where an event updates a variable on one edge, the others of the event say that it
    keeps its value, as older versions of Supremica ask for.  Forcing and meanings are not written.

    Raises InputError for a predicate on initial or marked states that is not about one variable or automaton at a
    time, for an invariant of the plants that a choice of theirs decides on, for numbers of more than 32 bits, and for
    names that XML cannot hold.

    >>> from thenar import ExtendedAutomaton, ExtendedProblem, Variable
    >>> cup = ExtendedAutomaton.from_edges("CUP", [("up", "fill", "up", "n < 3", {"n": "n + 1"})], initial="up")
    >>> text = "".join(dumps(ExtendedProblem([cup], variables=[Variable("n", range(4))])).chunks)
    >>> loads(text.encode(), "cup.wmod").plants[0].edges[0].updates
    (('n', Operation(operator='+', operands=(Name(name='n'), Constant(value=1)))),)
    """
    return write(problem)

"""Symbolic analysis: sets of states as multi-valued decision diagrams, one level per automaton or variable."""

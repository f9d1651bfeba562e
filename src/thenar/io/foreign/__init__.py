"""Other tools' formats, one a module.

A module has ``loads(data, source)`` and, if the format is written too, ``dumps(model)``, which gives a ``Written``.
Whether ``model`` is one automaton or a whole problem is said in :mod:`thenar.io.formats`.
"""

"""For tests of supervisory control, here and elsewhere: slow obvious twins, random models, assertions.

``oracle`` holds the slow twin of every operation, ``thenar.testing.strategies`` the Hypothesis strategies
(not imported here: they need ``pip install thenar[testing]``).
"""

from thenar.testing import oracle
from thenar.testing.asserts import assert_isomorphic, assert_same_languages, assert_same_numbering
from thenar.testing.random_models import random_alphabet, random_automaton, random_problem

__all__ = [
    "assert_isomorphic",
    "assert_same_languages",
    "assert_same_numbering",
    "oracle",
    "random_alphabet",
    "random_automaton",
    "random_problem",
]

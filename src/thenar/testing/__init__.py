"""For tests of supervisory control, here and elsewhere: slow obvious twins, random models, assertions.

``oracle``, ``regular_oracle``, ``control_oracle``, ``timed_oracle``, ``cost_oracle`` and ``deploy_oracle`` hold the
slow twins of the operations, ``extended_oracle`` that of synthesis for extended automata, ``waters_oracle`` that of
Waters' shared variables,
``thenar.testing.strategies`` the Hypothesis strategies
(not imported here: they need ``pip install thenar[testing]``).
"""

from thenar.testing import (
    control_oracle,
    cost_oracle,
    deploy_oracle,
    extended_oracle,
    oracle,
    regular_oracle,
    timed_oracle,
    waters_oracle,
)
from thenar.testing.asserts import (
    assert_isomorphic,
    assert_same_languages,
    assert_same_numbering,
    assert_same_supervisor,
)
from thenar.testing.random_models import random_alphabet, random_automaton, random_extended_problem, random_problem

__all__ = [
    "assert_isomorphic",
    "assert_same_languages",
    "assert_same_numbering",
    "assert_same_supervisor",
    "control_oracle",
    "cost_oracle",
    "deploy_oracle",
    "extended_oracle",
    "oracle",
    "random_alphabet",
    "random_automaton",
    "random_extended_problem",
    "random_problem",
    "regular_oracle",
    "timed_oracle",
    "waters_oracle",
]

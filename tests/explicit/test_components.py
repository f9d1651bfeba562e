"""Rows and circles: the small parts that many operations are made of, against the same written down slowly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from thenar.explicit.components import heights, way_round
from thenar.explicit.rows import entries, row_offsets
from thenar.model.automaton import Automaton
from thenar.testing.strategies import automata


@given(st.lists(st.integers(0, 4)), st.data())
def test_entries_are_the_slices_of_the_rows_one_after_the_other(lengths: list[int], data: st.DataObject) -> None:
    rows = data.draw(st.lists(st.integers(0, len(lengths) - 1))) if lengths else []
    offsets = row_offsets(lengths)
    slow = [k for row in rows for k in range(offsets[row], offsets[row + 1])]
    assert entries(offsets, np.array(rows, np.int64)).tolist() == slow


@given(automata())
def test_a_height_is_one_more_than_the_highest_of_the_successors_and_without_end_where_a_cycle_is(a: Automaton) -> None:
    height = heights(a)
    for q in range(a.n_states):
        after = [int(height[t]) for _, t in a.row(q)]
        assert height[q] == (-1 if -1 in after else 1 + max(after, default=-1))
        if height[q] < 0:
            onward, circle = way_round(a, height, q)
            states = replace(a, initial=q).run([*onward, *circle])
            assert circle
            assert states[len(onward)] == states[len(onward) + len(circle)]

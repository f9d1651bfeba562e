"""Textbook models as functions that return a Problem."""

from thenar.library.classics.factories import chain, small_factory, transfer_line
from thenar.library.classics.maze import cat_and_mouse
from thenar.library.classics.philosophers import dining
from thenar.library.classics.vehicles import agv

__all__ = ["agv", "cat_and_mouse", "chain", "dining", "small_factory", "transfer_line"]

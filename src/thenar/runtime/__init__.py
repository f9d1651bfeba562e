"""Executes a supervisor: the event bus, policies, clocks, watchdogs, logs and their replay."""

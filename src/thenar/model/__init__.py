"""What things are: events, automata, problems, supervisors, traces.  Frozen data, lookup only."""

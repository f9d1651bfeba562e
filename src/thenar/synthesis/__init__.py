"""The front door: synthesis, its explanation and its certificate."""

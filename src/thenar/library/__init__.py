"""Ready models as functions that return a Problem."""

"""The hand in the loop: physics, sensor model, skills, detectors, exploratory procedures, scenarios, scoring."""

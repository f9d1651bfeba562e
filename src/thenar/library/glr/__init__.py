"""The paper's Grasp-Lift-Replace task."""

"""thenar: supervisory control of discrete-event systems."""

"""The independent certificate checkers: no code shared with the kernel, nor with the engines or the model."""

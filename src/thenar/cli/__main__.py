"""``python -m thenar.cli``: the command line without its launcher."""

from thenar.cli import main

main()

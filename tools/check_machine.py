"""Say what this machine lacks to build thenar, before anything is installed; needs nothing but Python itself."""

import shutil
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path

missing = []
if sys.version_info < (3, 11):
    missing.append(f"Python 3.11 or later; this is {sys.version.split()[0]} (choose another: make PYTHON=python3.12)")
if find_spec("ensurepip") is None:
    missing.append("Python's venv module (Debian: apt-get install python3-venv)")
if not Path(sysconfig.get_paths()["include"], "Python.h").exists():
    missing.append("Python's headers (Debian: apt-get install python3-dev)")
if not any(shutil.which(compiler) for compiler in ("c++", "g++", "clang++")):
    missing.append("a C++20 compiler (Debian: apt-get install g++)")
if missing:
    sys.exit("thenar cannot be built here; this machine lacks:\n" + "\n".join(f"  * {m}" for m in missing))

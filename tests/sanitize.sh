#!/usr/bin/env bash
# The tests of the kernel, with it built under the address and undefined-behaviour sanitizers (needs g++).
set -euo pipefail
cd "$(dirname "$0")/.."
venv=build/sanitize
[ -d "$venv" ] || "${PYTHON:-python3}" -m venv "$venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check --constraint constraints.txt \
  --config-settings=cmake.define.THENAR_SANITIZE=ON --config-settings=build-dir=build/sanitize-kernel \
  '.[testing]' pytest jsonschema
# The interpreter itself leaks on exit; what is looked for is what the kernel does while it runs.
LD_PRELOAD="$(g++ -print-file-name=libasan.so) $(g++ -print-file-name=libubsan.so)" ASAN_OPTIONS=detect_leaks=0 \
  UBSAN_OPTIONS=print_stacktrace=1 "$venv/bin/python" -P -m pytest --override-ini=testpaths=tests -p no:cacheprovider \
  -q tests/explicit tests/symbolic tests/synthesis "$@"

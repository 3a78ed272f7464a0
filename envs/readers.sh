#!/usr/bin/env bash
# Make .venv-readers: other people's readers of what this workflow exports (robomimic, lerobot), pinned by hash.
# Not needed to run the workflow: tests of docs/data.md and benchmarks use it where it is there.
set -euo pipefail
cd "$(dirname "$0")/.."
python=${PYTHON:-.venv/bin/python}
[ -x .venv-readers/bin/python ] || "$python" -m venv --without-pip .venv-readers
# --no-deps: simulators, cameras, motors and viewers that these packages ask for are left out (envs/lock.sh)
VIRTUAL_ENV="$PWD/.venv-readers" .venv/bin/uv pip install --quiet --no-deps --require-hashes -r envs/readers.txt

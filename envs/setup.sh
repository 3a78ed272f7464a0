#!/usr/bin/env bash
# Create .venv from the hash-pinned requirements and install this package into it. Safe to run again.
set -euo pipefail
cd "$(dirname "$0")/.."

candidates=(python3 python3.12 python3.11)  # mplib has no wheels for 3.13
[ -z "${PYTHON:-}" ] || candidates=("$PYTHON")
for candidate in "${candidates[@]}"; do
    if command -v "$candidate" >/dev/null && "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))'; then
        python=$candidate
        break
    fi
done
if [ -z "${python:-}" ]; then
    echo "error: ${candidates[*]}: no Python 3.11 or 3.12. Fix: install one, or name it: make all PYTHON=/path/to/python3.11" >&2
    exit 1
fi

if ! "$python" -c 'import venv, ensurepip' 2>/dev/null; then
    package=$("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        apt-get -q update && apt-get -qy install --no-install-recommends "$package"
    else
        echo "error: Python's venv module is missing. Fix: sudo apt-get install $package" >&2
        exit 1
    fi
fi

uv_version=$(sed -n 's/^uv==\([^ ]*\).*/\1/p' envs/bootstrap.txt)
if ! .venv/bin/uv --version 2>/dev/null | grep -q "uv $uv_version"; then
    echo "creating .venv with $("$python" --version)"
    "$python" -m venv --clear .venv
    .venv/bin/python -m pip install --quiet --require-hashes -r envs/bootstrap.txt
fi
export VIRTUAL_ENV="$PWD/.venv"
# Bytecode is compiled once, here: else every job does it again where Python may not write it (PYTHONDONTWRITEBYTECODE).
.venv/bin/uv pip install --compile-bytecode --require-hashes -r envs/requirements.txt
.venv/bin/uv pip install --quiet --no-deps --no-build-isolation -e .

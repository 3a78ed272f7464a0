#!/usr/bin/env bash
# Build the documentation into site/ with the pinned tools of .venv-docs (`--site-dir` elsewhere); any broken link or page without a place stops it
# (not with --quiet, which hides warnings from --strict).
set -euo pipefail
cd "$(dirname "$0")/.."
if ! cmp -s envs/docs.txt .venv-docs/installed.txt; then
    .venv/bin/python -m venv --without-pip .venv-docs
    VIRTUAL_ENV="$PWD/.venv-docs" .venv/bin/uv pip install --quiet --no-deps --require-hashes -r envs/docs.txt
    cp envs/docs.txt .venv-docs/installed.txt
fi
NO_MKDOCS_2_WARNING=1 .venv-docs/bin/mkdocs build --strict "$@"

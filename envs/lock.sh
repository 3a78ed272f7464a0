#!/usr/bin/env bash
# Write the hash-pinned requirements: one file for everything, one per environment family with the same versions.
set -euo pipefail
cd "$(dirname "$0")/.."
uv=${BIN:-.venv/bin}/uv
flags=(--universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-header --no-annotate -q)
"$uv" pip compile pyproject.toml --all-extras "${flags[@]}" "${@:---upgrade}" -o envs/requirements.txt
for family in simulation learning report; do
    extras=(--extra "$family")
    [ "$family" = learning ] && extras+=(--extra models)
    "$uv" pip compile pyproject.toml "${extras[@]}" -c envs/requirements.txt "${flags[@]}" -o "envs/$family.txt"
done

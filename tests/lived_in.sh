#!/usr/bin/env bash
# The tests that start processes, in a clone whose folder has a space in its name, where the demo was made and a run lies: as the README's commands leave it.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
git clone -q . "$work/my projects/roomkin"
cd "$work/my projects/roomkin"
make demo
cp -r "${MICRO_RUN:-demo}"/{results,logs,.snakemake} . # MICRO_RUN: as .ci/run has it; its links stay behind
touch "$work/before"
mapfile -t files < <(grep -rlE 'subprocess|dry_run\(ROOT' --include='test_*.py' tests roomkin/plugins)
PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 .venv/bin/python -m pytest -p xdist -p no:cacheprovider -n "${CORES:-2}" --dist loadfile "${files[@]}" "$@"
written=$(find results logs demo .snakemake hand weights -newer "$work/before" -type f 2>/dev/null || true)
[ -z "$written" ] || { echo "error: tests have written into the clone: $written" >&2; exit 1; }

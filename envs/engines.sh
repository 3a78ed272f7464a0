#!/usr/bin/env bash
# Make .venv-engines: .venv with Snakemake's plugins for storage and Kubernetes, and an S3 server to try them against.
# Not needed to run the workflow on one machine: tests/workflow/test_engines.py uses it where it is there.
set -euo pipefail
cd "$(dirname "$0")/.."
[ -x .venv-engines/bin/python ] || .venv/bin/python -m venv --without-pip .venv-engines
base=$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
site=$(.venv-engines/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
echo "import site; site.addsitedir('$base')" >"$site/base.pth"
VIRTUAL_ENV="$PWD/.venv-engines" .venv/bin/uv pip install --quiet --no-deps --require-hashes -r envs/engines.txt

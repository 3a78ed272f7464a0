#!/usr/bin/env bash
# Install SLURM from Debian or Ubuntu, for the tests in tests/cluster. Nothing is started.
set -euo pipefail
command -v slurmctld slurmd sbatch munged >/dev/null && exit 0
if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
    echo "SLURM is not installed here, and packages cannot be. Fix: as root: apt-get install slurm-wlm munge" >&2
    exit 1
fi
apt-get -q update && DEBIAN_FRONTEND=noninteractive apt-get -qy install --no-install-recommends slurm-wlm munge

#!/usr/bin/env bash
# Build the report image with podman and run a real rule of the workflow inside it, against inputs made for the purpose.
# Skips visibly where podman cannot run. `FAMILIES="report simulation" bash containers/check.sh` builds more.
set -euo pipefail
cd "$(dirname "$0")/.."
families=${FAMILIES:-report}
tag=${ACDC_IMAGE_TAG:-0.1.0}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

skip() { echo "SKIP containers: $1"; exit 0; }

if ! command -v podman >/dev/null; then
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || skip "no podman, and not root on Debian or Ubuntu to install it"
    (apt-get -q update && apt-get -qy install --no-install-recommends podman runc mmdebstrap) >"$work/apt.log" 2>&1 ||
        skip "podman could not be installed: $(tail -n 1 "$work/apt.log")"
fi

# Limits that a confined root may set, and runc where cgroups are hybrid (docs/containers.md).
files=$(ulimit -Hn); [ "$files" = unlimited ] && files=1048576
cat >"$work/containers.conf" <<CONF
[containers]
default_ulimits = ["nofile=$files:$files", "nproc=10000:10000"]
netns = "host"
[engine]
cgroup_manager = "cgroupfs"
events_logger = "file"
CONF
[ -d /sys/fs/cgroup/unified ] && command -v runc >/dev/null && echo 'runtime = "runc"' >>"$work/containers.conf"
export CONTAINERS_CONF=$work/containers.conf

# The base: the public image if a registry answers, else one made of Debian's own packages (not bit-identical to it).
base=${BASE:-}
if [ -z "$base" ]; then
    base=localhost/acdc-base:bookworm
    if ! podman image exists "$base"; then
        command -v mmdebstrap >/dev/null || skip "mmdebstrap is missing (apt-get install mmdebstrap), and no BASE was given"
        sources=$(ls /etc/apt/sources.list.d/*debian.sources 2>/dev/null | head -n 1 || true)
        mmdebstrap --quiet --variant=minbase --include=ca-certificates --dpkgopt='path-exclude=/usr/share/man/*' \
            --dpkgopt='path-exclude=/usr/share/locale/*' bookworm "$work/base.tar" ${sources:+"$sources"} >"$work/base.log" 2>&1 ||
            skip "no base image: $(tail -n 1 "$work/base.log")"
        podman import --quiet "$work/base.tar" "$base" >/dev/null 2>"$work/import.log" || skip "podman cannot import: $(tail -n 1 "$work/import.log")"
    fi
fi
podman run --rm --network=none "$base" true 2>"$work/run.log" || skip "podman cannot run a container here: $(tail -n 1 "$work/run.log")"

secret=()
[ -s "${SSL_CERT_FILE:-}" ] && secret=(--secret "id=ca,src=$SSL_CERT_FILE")
for family in $families; do
    echo "building acdc-$family:$tag"
    podman build --quiet --pull=never "${secret[@]}" --build-arg BASE="$base" --target "$family" \
        -t "localhost/acdc-$family:$tag" -f containers/Containerfile . >/dev/null
done

.venv/bin/python tests/workflow/run_in_container.py

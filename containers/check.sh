#!/usr/bin/env bash
# Build images with podman and run the workflow's rules inside them: `FAMILIES="report" containers/check.sh` builds some.
# Skips visibly where podman cannot run.
set -euo pipefail
cd "$(dirname "$0")/.."
families=${FAMILIES:-report learning simulation workflow}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

skip() { echo "SKIP containers: $1"; exit 0; }

if ! command -v podman >/dev/null; then
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || skip "no podman, and not root on Debian or Ubuntu to install it"
    (apt-get -q update && apt-get -qy install --no-install-recommends podman runc mmdebstrap) >"$work/apt.log" 2>&1 ||
        skip "podman could not be installed: $(tail -n 1 "$work/apt.log")"
fi

# The base: the public image if a registry answers, else one made of Debian's own packages (not bit-identical to it).
base=${BASE:-}
if [ -z "$base" ]; then
    base=localhost/acdc-base:bookworm
    if ! containers/podman image exists "$base"; then
        command -v mmdebstrap >/dev/null || skip "mmdebstrap is missing (apt-get install mmdebstrap), and no BASE was given"
        sources=$(ls /etc/apt/sources.list.d/*debian.sources 2>/dev/null | head -n 1 || true)
        mmdebstrap --quiet --variant=minbase --include=ca-certificates --dpkgopt='path-exclude=/usr/share/man/*' \
            --dpkgopt='path-exclude=/usr/share/locale/*' bookworm "$work/base.tar" ${sources:+"$sources"} >"$work/base.log" 2>&1 ||
            skip "no base image: $(tail -n 1 "$work/base.log")"
        containers/podman import --quiet "$work/base.tar" "$base" >/dev/null 2>"$work/import.log" ||
            skip "podman cannot import: $(tail -n 1 "$work/import.log")"
    fi
fi

starts() { containers/podman run --rm --network=none "$base" true 2>"$work/run.log"; }
if ! starts; then # limits that a confined root may set, the host's network, and runc where cgroups are hybrid
    files=$(ulimit -Hn); [ "$files" = unlimited ] && files=1048576
    cat >containers/containers.conf <<CONF
[containers]
default_ulimits = ["nofile=$files:$files", "nproc=10000:10000"]
netns = "host"
[engine]
cgroup_manager = "cgroupfs"
events_logger = "file"
CONF
    [ -d /sys/fs/cgroup/unified ] && command -v runc >/dev/null && echo 'runtime = "runc"' >>containers/containers.conf
    starts || { rm containers/containers.conf; skip "podman cannot run a container here: $(tail -n 1 "$work/run.log")"; }
    echo "containers: podman needs other settings here: containers/containers.conf, which containers/podman reads"
fi

secret=()
[ -s "${SSL_CERT_FILE:-}" ] && secret=(--secret "id=ca,src=$SSL_CERT_FILE")
template=$(.venv/bin/python -m roomkin.stages.config.files)
for family in $families; do
    image=${template//\{family\}/$family}
    echo "building $image"
    containers/podman build --quiet --pull=never "${secret[@]}" --build-arg BASE="$base" --target "$family" \
        -t "$image" -f containers/Containerfile . >/dev/null
done

.venv/bin/python tests/workflow/run_in_container.py $families

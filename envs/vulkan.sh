#!/usr/bin/env bash
# Install a Vulkan driver that SAPIEN can render with on the CPU: Mesa's lavapipe, 24.3 or newer
# (older ones lack VK_KHR_external_semaphore_fd). Needs root on Debian or Ubuntu.
set -euo pipefail
needed=24.3
export DEBIAN_FRONTEND=noninteractive

candidate() { apt-cache policy mesa-vulkan-drivers | sed -n 's/^ *Candidate: *//p'; }

apt-get -q update
if dpkg --compare-versions "$(candidate)" ge "$needed"; then
    apt-get -qy install --no-install-recommends libvulkan1 mesa-vulkan-drivers
    exit 0
fi

. /etc/os-release
if [ "${ID:-}" != debian ]; then
    echo "error: this system's newest mesa-vulkan-drivers is $(candidate), but $needed or newer is needed." \
         "Fix: upgrade the system, or run in the container (docs/containers.md)" >&2
    exit 1
fi
# the mirror that the system already uses, with the backports suite
main=$(ls /etc/apt/sources.list.d/*debian.sources 2>/dev/null | head -n 1 || true)
backports=/etc/apt/sources.list.d/acdc-backports.sources
if [ -n "$main" ]; then
    sed -e '/^$/,$d' -e "s/^Suites:.*/Suites: $VERSION_CODENAME-backports/" "$main" > "$backports"
else
    grep -m 1 -E "^deb .* $VERSION_CODENAME " /etc/apt/sources.list |
        sed "s/ $VERSION_CODENAME / $VERSION_CODENAME-backports /" > "${backports%.sources}.list"
fi
apt-get -q update
apt-get -qy install --no-install-recommends libvulkan1
apt-get -qy install --no-install-recommends -t "$VERSION_CODENAME-backports" mesa-vulkan-drivers

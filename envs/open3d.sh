#!/usr/bin/env bash
# Install the system libraries that Open3D's wheel links to. Needs root on Debian or Ubuntu.
set -euo pipefail
export DEBIAN_FRONTEND=noninteractive
apt-get -q update
apt-get -qy install --no-install-recommends libegl1 libgl1 libgomp1 libusb-1.0-0 libx11-6

#!/usr/bin/env bash
# Install Chromium for the tests that look at the report page. Needs root on Debian or Ubuntu; elsewhere those tests say
# that they were skipped.
set -euo pipefail
for name in chromium chromium-browser google-chrome; do
    if command -v "$name" > /dev/null; then exit 0; fi
done
if [ "$(id -u)" != 0 ] || ! command -v apt-get > /dev/null; then
    echo "note: no Chromium here, the tests of the report page are skipped (install the package chromium)" >&2
    exit 0
fi
export DEBIAN_FRONTEND=noninteractive
apt-get -q update
apt-get -qy install --no-install-recommends chromium ||
    echo "note: Chromium could not be installed, the tests of the report page are skipped" >&2

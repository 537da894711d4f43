#!/usr/bin/env bash
# Builds the Debian package, build/release/freelsd_VERSION_ARCHITECTURE.deb, from a bare Debian 12.
#
#   deploy/package.sh
#
# Install it with: apt install ./build/release/freelsd_*.deb
set -Eeuo pipefail
cd "$(dirname "$0")/.."
program="package.sh"
source deploy/steps.sh

[ $# -eq 0 ] || fail "unknown argument $1"

begin "installing packages"
install_packages package

begin "building"
build release freelsd-server freelsd_web freelsd_mavlink

begin "packing"
# Dates in the package are those of the sources, so that the same sources make the same package.
SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}"
export SOURCE_DATE_EPOCH
rm -f build/release/freelsd_*.deb
cpack -G DEB --config build/release/CPackConfig.cmake -B build/release >build/release/package.log 2>&1 || {
  cat build/release/package.log >&2
  fail "cpack failed"
}
for package in build/release/freelsd_*.deb; do
  echo "$package: $(stat -c %s "$package") bytes, installed $(dpkg-deb -f "$package" Installed-Size) KiB"
done

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
pack release

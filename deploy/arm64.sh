#!/usr/bin/env bash
# Builds the Debian package for arm64 on an amd64 Debian 12: build/arm64/freelsd_VERSION_arm64.deb.
#
#   deploy/arm64.sh [--test] [--sysroot DIR]
#
#   --test         also builds the tests of engine, storage and API, and runs them under qemu, which takes hours of a
#                  processor; FREELSD_ARM64_TESTS="storage api" runs only those
#   --sysroot DIR  the arm64 libraries (default build/arm64-sysroot); fetched if they are not there
set -Eeuo pipefail
cd "$(dirname "$0")/.."
program="arm64.sh"
source deploy/steps.sh

sysroot="build/arm64-sysroot"
with_tests=no
while [ $# -gt 0 ]; do
  case "$1" in
    --test) with_tests=yes; shift ;;
    --sysroot) sysroot="${2:?--sysroot needs a folder}"; shift 2 ;;
    *) fail "unknown argument $1" ;;
  esac
done
sysroot="$(realpath -m "$sysroot")"
read -r -a tests <<<"${FREELSD_ARM64_TESTS:-storage api engine}"

# A test that the processor makes too slow fails here too; nothing is left out silently.
run_tests() {
  local folder started
  local failed=()
  for folder in "${tests[@]}"; do
    started=$SECONDS
    qemu-aarch64 -L "$sysroot" "build/arm64/tests/${folder}_tests" || failed+=("$folder")
    echo "$folder: $((SECONDS - started)) s"
  done
  if [ ${#failed[@]} -gt 0 ]; then fail "tests of ${failed[*]} failed"; fi
}

begin "installing packages"
install_packages package arm64

begin "fetching the arm64 libraries"
if [ -e "$sysroot/complete" ]; then
  echo "already there: $sysroot"
else
  deploy/arm64/sysroot.sh "$sysroot"
fi
export FREELSD_SYSROOT="$sysroot"

begin "building"
build arm64 freelsd-server freelsd_web

begin "packing"
DEB_HOST_ARCH=arm64 pack arm64
# CPack says nothing where it finds no package for a library.
for library in libc6 libgeographiclib23 libopencv-core406; do
  dpkg-deb -f build/arm64/freelsd_*_arm64.deb Depends | grep -q "$library" || fail "the package does not depend on $library"
done

if [ "$with_tests" = yes ]; then
  begin "building the tests"
  build arm64 "${tests[@]/%/_tests}"
  begin "testing under qemu"
  run_tests
fi

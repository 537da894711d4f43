#!/usr/bin/env bash
# Makes an arm64 Debian 12 to build against: the libraries of deploy/packages.txt, extracted, none of their scripts run.
#
#   deploy/arm64/sysroot.sh DIR
#
# Needs mmdebstrap, and root or the right to unshare. Fetches about 260 MB, takes 2 GB.
set -Eeuo pipefail
root="$(realpath -m "${1:?the folder is missing}")"
cd "$(dirname "$0")/../.."
program="sysroot.sh"
source deploy/steps.sh

# The libraries to build with and to run with, and what the compiler itself needs.
wanted() {
  listed_packages run | grep -E '^lib|-dev$|-data$'
  echo libstdc++-12-dev
}

# Links that begin at the root would lead out of the folder.
make_links_relative() {
  find "$root" -type l -lname '/*' -printf '%p\t%l\n' |
    while IFS=$'\t' read -r link target; do
      case "$target" in
        /dev/* | /proc/* | /run/*) ;;
        *) ln -sfnr "$root$target" "$link" ;;
      esac
    done
}

# What update-alternatives would link when the packages are configured: the library and the name to link with.
link_alternatives() {
  local libraries="$root/usr/lib/aarch64-linux-gnu"
  local name file folder
  for name in blas lapack; do
    for file in "lib$name.so" "lib$name.so.3"; do
      for folder in "$name" atlas; do
        [ -e "$libraries/$folder/$file" ] || continue
        ln -sf "$folder/$file" "$libraries/$file"
        break
      done
    done
  done
}

# CMake's files of Ceres name LAPACK and BLAS from the root.
make_cmake_files_relative() {
  # shellcheck disable=SC2016
  sed -i 's|;/usr/lib/|;${_IMPORT_PREFIX}/lib/|g' "$root/usr/lib/aarch64-linux-gnu/cmake/Ceres/CeresTargets.cmake"
}

begin "extracting arm64 packages into $root"
mmdebstrap --variant=extract --architectures=arm64 --include="$(wanted | paste -sd,)" \
  --extract-hook="$PWD/deploy/arm64/register_packages.sh" bookworm "$root"
make_links_relative
link_alternatives
make_cmake_files_relative
touch "$root/complete"
du -sh "$root"

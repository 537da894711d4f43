#!/bin/sh
# Writes down which packages were extracted into a folder: for dpkg, which checks the dependencies of what is installed
# there, and for dpkg-shlibdeps, which takes the folder for one package that holds all its libraries.
#
#   register_packages.sh DIR        (a hook of mmdebstrap, while the packages still lie in its cache)
set -eu
root="$1"
mkdir -p "$root/DEBIAN" "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates"
echo arm64 >"$root/var/lib/dpkg/arch"
: >"$root/var/lib/dpkg/status"
: >"$root/DEBIAN/symbols"
: >"$root/DEBIAN/shlibs"
for package in "$root"/var/cache/apt/archives/*.deb; do
  dpkg-deb -f "$package" | sed '/^Package:/a Status: install ok installed' >>"$root/var/lib/dpkg/status"
  echo >>"$root/var/lib/dpkg/status"
  # dpkg asks for a list of files, which may be empty.
  name="$(dpkg-deb -f "$package" Package)"
  case "$(dpkg-deb -f "$package" Multi-Arch)" in same) name="$name:$(dpkg-deb -f "$package" Architecture)" ;; esac
  : >"$root/var/lib/dpkg/info/$name.list"
  for kind in symbols shlibs; do
    dpkg-deb --ctrl-tarfile "$package" | tar -xO "./$kind" 2>/dev/null >>"$root/DEBIAN/$kind" || true
  done
done

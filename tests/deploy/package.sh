#!/usr/bin/env bash
# The Debian package: lintian finds no error and no warning, no file holds a path of the build; in a clean Debian it is
# installed, serves, is upgraded over an edited configuration, removed and purged, and nothing is left.
#
#   tests/deploy/package.sh PACKAGE [--clean-root] [--mirror URL]
#
# The clean Debian is made by debootstrap in a temporary folder, which needs root and a mirror, and
# takes a minute of one core and some hundred MB from the mirror. What cannot be done here is said as "skipped: why".
set -Eeuo pipefail
package="$(realpath "${1:?the package is missing}")"
shift
cd "$(dirname "$0")/../.."
program="tests/deploy/package.sh"
source deploy/steps.sh

clean_root=no
mirror="http://deb.debian.org/debian"
while [ $# -gt 0 ]; do
  case "$1" in
    --clean-root) clean_root=yes; shift ;;
    --mirror) mirror="${2:?--mirror needs an address}"; shift 2 ;;
    *) fail "unknown argument $1" ;;
  esac
done

skip() { echo "skipped: $1"; }

check_with_lintian() {
  step="asking lintian"
  if ! command -v lintian >/dev/null; then
    skip "lintian, it is not installed"
    return
  fi
  local arguments=(--fail-on "error,warning" --tag-display-limit 0)
  if [ "$(id -u)" -eq 0 ]; then arguments+=(--allow-root); fi
  lintian "${arguments[@]}" "$package" || fail "lintian is not content"
  echo "lintian: no errors, no warnings"
}

# A path of whoever built it would be looked into where it is installed.
check_paths() {
  step="looking for paths of the build"
  dpkg-deb -x "$package" "$work/unpacked"
  if grep -rFl "$PWD" "$work/unpacked"; then fail "these files hold the path $PWD"; fi
  rm -r "$work/unpacked"
  echo "paths: none of the build's"
}

# Every module that the link loads is in the package.
check_link() {
  step="starting the packed freelsd-mavlink"
  if ! command -v node >/dev/null; then
    skip "freelsd-mavlink, node is not installed"
    return
  fi
  dpkg-deb -x "$package" "$work/unpacked"
  (cd / && "$work/unpacked/usr/bin/freelsd-mavlink" --help) >"$work/link.txt"
  grep -q -- '--connect' "$work/link.txt" || fail "freelsd-mavlink does not explain itself"
  local opened
  opened="$(cd "$work/unpacked/usr/lib/freelsd/mavlink" &&
    node -e "import('serialport').then(({ SerialPort }) => new SerialPort({ path: '/dev/none', baudRate: 57600 })
      .on('error', ({ message }) => console.log(message)))")"
  [[ "$opened" == *"No such file"* ]] || fail "serial ports cannot be opened: $opened"
  rm -r "$work/unpacked"
  echo "freelsd-mavlink starts, with its serial ports"
}

# Says why there can be no clean root; nothing where there can.
hindrance() {
  if [ "$clean_root" = no ]; then
    echo "not asked for by --clean-root"
  elif ! command -v debootstrap >/dev/null; then
    echo "debootstrap is not installed"
  elif [ "$(id -u)" -ne 0 ]; then
    echo "it needs root"
  elif ! unshare --mount true 2>/dev/null || ! mknod "$work/null" c 1 3 2>/dev/null; then
    echo "mounts and device nodes are not allowed"
  elif ! curl -fsIL --max-time 10 -o /dev/null "$mirror/dists/$suite/Release"; then
    echo "the mirror $mirror cannot be reached"
  fi
}

make_root() {
  debootstrap --variant=minbase "$suite" "$root" "$mirror" >"$work/debootstrap.log" 2>&1 || {
    tail -n 20 "$work/debootstrap.log" >&2
    fail "debootstrap failed"
  }
  # The root is thrown away: no need to wait for the disk.
  echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/unsafe-io"
  mount -t proc proc "$root/proc"
}

# apt ARGUMENTS...: in the clean root; asks nothing, and says something only where it fails.
apt() {
  chroot "$root" env DEBIAN_FRONTEND=noninteractive LC_ALL=C \
    apt-get -y --no-install-recommends -o Dpkg::Options::=--force-confold "$@" \
    >"$work/apt.log" 2>&1 </dev/null || {
    tail -n 30 "$work/apt.log" >&2
    fail "apt-get $* failed"
  }
}

# As the unit starts it, but for systemd: with the installed configuration, and not as root.
start_server() {
  chroot --userspec=nobody:nogroup "$root" freelsd-server --config /etc/freelsd/config.json \
    --listen "127.0.0.1:$port" >"$work/server.log" 2>&1 &
  server_pid=$!
  await_server "$url" "$server_pid" "$work/server.log"
}

end_server() {
  stop_server "$server_pid"
  server_pid=""
}

expect_there() {
  local path
  for path in "$@"; do
    [ -e "$root/$path" ] || [ -L "$root/$path" ] || fail "/$path is not there"
  done
}

check_installed() {
  apt install "/$(basename "$package")"
  expect_there etc/freelsd/config.json lib/systemd/system/freelsd.service \
    lib/systemd/system/freelsd-mavlink@.service usr/bin/freelsd-mavlink \
    usr/share/freelsd/ground_kind.onnx usr/share/doc/freelsd/copyright \
    etc/systemd/system/multi-user.target.wants/freelsd.service
  [ "$(stat -c %a:%u:%g "$root/etc/freelsd/config.json")" = 644:0:0 ] || fail "modes of the configuration"
  # systemd's StateDirectory= does this.
  install -d -m 750 -o nobody -g nogroup "$root/var/lib/freelsd"
  start_server
  curl -fsS "$url/healthz"
  echo
  local version
  version="$(curl -fsS "$url/v1/info" | jq -r .version)"
  [ "$version" = "$(dpkg-deb -f "$package" Version | sed 's/-[^-]*$//')" ] || fail "the server is $version"
  curl -fsS -o "$work/page" "$url/"
  grep -q '<title>' "$work/page" || fail "there is no page"
  curl -fsS "$url/vendor/leaflet.js" -o /dev/null || fail "the page has no map"
  curl -fsS -d '{"name": "kept"}' "$url/v1/flights" >/dev/null
  end_server
  echo "installed: freelsd $version serves"
}

# A package of a higher version, with another default configuration.
make_next_package() {
  dpkg-deb -R "$package" "$work/next"
  next_version="$(dpkg-deb -f "$package" Version)+next"
  sed -i "s/^Version: .*/Version: $next_version/" "$work/next/DEBIAN/control"
  sed -i 's/"max_num_queued_frames": 256/"max_num_queued_frames": 255/' "$work/next/etc/freelsd/config.json"
  dpkg-deb --root-owner-group -Znone -b "$work/next" "$root/next.deb" >/dev/null
}

check_upgraded() {
  sed -i 's/"num_http_threads": 32/"num_http_threads": 31/' "$root/etc/freelsd/config.json"
  make_next_package
  apt install /next.deb
  local version
  version="$(dpkg-query --admindir "$root/var/lib/dpkg" -W -f '${Version}' freelsd)"
  [ "$version" = "$next_version" ] || fail "$version after the upgrade to $next_version"
  grep -q '"num_http_threads": 31' "$root/etc/freelsd/config.json" || fail "the edited configuration is lost"
  expect_there etc/freelsd/config.json.dpkg-dist
  start_server
  [ "$(curl -fsS "$url/v1/flights" | jq -r '.flights[].name')" = kept ] || fail "the flight is lost"
  end_server
  echo "upgraded to $version: the edited configuration and the data are kept"
}

check_removed() {
  touch "$root/etc/freelsd/tokens.json"
  # Where systemd keeps the data of a service with DynamicUser=.
  mkdir -p "$root/var/lib/private/freelsd"
  apt remove freelsd
  expect_there etc/freelsd/config.json var/lib/freelsd/freelsd.db
  [ ! -e "$root/usr/bin/freelsd-server" ] || fail "the program is left"
  echo "removed: configuration and data are kept"

  apt purge freelsd
  rm "$root/$(basename "$package")" "$root/next.deb"
  local left
  left="$(find "$root" -xdev -name '*freelsd*')"
  [ -z "$left" ] || fail "left after purging: $left"
  echo "purged: nothing is left"
}

# Runs in a mount namespace of its own, so that no mount outlives it.
check_in_clean_root() {
  step="testing in a clean root"
  root="$work/root"
  server_pid=""
  trap 'if [ -n "$server_pid" ]; then stop_server "$server_pid" || true; fi' EXIT
  port="$(free_port 18280)"
  url="http://127.0.0.1:$port"
  mkdir "$root"
  local started=$SECONDS
  make_root
  echo "clean $suite: $((SECONDS - started)) s"
  cp "$package" "$root/"
  started=$SECONDS
  check_installed
  echo "with all it needs: $((SECONDS - started)) s, $(du -shx "$root" | cut -f1) in all"
  started=$SECONDS
  check_upgraded
  check_removed
  echo "upgrade, removal and purge: $((SECONDS - started)) s"
}

suite="$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)"
if [ "${clean_root_work:-}" ]; then
  work="$clean_root_work"
  check_in_clean_root
  exit
fi

work="$(mktemp -d)"
trap 'rm -rf --one-file-system "$work"' EXIT
check_with_lintian
check_paths
check_link
why="$(hindrance)"
if [ -n "$why" ]; then
  skip "the clean root: $why"
else
  clean_root_work="$work" unshare --mount --propagation private \
    tests/deploy/package.sh "$package" --mirror "$mirror"
fi
echo "package.sh: everything that ran has passed"

# shellcheck shell=bash disable=SC2154
# What demo.sh, test.sh and its parts, package.sh and the tests of tests/deploy/ share. To be sourced by a bash script
# that runs with `set -Eeuo pipefail` in the repository's root; `program` is its name.

step="starting"
trap 'echo "$program: stopped while $step (line $LINENO): the lines above say why" >&2' ERR

# Announces the next step; a failure is reported with its name.
begin() {
  step="$1"
  echo
  echo "== $step"
}

fail() {
  echo "$program: $1" >&2
  exit 1
}

# Packages of deploy/packages.txt that are for building, or marked with one of the given words.
listed_packages() {
  awk -v words=" $* " '
    /^#/ || NF == 0 { next }
    !/#/ { print $1; next }
    { word = $0; sub(/^.*# */, "", word); if (index(words, " " word " ")) print $1 }
  ' deploy/packages.txt
}

# A program that came from elsewhere (npm, chromium) counts as its package.
is_installed() {
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null || true)" = installed ] ||
    command -v "$1" >/dev/null
}

# shellcheck disable=SC2046
install_packages() { install_missing $(listed_packages "$@"); }

# install_missing PACKAGE...
install_missing() {
  local package
  local missing=()
  for package in "$@"; do
    is_installed "$package" || missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then
    echo "all packages are there"
    return
  fi
  command -v apt-get >/dev/null || fail "these packages are missing, and there is no apt-get: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null ||
      fail "packages are missing; run as root, or first: apt-get install ${missing[*]}"
    as_root=(sudo)
  fi
  echo "installing ${missing[*]}"
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# The last tag, or else 20 commits ago.
first_revision() {
  git describe --tags --abbrev=0 2>/dev/null ||
    git rev-parse --verify --quiet "HEAD~20" ||
    git rev-list --max-parents=0 HEAD | tail -n 1
}

# As many compilers at once as there are cores, and 1.5 GB of memory for each.
num_build_jobs() {
  local by_memory
  by_memory=$(awk '/^MemAvailable/ { print int($2 / 1500000) }' /proc/meminfo)
  local jobs
  jobs=$(nproc)
  if [ "$by_memory" -lt "$jobs" ]; then jobs=$by_memory; fi
  echo $((jobs > 0 ? jobs : 1))
}

# build PRESET TARGET...: configures where needed and builds; all targets without any named.
build() {
  local preset="$1"
  shift
  cmake --preset "$preset" >"build-$preset.log.tmp" 2>&1 || {
    cat "build-$preset.log.tmp" >&2
    rm -f "build-$preset.log.tmp"
    return 1
  }
  grep -A 3 'CMake Warning' "build-$preset.log.tmp" || true
  rm -f "build-$preset.log.tmp"
  local targets=()
  if [ $# -gt 0 ]; then targets=(--target "$@"); fi
  cmake --build --preset "$preset" -j "$(num_build_jobs)" "${targets[@]}"
}

# pack PRESET: the Debian package of what that preset has built.
pack() {
  local folder="build/$1"
  # Dates in the package are those of the sources, so that the same sources make the same package.
  SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}"
  export SOURCE_DATE_EPOCH
  rm -f "$folder"/freelsd_*.deb
  cpack -G DEB --config "$folder/CPackConfig.cmake" -B "$folder" >"$folder/package.log" 2>&1 || {
    cat "$folder/package.log" >&2
    fail "cpack failed"
  }
  local package
  for package in "$folder"/freelsd_*.deb; do
    echo "$package: $(stat -c %s "$package") bytes, installed $(dpkg-deb -f "$package" Installed-Size) KiB"
  done
}

# free_port FIRST: of this machine, from there on.
free_port() {
  local port
  for port in $(seq "$1" $(($1 + 100))); do
    if ! (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; then
      echo "$port"
      return
    fi
  done
  fail "no free port between $1 and $(($1 + 100))"
}

# await_server URL PID LOG: until it answers, or ended with a sentence.
await_server() {
  local _
  for _ in $(seq 150); do
    if curl -fs "$1/healthz" >/dev/null 2>&1; then return; fi
    if ! kill -0 "$2" 2>/dev/null; then
      cat "$3" >&2
      fail "the server ended; what it said stands above"
    fi
    sleep 0.2
  done
  fail "the server did not answer at $1/healthz within 30 s; see $3"
}

# What a test leaves behind: the processes `pids` and the folder `work`.
pids=()
clear_away() {
  local pid
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait
  rm -rf "$work"
}

# stop_server PID: asks it to stop and waits.
stop_server() {
  kill "$1" 2>/dev/null || return 0
  local _
  for _ in $(seq 150); do
    kill -0 "$1" 2>/dev/null || return 0
    sleep 0.1
  done
  fail "the server (process $1) did not stop within 15 s"
}

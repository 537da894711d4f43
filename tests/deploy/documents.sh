#!/usr/bin/env bash
# Runs the commands of the documents unchanged: README.md as a newcomer with a folder of geotagged
# photographs follows it, api/README.md, deploy/README.md, engine/README.md.
#
#   tests/deploy/documents.sh BUILD_FOLDER FLIGHT_FOLDER
#
# FLIGHT_FOLDER is what freelsd-render wrote. Each block of commands must be known to `run_block` below: one that nobody
# runs is a fault. Only ports, ids and numbers of worlds are put in. Needs curl, jq and python3.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
build="$(realpath "$1")"
rendered="$(realpath "$2")"
work="$(mktemp -d)"
program="documents.sh"
source "$root/deploy/steps.sh"
num_photographs=40
num_run=0
num_elsewhere=0
trap clear_away EXIT

# serve URL ARGUMENTS...: a server at that address.
serve() {
  local name="$work/server-${1##*:}"
  "$build/server/freelsd-server" --data "$name" --listen "${1#http://}" "${@:2}" >"$name.log" 2>&1 &
  pids+=($!)
  await_server "$1" $! "$name.log"
}

# Blocks between ```sh and ```, and those set in by four spaces, one file each: NAME-1.sh, NAME-2.sh ...
take_blocks() {
  awk -v name="$work/blocks/$2" '
    function begin() { if (!is_in) file = name "-" (++n) ".sh"; is_in = 1 }
    /^```sh/ { begin(); is_fenced = 1; next }
    /^```/ { is_in = is_fenced = 0; next }
    is_fenced { print > file; next }
    /^    / { begin(); print substr($0, 5) > file; next }
    { is_in = 0 }' "$root/$1"
}

# A clone as the documents see it, with a folder of photographs and what else they name.
make_clone() {
  mkdir -p "$work/clone/build" "$work/clone/demo-data" "$work/blocks" "$work/bin" "$work/strict"
  ln -s "$build" "$work/clone/build/release"
  ln -s "$root/deploy" "$root/engine" "$work/clone/"
  "$root/tests/deploy/geotag.py" "$rendered" "$work/clone/photos" "$num_photographs"
  cp "$work/clone/photos/frame_0001.jpg" "$work/clone/1.jpg"
  cp "$work/clone/photos/frame_0002.jpg" "$work/clone/2.jpg"
  printf 'EPSG:4326\n1.jpg 8.4558 47.3510 555.9\n2.jpg 8.4558 47.3511 556.3\n' >"$work/clone/geo.txt"
  (cd "$work/clone" && python3 -m zipfile -c flight.zip 1.jpg 2.jpg geo.txt)
  ln -s "$root/deploy/freelsdctl" "$work/bin/freelsdctl"
  # A refusal is a failure here: curl by itself says 0.
  printf '#!/bin/sh\nexec %s --fail "$@"\n' "$(command -v curl)" >"$work/strict/curl"
  chmod +x "$work/strict/curl"
}

# play BLOCK [SED-SCRIPT]: runs it in the clone, with the addresses of the test.
play() {
  # Servers that a block starts end with it.
  # shellcheck disable=SC2016
  echo 'trap "kill \$(jobs -p) 2>/dev/null || true" EXIT' >"$work/play.sh"
  sed "s|http://127.0.0.1:8080|$url|; s|127.0.0.1:8090|127.0.0.1:$own_port|; ${2:-}" "$work/blocks/$1" >>"$work/play.sh"
  local started=$SECONDS
  (
    cd "$work/clone"
    if ! grep -q freelsdctl "$work/play.sh"; then PATH="$work/strict:$PATH"; fi
    export PATH="$work/bin:$PATH" U="$url" FREELSD_URL="$url" FLIGHT="$flight" SITE="$site" XDG_STATE_HOME="$work/state"
    timeout 900 bash -Eeuo pipefail "$work/play.sh"
  ) >"$work/out" 2>&1 || { cat "$work/play.sh" "$work/out" >&2; fail "$1: these commands fail"; }
  echo "$1: $(grep -cEv '^ *(#|$)' "$work/blocks/$1") lines, $((SECONDS - started)) s"
  num_run=$((num_run + 1))
}
elsewhere() { num_elsewhere=$((num_elsewhere + 1)); echo "$1: run by $2"; }
expect() { grep -Eq -- "$1" "$work/out" || { cat "$work/out" >&2; fail "no line \"$1\" in the answer"; }; }
first() { curl -fsS "$url$1" | jq -r "$2"; }

# After a token is made, a server that wants it.
with_tokens() {
  local token_port
  token_port="$(free_port 18380)"
  sed "/^curl/i $build/server/freelsd-server --data $work/tokens --listen 127.0.0.1:$token_port --token-file tokens.json &>$work/tokens.log &\nuntil curl -s -o /dev/null http://127.0.0.1:$token_port/healthz; do sleep 0.2; done" \
    "$work/blocks/$1" >"$work/blocks/$1.served"
  play "$1.served" "s|$url|http://127.0.0.1:$token_port|"
  expect '"flights":'
}

# The link and the aircraft for some seconds, with the packages that deploy/test.sh has installed.
# shellcheck disable=SC2016
with_autopilot() {
  local port
  port="$(free_port 18450)"
  ln -sfn "$root/server" "$work/clone/server"
  ln -sfn "$root/tests" "$work/clone/tests"
  play "$1" "s|^npm ci .*|true|; s|udp:14550\\(.*\\)|udp:$port\\1 --spool spool \&|; s|^tests/autopilot/standin.*|timeout 12 & --to 127.0.0.1:$port \|\| [ \$? = 124 ]|; \$a curl -s \"\$U/v1/links\""
  expect '"is_connected": ?true'
}

# run_block NAME FIRST-LINE
# shellcheck disable=SC2016  # these are lines of documents
run_block() {
  case "$2" in
    'deploy/demo.sh'*) elsewhere "$1" "deploy/test.sh" ;;
    'sudo apt-get install $(sed'*) elsewhere "$1" "deploy/test.sh, step by step" ;;
    'deploy/package.sh') elsewhere "$1" "tests/deploy/package.sh" ;;
    'sudo deploy/fleet.sh up') elsewhere "$1" "tests/deploy/fleet.sh, without systemd" ;;
    'sudo apt install ./freelsd_'*) elsewhere "$1" "tests/deploy/package.sh, without systemd" ;;
    'sudo cmake --install'*) elsewhere "$1" "deploy/package.sh, which packs what is installed so" ;;
    'deploy/freelsdctl submit'*)
      local started=$SECONDS
      play "$1"
      expect '^ +1 +(landable|unverified) '
      echo "from a folder of $num_photographs photographs to a ranked site: $((SECONDS - started)) s"
      flight="$(first /v1/flights '.flights[0].id')"
      site="$(first "/v1/flights/$flight/sites" '.features[0].id')"
      ;;
    'U=http://127.0.0.1:8090')
      play "$1"
      expect '^(Landable|Unverified): '
      expect '"kind": ?"approach"'
      ;;
    'curl $U/healthz')
      play "$1"
      site="$(first "/v1/flights/$flight/sites" '.features[0].id')"
      ;;
    'curl -F images='*) play "$1" ;;
    'curl $U/v1/sites/$SITE'*)
      play "$1"
      (cd "$work/clone" && gdalinfo slope.tif >/dev/null && xmllint --noout site.kml report.html flight.html &&
        compgen -G '*.plan' >/dev/null && compgen -G '*.rally' >/dev/null) || fail "$1: files that cannot be read"
      ;;
    'build/release/server/freelsd-server --data demo-data/field'*)
      play "$1" "s|127.0.0.1:8091|127.0.0.1:$(free_port 18500)|g"
      expect '^"age_s": *[0-9.]+$'
      ;;
    'TOKEN='*) with_tokens "$1" ;;
    'npm ci --prefix server/mavlink') with_autopilot "$1" ;;
    # Nothing in reach from the place in the document is an answer too, status 4.
    'freelsdctl submit'*)
      play "$1" "s/^freelsdctl emergency [^#]*/&|| [ \$? = 4 ] /; s/f-18bbe14dc42d-r1/$site/"
      expect '^(IN REACH|NOTHING IN REACH)'
      ;;
    'build/release/tests/freelsd-eval'*) play "$1" 's|--worlds [0-9]*|--worlds 1|' ;;
    *) fail "$1 begins with \"$2\": nothing runs it" ;;
  esac
}

make_clone
take_blocks README.md readme
take_blocks api/README.md api
take_blocks deploy/README.md deploy
take_blocks engine/README.md engine
url="http://127.0.0.1:$(free_port 18300)"
own_port="$(free_port 18340)"
flight="" site=""
serve "$url"
for name in readme api deploy engine; do
  for ((i = 1; ; ++i)); do
    [ -f "$work/blocks/$name-$i.sh" ] || break
    run_block "$name-$i.sh" "$(grep -m1 -v '^#' "$work/blocks/$name-$i.sh")"
  done
  [ "$i" -gt 1 ] || fail "no commands in the $name document"
done
echo "documents.sh: $num_run blocks of commands run here, $num_elsewhere elsewhere"

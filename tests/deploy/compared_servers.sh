# shellcheck shell=bash disable=SC2154
# Servers whose answers are compared. To be sourced, after deploy/steps.sh, by a script that has set `server`, `model`,
# `photos`, `work` and `root`.

declare -A url=() flight=() process=()
# start_server NAME ARGUMENTS...: sets url and process of the name.
start_server() {
  local name="$1" log _
  shift
  log="$(mktemp "$work/$name-XXXXXX.log")"
  "$server" --listen 127.0.0.1:0 --model "$model" "$@" >"$log" 2>&1 &
  process[$name]=$!
  pids+=($!)
  for _ in $(seq 200); do
    url[$name]="$(sed -n 's|.*listens on \(http://127.0.0.1:[0-9]*\)/.*|\1|p' "$log")"
    if [ -n "${url[$name]}" ]; then return; fi
    sleep 0.05
  done
  fail "the server on $name did not start: $(cat "$log")"
}

kill_server() {
  kill -KILL "${process[$1]}"
  wait "${process[$1]}" 2>/dev/null || true
}

# control NAME ARGUMENTS...: freelsdctl, towards the server of that name.
control() {
  local log="$work/$1.txt"
  "$root/deploy/freelsdctl" "${@:2}" --url "${url[$1]}" >"$log" 2>&1 || fail "freelsdctl ${*:2}: $(tail -n 5 "$log")"
}

submit() {
  control "$1" submit "$photos" --no-wait
  flight[$1]="$(curl -fsS "${url[$1]}/v1/flights" | jq -r '.flights[0].id')"
}

# get NAME PATH: the answer, with FLIGHT for the flight's id, there and in the path, and URL for the server's. Of JSON without what depends on
# when it was asked and on how fast this machine is; the scores of recall fall with the age of the photographs.
get() {
  local of="${flight[$1]}" type timely=".age_s, .updated_at, .created_at, .mean_ms"
  case "$2" in /v1/emergency* | /v1/reach*) timely+=", .score" ;; esac
  type="$(curl -fsS --globoff -o "$work/answer" -w '%{content_type}' "${url[$1]}${2//FLIGHT/$of}")" ||
    fail "$1 does not answer $2"
  case "$type" in
    *json*)
      jq "walk(if type == \"object\" then del($timely) else . end)" "$work/answer" ;;
    *) cat "$work/answer" ;;
  esac | sed "s|${url[$1]}|URL|g; s/$of/FLIGHT/g"
}

# same_answers PATH...: from both servers, byte by byte.
same_answers() {
  local path
  for path in "$@"; do
    get sqlite "$path" >"$work/sqlite.answer"
    get postgresql "$path" >"$work/postgresql.answer"
    [ -s "$work/sqlite.answer" ] || fail "$path is empty"
    cmp "$work/sqlite.answer" "$work/postgresql.answer" || {
      diff -a "$work/sqlite.answer" "$work/postgresql.answer" | head -n 20 >&2
      fail "$path differs between SQLite and PostgreSQL"
    }
  done
}

#!/usr/bin/env bash
# From a bare Debian 12 to ranked landing sites: installs packages, builds, starts the server,
# renders a sample flight, submits it with curl and shows what was found.
#
#   deploy/demo.sh [--port N] [--data DIR] [--frames N] [--seed N] [--once]
#
#   --port N    where the server listens on 127.0.0.1 (default 8080)
#   --data DIR  where everything is kept (default ./demo-data)
#   --frames N  photographs of the sample flight (default 72)
#   --seed N    another countryside
#   --once      stop the server at the end
set -Eeuo pipefail
cd "$(dirname "$0")/.."
program="demo.sh"
source deploy/steps.sh

port=8080
data="demo-data"
num_frames=72
seed=1
once=no
usage() { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' deploy/demo.sh; }
while [ $# -gt 0 ]; do
  case "$1" in
    --port) port="${2:?--port needs a number}"; shift 2 ;;
    --data) data="${2:?--data needs a folder}"; shift 2 ;;
    --frames) num_frames="${2:?--frames needs a number}"; shift 2 ;;
    --seed) seed="${2:?--seed needs a number}"; shift 2 ;;
    --once) once=yes; shift ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; fail "unknown argument $1" ;;
  esac
done
url="http://127.0.0.1:$port"
flight_folder="$data/sample-flight-$seed-$num_frames"
pid_file="$data/server.pid"
log="$data/server.log"
server_pid=""

# Anything but a good end stops the server again; so does --once.
end() {
  local status=$?
  if [ -n "$server_pid" ] && { [ "$status" -ne 0 ] || [ "$once" = yes ]; }; then
    stop_server "$server_pid" || true
    rm -f "$pid_file"
  fi
}
trap end EXIT

stop_former_server() {
  [ -f "$pid_file" ] || return 0
  local former
  former="$(cat "$pid_file")"
  if [ "$(cat "/proc/$former/comm" 2>/dev/null || true)" = freelsd-server ]; then
    echo "stopping the server of an earlier run (process $former)"
    stop_server "$former"
  fi
  rm -f "$pid_file"
}

start_server() {
  mkdir -p "$data"
  stop_former_server
  # On its own, so that it outlives this script and its terminal.
  setsid build/release/server/freelsd-server --data "$data/server" --listen "127.0.0.1:$port" \
    >"$log" 2>&1 </dev/null &
  server_pid=$!
  echo "$server_pid" >"$pid_file"
  await_server "$url" "$server_pid" "$log"
  echo "listening on $url, database in $data/server, log in $log"
}

render_flight() {
  if [ -f "$flight_folder/complete" ] &&
    [ "$flight_folder/complete" -nt build/release/tests/freelsd-render ]; then
    echo "already rendered: $flight_folder"
    return
  fi
  rm -rf "$flight_folder"
  build/release/tests/freelsd-render --out "$flight_folder" --seed "$seed" --frames "$num_frames"
  touch "$flight_folder/complete"
}

# send WHAT CURL-ARGUMENTS...: prints the answer; a refusal is shown as the server words it.
send() {
  local what="$1"
  shift
  local answer status
  answer="$(curl -sS -w '\n%{http_code}' "$@")" || fail "$what: curl could not reach $url"
  status="${answer##*$'\n'}"
  answer="${answer%$'\n'*}"
  if [ "$status" -ge 300 ]; then fail "$what was refused with $status: $answer"; fi
  printf '%s\n' "$answer"
}

# await_job ID: follows a job to its end.
await_job() {
  local job state line last=""
  while true; do
    job="$(send "asking for job $1" "$url/v1/jobs/$1")"
    state="$(jq -r .state <<<"$job")"
    line="$(jq -r '"\(.state) \((.progress // 0) * 100 | floor) % \(.stage // "")"' <<<"$job")"
    if [ -t 1 ]; then
      printf '\r%-60s' "$line"
    elif [ "$line" != "$last" ]; then
      echo "$line"
    fi
    last="$line"
    case "$state" in
      done) break ;;
      failed | cancelled) echo; fail "job $1 $state: $(jq -c '.detail' <<<"$job")" ;;
    esac
    sleep 0.5
  done
  if [ -t 1 ]; then echo; fi
}

submit_flight() {
  flight="$(send "the flight" -d "@$flight_folder/flight.json" "$url/v1/flights" | jq -r .id)"
  echo "flight $flight"
  local arguments=(-F "poses=@$flight_folder/poses.csv")
  local image
  for image in "$flight_folder"/*.jpg; do arguments+=(-F "images=@$image"); done
  local job
  job="$(send "the batch" "${arguments[@]}" "$url/v1/flights/$flight/batch" | jq -r .id)"
  echo "sent $num_frames photographs and their poses, job $job"
  await_job "$job"
}

finish_flight() {
  local job
  job="$(send "finishing" -X POST "$url/v1/flights/$flight/finish" | jq -r .id)"
  await_job "$job"
}

print_sites() {
  local sites
  sites="$(send "asking for sites" "$url/v1/flights/$flight/sites")"
  local num_sites
  num_sites="$(jq '.features | length' <<<"$sites")"
  if [ "$num_sites" -eq 0 ]; then fail "no site was found in the sample flight"; fi
  jq -r '
    def show(digits): if . == null then "-"
      else (. * pow(10; digits) | round / pow(10; digits) | tostring) end;
    ["rank", "verdict", "score", "latitude", "longitude", "strip m", "to hazard m", "heading deg",
     "obstacle m", "unseen", "age days", "why not"],
    (.features[] | .properties as $p | .geometry.coordinates as $c |
     [$p.rank, $p.verdict, ($p.score | show(2)), ($c[1] | show(6)), ($c[0] | show(6)),
      (if $p.usable_length_m == null then "-" else "\($p.usable_length_m | floor)x\($p.usable_width_m | floor)" end), ($p.hazard_distance_m | show(1)),
      ($p.approach.heading_deg | show(0)), ($p.approach.tightest_obstacle.clearance_m | show(1)),
      ($p.unseen_ratio | show(2)), ($p.age_s / 86400 | floor), ($p.reject_reason // "-")])
    | @tsv' <<<"$sites" |
    awk -F '\t' '{ printf "%4s  %-10s  %5s  %10s  %10s  %7s  %11s  %11s  %11s  %6s  %8s  %s\n",
                          $1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12 }'
  echo
  jq -r '.features[0].properties | "best: " + .summary' <<<"$sites"
}

begin "installing packages"
install_packages

begin "building"
build release freelsd-server freelsd-render freelsd_web

begin "starting the server"
start_server

begin "rendering the sample flight"
render_flight

begin "submitting the flight with curl"
submit_flight

begin "evaluating every region"
finish_flight

begin "landing sites"
print_sites
echo
if [ "$once" = yes ]; then
  echo "done; the server stops, everything it found is kept in $data/server"
else
  echo "see $url/  (stop the server with: kill $server_pid)"
fi

#!/usr/bin/env bash
# The arm64 package: it installs in its sysroot, its server evaluates a sample flight under qemu, and both are compared
# with amd64: what each stage makes, the sites and their digests, and what is answered from the same stored maps.
#
#   tests/deploy/arm64.sh FOLDER [--frames N]
#
# FOLDER is a flight of freelsd-render; only the first N photographs are taken (default 12). Needs root, and what
# deploy/arm64.sh and deploy/package.sh have built, with freelsd-stages of both. Fails if the package does not install or
# serve, or if an answer from the same stored maps differs in a word or by more than a millionth. How far the
# evaluations differ is only told: OpenCV and Ceres calculate differently on each processor (deploy/arm64.md).
set -Eeuo pipefail
flight_folder="$(realpath "${1:?the folder of the flight is missing}")"
shift
cd "$(dirname "$0")/../.."
program="tests/deploy/arm64.sh"
source deploy/steps.sh

num_frames=12
while [ $# -gt 0 ]; do
  case "$1" in
    --frames) num_frames="${2:?--frames needs a number}"; shift 2 ;;
    *) fail "unknown argument $1" ;;
  esac
done
sysroot="$(realpath "${FREELSD_SYSROOT:-build/arm64-sysroot}")"
qemu=(qemu-aarch64 -L "$sysroot")
work="$(mktemp -d)"
trap clear_away EXIT

# dpkg checks the dependencies. Its scripts run on this machine, for that folder: DPKG_ROOT.
install_in_sysroot() {
  local package
  package="$(ls build/arm64/freelsd_*_arm64.deb)"
  dpkg --root="$sysroot" --force-script-chrootless --install "$package" >"$work/dpkg.log" 2>&1 || {
    cat "$work/dpkg.log" >&2
    fail "the package does not install"
  }
  [ "$(dpkg-query --admindir="$sysroot/var/lib/dpkg" -W -f '${db:Status-Status}' freelsd:arm64)" = installed ] ||
    fail "the package is not installed"
  file "$sysroot/usr/bin/freelsd-server" | grep -q aarch64 || fail "the program is not for arm64"
  echo "installed: $(basename "$package")"
}

# start NAME DATA PROGRAM...: a server on that data; its address is in url_NAME.
start() {
  local name="$1" data="$2"
  shift 2
  local port
  port="$(free_port 18680)"
  "$@" --config "$sysroot/etc/freelsd/config.json" --data "$data" --listen "127.0.0.1:$port" \
    >"$work/$name.log" 2>&1 &
  pids+=($!)
  server_pid=$!
  url="http://127.0.0.1:$port"
  await_server "$url" "$server_pid" "$work/$name.log"
}

end_server() {
  stop_server "$server_pid"
  server_pid=""
}

arm64_server=("${qemu[@]}" "$sysroot/usr/bin/freelsd-server")
amd64_server=(build/release/server/freelsd-server)

# The first photographs of the flight, as a folder of its own.
take_frames() {
  mkdir "$work/flight"
  cp "$flight_folder/flight.json" "$work/flight/"
  head -n "$((num_frames + 1))" "$flight_folder/poses.csv" >"$work/flight/poses.csv"
  local image
  for image in $(tail -n "+2" "$work/flight/poses.csv" | cut -d, -f1); do
    cp "$flight_folder/$image" "$work/flight/"
  done
}

# evaluate NAME PROGRAM...: by the server, into $work/NAME.sites.
evaluate() {
  local name="$1"
  shift
  local started=$SECONDS
  start "$name" "$work/$name" "$@"
  deploy/freelsdctl --url "$url" submit "$work/flight" >"$work/$name.shown"
  deploy/freelsdctl --url "$url" sites --all --json >"$work/$name.sites"
  end_server
  echo "$name: $(jq '.features | length' "$work/$name.sites") sites, $((SECONDS - started)) s"
}

# Every number of a JSON file by its path; names, times and ages of the run left out.
# shellcheck disable=SC2016
readonly numbers='[paths(numbers) as $path | select($path | map(tostring) | join(".") |
  test("age_s|updated_at|last_seen|_us$|seconds") | not) | {key: ($path | map(tostring) | join(".")),
  value: getpath($path)}] | from_entries'

# print_differences A B: how many numbers differ, and by how much at most, by their name.
print_differences() {
  jq -n --slurpfile a <(jq "$numbers" "$1") --slurpfile b <(jq "$numbers" "$2") -r '
    $a[0] as $a | $b[0] as $b |
    "numbers: \($a | length) and \($b | length)",
    ([$a | to_entries[] | select($b[.key] != .value)
      | {name: (.key | gsub("[0-9]+"; "*")), by: (if $b[.key] == null then null else (.value - $b[.key] | fabs) end)}]
     | group_by(.name)[] | "  \(.[0].name): \(length) differ, by up to \(map(.by // 0) | max)")'
}

# unlike_answers A B: words of the answers that differ, and numbers that differ by more than a millionth.
unlike_answers() {
  jq -n --slurpfile a "$1" --slurpfile b "$2" -r '
    def leaves: [paths(scalars) as $path | {key: ($path | map(tostring) | join(".")), value: getpath($path)}] | from_entries;
    def alike($x; $y): if ($x | type) == "number" and ($y | type) == "number"
      then ($x - $y | fabs) <= 1e-6 * ([1, ($x | fabs)] | max) else $x == $y end;
    ($a | leaves) as $a | ($b | leaves) as $b
    | ($a + $b | keys[]) | select(alike($a[.]; $b[.]) | not) | "\(.): \($a[.]) and \($b[.])"'
}

compare_sites() {
  jq -r '.features[] | [.properties.rank, .properties.verdict, .properties.evidence_digest] | @tsv' \
    "$work/amd64.sites" >"$work/amd64.digests"
  jq -r '.features[] | [.properties.rank, .properties.verdict, .properties.evidence_digest] | @tsv' \
    "$work/arm64.sites" >"$work/arm64.digests"
  echo "digests equal: $(comm -12 <(cut -f3 "$work/amd64.digests" | sort) <(cut -f3 "$work/arm64.digests" | sort) |
    grep -c . || true) of $(wc -l <"$work/amd64.digests")"
  paste <(cut -f1,2 "$work/amd64.digests") <(cut -f1,2 "$work/arm64.digests")
  print_differences "$work/amd64.sites" "$work/arm64.sites"
}

# What a pilot would ask, over every site and from four sides.
ask_all() {
  local latitude longitude
  while read -r latitude longitude; do
    for heading in 0 90 180 270; do
      curl -fsS "$url/v1/emergency?latitude_deg=$latitude&longitude_deg=$longitude&altitude_m=600&heading_deg=$heading&wind_east_mps=2&wind_north_mps=-1&limit=10"
      echo
    done
  done < <(jq -r '.features[].geometry.coordinates | "\(.[1]) \(.[0])"' "$work/amd64.sites")
}

# Without what depends on how long it took: under qemu not every site in reach is evaluated in time.
# shellcheck disable=SC2016
readonly timeless='del(.. | .age_s?, .evaluated_in_s?)
  | .warnings |= map(select(contains("not every stored site in reach was evaluated") | not))'

# The same stored maps, asked on both.
compare_recall() {
  cp -r "$work/amd64" "$work/copy"
  start recall-amd64 "$work/amd64" "${amd64_server[@]}"
  ask_all | jq -cS "$timeless" >"$work/amd64.recall"
  end_server
  start recall-arm64 "$work/copy" "${arm64_server[@]}"
  ask_all | jq -cS "$timeless" >"$work/arm64.recall"
  end_server
  local num_answers
  num_answers="$(grep -c . "$work/amd64.recall")"
  echo "answers from the same stored maps: $num_answers," \
    "of them equal: $(paste -d '\n' "$work/amd64.recall" "$work/arm64.recall" |
      awk 'NR % 2 { a = $0; next } $0 == a { n++ } END { print n + 0 }')"
  print_differences <(jq -s . "$work/amd64.recall") <(jq -s . "$work/arm64.recall")
  local unlike
  unlike="$(unlike_answers "$work/amd64.recall" "$work/arm64.recall")"
  if [ -n "$unlike" ]; then
    head -n 20 <<<"$unlike" >&2
    fail "these answers from the same stored maps differ"
  fi
}

compare_stages() {
  local native=build/release/tests/freelsd-stages
  local cross=("${qemu[@]}" build/arm64/tests/freelsd-stages)
  "$native" run "$flight_folder" --frames "$num_frames" --out "$work/amd64.run"
  "${cross[@]}" run "$flight_folder" --frames "$num_frames" --out "$work/arm64.run"
  "$native" alone "$flight_folder" --frames "$num_frames" --adjusted "$work/amd64.run" --out "$work/amd64.alone"
  "${cross[@]}" alone "$flight_folder" --frames "$num_frames" --adjusted "$work/amd64.run" --out "$work/arm64.alone"
  "$native" compare "$work/amd64.run" "$work/arm64.run" || true
  "$native" compare "$work/amd64.alone" "$work/arm64.alone" || true
}

begin "installing the package in $sysroot"
install_in_sysroot
take_frames

begin "evaluating $num_frames photographs on both"
evaluate amd64 "${amd64_server[@]}"
evaluate arm64 "${arm64_server[@]}"
compare_sites

begin "asking both about the same stored maps"
compare_recall

begin "comparing the stages"
compare_stages

#!/usr/bin/env bash
# deploy/freelsdctl against a real server: every command, what it says, and how it ends.
#
#   tests/deploy/freelsdctl.sh FREELSD_SERVER MODEL FLIGHT_FOLDER
#
# FLIGHT_FOLDER is what freelsd-render wrote; the first photographs of it are sent. Needs curl and jq.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
server="$(realpath "$1")"
model="$(realpath "$2")"
rendered="$(realpath "$3")"
num_photographs=40
export FREELSD_CHUNK_FILES=8  # so that there are several requests
work="$(mktemp -d)"
photos="$work/my first field"
program="freelsdctl.sh"
source "$root/deploy/steps.sh"
source "$root/tests/deploy/card.sh"
trap clear_away EXIT

fail() {
  echo "$program: $1" >&2
  if [ -f "$work/out" ]; then tail -n 20 "$work/out" "$work/err" >&2; fi
  exit 1
}

# start_server NAME ARGUMENTS...: sets url.
start_server() {
  local log="$work/$1.log" _
  shift
  # Read below, perhaps before the server's shell has made it.
  : >"$log"
  "$server" --data "${log%.log}" --listen 127.0.0.1:0 --model "$model" "$@" >"$log" 2>&1 &
  pids+=($!)
  for _ in $(seq 200); do
    url="$(sed -n 's|.*listens on \(http://127.0.0.1:[0-9]*\)/.*|\1|p' "$log")"
    if [ -n "$url" ]; then return; fi
    sleep 0.05
  done
  fail "the server did not start: $(cat "$log")"
}

# A curl that writes down its arguments, and fails at the batch with the given number.
watch_curl() {
  mkdir -p "$work/bin"
  cat >"$work/bin/curl" <<END
#!/usr/bin/env bash
printf '%s\n' "\$@" >>"$work/arguments"
case "\$*" in */batch*)
  echo batch >>"$work/batches"
  [ "\$(wc -l <"$work/batches")" != "\${FAIL_AT_BATCH:-}" ] || { echo 'curl: (56) cut' >&2; exit 56; } ;;
esac
exec "$(command -v curl)" "\$@"
END
  chmod +x "$work/bin/curl"
  PATH="$work/bin:$PATH"
}

# run STATUS ARGUMENTS...: freelsdctl must end with that status; its words are in $work/out and $work/err.
run() {
  local wanted="$1" got=0
  shift
  "$root/deploy/freelsdctl" "$@" >"$work/out" 2>"$work/err" || got=$?
  [ "$got" = "$wanted" ] || fail "freelsdctl $*: status $got instead of $wanted"
  if grep -Eq 'stopped in line|jq: error|unbound variable' "$work/err"; then fail "freelsdctl $*: is broken"; fi
}
said() { grep -Eq -- "$2" "$work/$1" || fail "no line \"$2\" in what was said to $1"; }
equal() { [ "$1" = "$2" ] || fail "$3: \"$1\" instead of \"$2\""; }
get() { curl -fsS "$url$1"; }
num_flights() { get /v1/flights | jq '.flights | length'; }

test_usage() {
  run 0 --help
  said out 'comes FROM'
  local each
  for each in submit watch sites flights rename delete emergency export; do
    run 0 "$each" --help
    said out "^  $each"
    said out '--url URL'
    equal "$(grep -Ec '^  (submit|watch|sites|flights|rename|delete|emergency|export) ' "$work/out" || true)" 1 \
      "commands in the help of $each"
  done
  run 0 submit --help
  said out '--no-wait'
  if grep -q -- '--home-altitude' "$work/out"; then fail "the help of submit tells of export"; fi
  run 0 --version
  equal "$(cut -d ' ' -f 2 "$work/out")" \
    "$(sed -n 's/^project(freelsd VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")" "the version"
  run 2 land
  run 2 sites --wind-from 3
  said err 'freelsdctl sites --help'
  run 2 emergency 47 8
  run 2 emergency 47 east 500
  run 2 emergency 47 8 500 --wind-from 270
  said err 'go together'
  run 2 submit "$work" --wind-from 400 --wind-speed 3
  said err '--wind-from: must be in \[0, 360\]'
  run 2 emergency 47 8 500 --wind-from 40 --wind-speed -3
  said err '--wind-speed: must be in \[0, 100\]'
  run 2 delete
  run 2 rename f-1
  run 2 rename ../f-1 x
  run 2 sites --forget-sites
  run 2 sites ../../etc
  run 2 export f-1 --format dwg
  run 2 export f-1 --format plan --firmware betaflight
  said err '--firmware must be px4 or ardupilot'
  run 2 submit "$photos" --aircraft
  run 3 flights --url http://127.0.0.1:1
  said err 'no server can be reached at http://127.0.0.1:1'
  run 1 sites
  said err 'no flight yet'
  run 1 sites f-none
  said err 'there is no such flight'
  run 1 submit "$work"
  said err "no photographs .* in $work or its subfolders"
  echo "usage, no server, no flight: as they should be"
}

test_submit() {
  local number
  mkdir "$photos"
  for number in $(seq -f %04g "$num_photographs"); do
    cp "$rendered/frame_$number.jpg" "$photos/frame \"${number#00}\".jpg"
  done
  cp "$rendered/flight.json" "$photos"
  # With rows of photographs that are not here.
  sed 's/^frame_00\([0-9]*\)\.jpg/"frame ""\1"".jpg"/' "$rendered/poses.csv" >"$photos/poses.csv"
  run 0 submit "$photos" --dry-run
  said out "All $num_photographs photographs would be accepted"
  equal "$(num_flights)" 0 "flights after a dry run"

  # The connection breaks at the third batch; the same again sends what is missing.
  rm -f "$work/batches"
  FAIL_AT_BATCH=3 run 3 submit "$photos"
  : >"$work/arguments"
  run 0 submit "$photos"
  said err "lacks $((num_photographs - 16)) of $num_photographs"
  equal "$(grep -c '^images=' "$work/arguments")" $((num_photographs - 16)) "photographs sent the second time"
  equal "$(num_flights)" 1 "flights"
  flight="$(get /v1/flights | jq -r '.flights[0].id')"
  equal "$(get "/v1/flights/$flight" | jq .frames.received)" "$num_photographs" "frames"
  equal "$(get "/v1/flights/$flight" | jq -r .aircraft.profile)" small "the aircraft"
  said err '100 %  sending'
  said out '^rank +verdict +score +latitude'
  site="$(get "/v1/flights/$flight/sites" | jq -r '.features[0].id')"
  said out "^ +1 +(landable|unverified) .* $site\$"
  : >"$work/arguments"
  run 0 submit "$photos"
  equal "$(grep -c '^images=' "$work/arguments" || true)" 0 "photographs sent the third time"
  echo "submit: dry, broken off, gone on with, asked again"
}

# As many programs leave a flight: photographs in a folder of their own, poses beside it.
test_images_folder() {
  local flown="$work/flown" other
  mkdir -p "$flown/images"
  cp "$rendered"/frame_000[1-3].jpg "$flown/images"
  cp "$rendered/flight.json" "$rendered/poses.csv" "$flown"
  run 0 submit "$flown" --no-wait
  said err "photographs from $flown/images"
  said err "poses from $flown/poses.csv"
  other="$(cat "$work/out")"
  run 0 watch "$other"
  equal "$(get "/v1/flights/$other" | jq .frames.received)" 3 "frames"
  mv "$flown/poses.csv" "$flown/images"
  run 0 submit "$flown" --dry-run
  said err "poses from $flown/images/poses.csv"
  curl -fsS -X DELETE "$url/v1/flights/$other?forget_sites=true"
  echo "images in a folder of their own: sent"
}

test_refusals() {
  local bad="$work/bad" num_before
  mkdir "$bad"
  cp "$rendered"/frame_000[1-3].jpg "$bad"
  run 1 submit "$bad" --dry-run
  said err 'frame_0001.jpg: neither meta, poses'
  printf 'image,lat,lon,alt\n\nframe_0003.jpg,north,8.4,500\n' >"$bad/poses.csv"
  num_before="$(num_flights)"
  run 1 submit "$bad"
  said err 'line 3: "lat" must be a latitude'
  equal "$(num_flights)" "$num_before" "flights after a refused upload"
  run 1 submit "$bad" --aircraft zeppelin
  said err 'profile: must be one of'
  printf 'image,lat,lon,alt,wind_speed\nframe_0003.jpg,47,8.4,500,2\n' >"$bad/poses.csv"
  run 1 submit "$bad" --wind-from 270 --wind-speed 5
  said err 'has the wind already'
  printf 'image,lat,lon,alt\nother.jpg,47,8.4,500\n' >"$bad/poses.csv"
  run 1 submit "$bad"
  said err 'no photograph of .* is named in .*poses.csv'
  printf 'image,lat,lon,alt\nframe_0003.jpg,47,8.4,500\n' >"$bad/poses.csv"
  run 1 submit "$bad"
  said err 'no photograph was accepted'
  equal "$(num_flights)" "$num_before" "flights after an upload of which nothing was accepted"
  cp "$rendered/flight.json" "$bad"
  run 0 submit "$bad" --wind-from 270 --wind-speed 5 --no-wait --name "A \"name\""
  said err '2 of 3 photographs have no pose'
  said err 'refused: frame_0001.jpg'
  local other
  other="$(cat "$work/out")"
  run 0 watch "$other"
  run 0 flights
  said out "^$other +idle +1 .*A \"name\"\$"
  curl -fsS -X DELETE "$url/v1/flights/$other?forget_sites=true"
  echo "refusals: named"
}

# What nobody tells costs height: at Swindale, 53 m of geoid.
test_unknowns() {
  local unknown="$work/unknown" other
  mkdir "$unknown"
  cp "$rendered"/frame_000[1-2].jpg "$unknown"
  jq 'del(.altitude_datum)' "$rendered/flight.json" >"$unknown/flight.json"
  printf 'image,lat,lon,alt\nframe_0001.jpg,54.51,-2.76,500\nframe_0002.jpg,54.5101,-2.76,500\n' >"$unknown/poses.csv"
  run 0 submit "$unknown" --no-wait </dev/null
  other="$(cat "$work/out")"
  said err '^! the datum of the altitudes is unknown: every recall of these sites takes 53 m .* give --datum \(amsl or ellipsoid\)'
  said err '^! the wind is unknown: .* takes [1-9][0-9]* m more .* each kilometre .* give --wind-from and --wind-speed'
  run 0 watch "$other"
  said err '^! the datum of the altitudes is unknown'
  run 0 delete "$other" --forget-sites
  run 0 submit "$unknown" --no-wait --datum amsl --wind-from 240 --wind-speed 5
  other="$(cat "$work/out")"
  if grep -q 'is unknown' "$work/err"; then fail "what is told still counts as unknown"; fi
  run 0 watch "$other"
  run 0 delete "$other" --forget-sites
  echo "unknown datum and wind: their cost is named"
}

# Ends with the flight that all other tests need.
test_rename_and_delete() {
  local bare
  bare="$(curl -fsS -d '{"name": "bare"}' "$url/v1/flights" | jq -r .id)"
  run 0 rename "$bare" "A \"better\" name"
  said err 'is now named "A .*better.* name"'
  equal "$(get "/v1/flights/$bare" | jq -r .name)" 'A "better" name' "the name"
  run 1 rename "$bare" "$(printf 'a\342\200\256b')"
  said err 'name: must have .* no control characters'
  run 0 delete "$bare"
  said err 'its sites stay'
  run 1 delete "$bare"
  said err 'no such flight'
  run 1 rename "$bare" x
  said err 'no such flight'
  run 0 rename "$flight" renamed
  run 0 export "$site" --format cup
  said out '^"renamed [0-9]+'
  run 0 delete "$flight" --forget-sites
  said err 'its sites are forgotten'
  equal "$(get /v1/sites | jq '.features | length')" 0 "sites of deleted flights"
  echo "rename and delete: done, and refused"
}

# The hash of an answer without ages in seconds: the ground of the sample flight is years old, and ages go on.
hash_without_ages() { sed -E 's/[0-9]{7,}(\.[0-9]+)?/N/g' | sha256sum; }

test_sites() {
  run 0 sites "$flight" --json
  equal "$(jq -S . "$work/out" | hash_without_ages)" "$(get "/v1/flights/$flight/sites" | jq -S . | hash_without_ages)" "sites --json"
  local num_shown num_all
  run 0 sites "$flight"
  num_shown="$(grep -Ec '^ +[0-9]+ +(landable|unverified) ' "$work/out")"
  equal "$num_shown" "$(get "/v1/flights/$flight/sites" |
    jq '[.features[] | select(.properties.verdict != "rejected")] | length')" "sites shown"
  run 0 sites "$flight" --all
  num_all="$(grep -Ec '^ +[0-9]+ +(landable|unverified|rejected) ' "$work/out")"
  equal "$num_all" "$(get "/v1/flights/$flight/sites" | jq '.features | length')" "sites shown with --all"
  said out 'why not$'
  run 0 replay "$flight"
  said out 'sites have the same digest again'
  equal "$(grep -c '^equal ' "$work/out")" "$num_all" "sites replayed"
  run 0 watch "$flight"
  said out "$site"
  echo "sites: $num_shown of $num_all"
}

test_emergency() {
  local latitude longitude altitude
  read -r latitude longitude altitude < <(get "/v1/sites/$site" |
    jq -r '[.geometry.coordinates[1], .geometry.coordinates[0], .properties.elevation_m + 200] | @tsv')
  : >"$work/arguments"
  run 0 emergency "$latitude" "$longitude" "$altitude" --datum amsl --heading 45 --wind-from 270 --wind-speed 5
  # From the west is towards the east, and landed against: within what the wind may turn.
  grep -qx 'wind_east_mps=5.000' "$work/arguments" || fail "the wind is told another way round"
  said out '^IN REACH'
  said out 'LAND ON (2[4-9][0-9]|300)'
  said out 'ARRIVE [0-9]+ m above'
  run 0 emergency "$latitude" "$longitude" "$altitude" --limit 1 --json
  equal "$(jq '.sites | length' "$work/out")" 1 "sites with --limit 1"
  run 4 emergency "$latitude" "$longitude" "$altitude" --glide 2 --wind-from 270 --wind-speed 60
  said out '^NOTHING IN REACH'
  run 4 emergency -33.9 -70.5 900
  said out 'NOTHING IN REACH'
  run 1 emergency 91 8 500
  said err 'latitude_deg'
  run 1 emergency 47 8 500 --glide 0.5
  said err '--glide: must be in'
  echo "emergency: in reach and not"
}

test_exports() {
  local format id marks=(
    [0]='geojson "FeatureCollection"|"Feature"' [1]='plan "fileType": *"Plan"' [2]='waypoints ^QGC WPL 110'
    [3]='rally ^RALLY' [4]='kml <kml' [5]='cup ^name,code' [6]='csv latitude_deg')
  for mark in "${marks[@]}"; do
    format="${mark%% *}"
    for id in "$flight" "$site"; do
      run 0 export "$id" --format "$format" --home-altitude 400
      said out "${mark#* }"
    done
    equal "$(hash_without_ages <"$work/out")" "$(get "/v1/sites/$site?f=$format&home_altitude_m=400" | hash_without_ages)" "$format"
  done
  run 0 export "$site" --format report -o "$work/a report.html"
  grep -qi '<html' "$work/a report.html" || fail "the report is no page"
  run 0 export "$flight" --format report -o "$work/flight.html"
  grep -qi '<h2>Map of the flight' "$work/flight.html" || fail "the report of a flight is no page"
  run 1 export "$site" --format rally -o "$work/none.rally"
  said err '--home-altitude: is missing'
  if grep -q home_altitude_m "$work/err"; then fail "the message names no option"; fi
  if [ -e "$work/none.rally" ]; then fail "a refused export left a file"; fi
  run 1 export f-none-r1 --format kml
  said err 'no such site'
  run 0 export "$site" --format plan --home-altitude 400
  equal "$(jq .mission.firmwareType "$work/out")" 12 "PX4"
  run 0 export "$site" --format plan --home-altitude 400 --firmware ardupilot
  equal "$(jq .mission.firmwareType "$work/out")" 3 "ArduPilot"
  said out "\"name\": \"$(get "/v1/flights/$flight" | jq -r .name) [0-9]+"
  mkdir "$work/folder"
  run 0 export "$site" --format cup -o "$work/folder"
  compgen -G "$work/folder/$site*.cup" >/dev/null || fail "the file in the folder has another name"
  echo "export: every format"
}

# completions WORD...: what follows the words, on one line.
completions() {
  set +eE +o pipefail
  COMP_WORDS=("$root/deploy/freelsdctl" "$@")
  COMP_CWORD=$#
  COMP_LINE="${COMP_WORDS[*]}"
  COMPREPLY=()
  _freelsdctl
  echo "${COMPREPLY[*]}"
}

test_completion() {
  # shellcheck disable=SC1091
  source "$root/deploy/freelsdctl.bash-completion"
  equal "$(completions e)" "emergency export" "commands"
  equal "$(completions re)" "rename replay" "commands"
  equal "$(completions delete f --f)" --forget-sites "options"
  equal "$(completions export "$flight" --format k)" kml "formats"
  # A second may be short on a busy machine.
  # shellcheck disable=SC2317
  equal "$(timeout() { command timeout 60 "${@:2}"; }; completions sites f-)" "$flight" "flights"
  equal "$(completions sites --a)" --all "options"
  equal "$(completions submit "$photos" --url "$url" --aircraft s)" small "aircraft"
  local started=$SECONDS
  equal "$(FREELSD_URL=http://10.255.255.1 completions sites f-)" "" "flights of a server that is not there"
  if [ $((SECONDS - started)) -gt 4 ]; then fail "completion waits for a server that is not there"; fi
  echo "completion: commands, options, formats, flights"
}

test_tokens() {
  local hash
  hash="$(printf s3cret | sha256sum | cut -d ' ' -f 1)"
  (umask 077 && echo "[{\"sha256\":\"$hash\",\"scopes\":[\"read\",\"ingest\"]}]" >"$work/tokens.json")
  start_server guarded --token-file "$work/tokens.json"
  export FREELSD_URL="$url"
  : >"$work/arguments"
  run 1 flights
  said err 'token is needed'
  echo s3cret >"$work/my token"
  run 0 flights --token "$work/my token"
  FREELSD_TOKEN=s3cret run 0 flights
  FREELSD_TOKEN=wrong run 1 flights
  FREELSD_TOKEN=s3cret run 1 submit "$work/bad" --dry-run
  said err 'scopes do not allow'
  if grep -q s3cret "$work/arguments"; then fail "the token stands in the arguments of curl"; fi
  run 1 flights --token "$work/no such file"
  echo "tokens: asked for, and not shown"
}

watch_curl
start_server open
export FREELSD_URL="$url" XDG_STATE_HOME="$work/state"
test_usage
test_submit
test_images_folder
test_card
test_sites
test_emergency
test_exports
test_completion
test_refusals
test_unknowns
test_rename_and_delete
test_tokens
echo "freelsdctl.sh: everything has passed"

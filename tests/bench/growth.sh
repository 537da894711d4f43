#!/usr/bin/env bash
# What a long flight costs, as Markdown: processor seconds a photograph and peak of memory of the server, for few and for
# many photographs of one rendered survey of 2 km by 2 km: those nearest to its middle.
#   tests/bench/growth.sh [COUNT]...        default 50 400 2000; 2000 take a quarter of an hour on two cores
# RENDERED, if set, is a folder with that survey, rendered before.
set -euo pipefail
counts=("$@")
[ $# -gt 0 ] || counts=(50 400 2000)
cd "$(dirname "$0")/../.."
source deploy/steps.sh
work="$(mktemp -d)"
server=""
trap '[ -z "$server" ] || kill "$server"; rm -rf "$work"' EXIT
all="${RENDERED:-$work/all}"
[ -n "${RENDERED:-}" ] || build/release/tests/freelsd-render --out "$all" --seed 1060 --frames 2000 --size 2000 \
  --pattern survey >"$work/render.log"
port="$(free_port 18200)"

processor_s() { awk '{ print ($14 + $15) / 100 }' "/proc/$server/stat"; }

# nearest_to_middle COUNT: the lines of the pose file, in its order.
nearest_to_middle() {
  python3 - "$all/poses.csv" "$1" <<'END'
import csv, math, sys
rows = list(csv.DictReader(open(sys.argv[1])))
places = [(float(row["latitude_deg"]), float(row["longitude_deg"])) for row in rows]
north, east = (0.5 * (min(values) + max(values)) for values in zip(*places))
def distance(i):
    return math.hypot(places[i][0] - north, (places[i][1] - east) * math.cos(math.radians(north)))
chosen = sorted(sorted(range(len(rows)), key=distance)[: int(sys.argv[2])])
writer = csv.DictWriter(sys.stdout, rows[0].keys(), lineterminator="\n")
writer.writeheader()
writer.writerows(rows[i] for i in chosen)
END
}

# measure COUNT
measure() {
  local folder="$work/$1" begin
  mkdir -p "$folder/images"
  nearest_to_middle "$1" >"$folder/poses.csv"
  sed -n '2,$s/,.*//p' "$folder/poses.csv" | sed "s|.*|$all/&|" | xargs ln -st "$folder/images"
  cp "$all/flight.json" "$folder/"
  build/release/server/freelsd-server --data "$folder/data" --listen "127.0.0.1:$port" >"$work/server.log" 2>&1 &
  server=$!
  until curl -sf "http://127.0.0.1:$port/readyz" >/dev/null; do sleep 0.1; done
  begin=$(date +%s)
  deploy/freelsdctl --url "http://127.0.0.1:$port" submit "$folder" >"$work/$1.log" 2>&1
  echo "| $1 | $(($(date +%s) - begin)) | $(awk -v all="$(processor_s)" -v count="$1" \
    'BEGIN { printf "%.3f", all / count }') | $(awk '/VmHWM/ { printf "%.0f", $2 / 1024 }' "/proc/$server/status") |" \
    "$(curl -sf "http://127.0.0.1:$port/v1/sites?limit=1000" | jq '.features | length') |"
  kill "$server"
  wait "$server" || true
  server=""
}

echo "| photographs | seconds | processor seconds a photograph | peak of memory, MiB | sites, rejected ones included |"
echo "|---|---|---|---|---|"
for count in "${counts[@]}"; do measure "$count"; done

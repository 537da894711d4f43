#!/usr/bin/env bash
# Faults of a fleet on PostgreSQL: two API servers and two workers lose parts while a flight is sent and evaluated.
#
#   tests/faults/fleet.sh [--times N] [--rows NAME,...] [--build DIR] [--flight DIR] [--out FILE]
#
#   --times N     repetitions of each fault, default 1
#   --rows        only these rows of fleet.py, by name
#   --build DIR   with freelsd-server and freelsd-render, default build/release
#   --flight DIR  a rendered flight, default: rendered here
#   --out FILE    the table as Markdown, beside the terminal
#
# Runs beside a cluster of its own; status 77 and a line "skipped: why" where there is no PostgreSQL with PostGIS. Needs
# python3. Status 0 means that no row failed.
set -Eeuo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
if [ -z "${FREELSD_TEST_CLUSTER:-}" ]; then exec "$here/../storage/postgres_cluster.sh" "$here/fleet.sh" "$@"; fi
PYTHONDONTWRITEBYTECODE=1 exec python3 "$here/fleet.py" "$@"

#!/usr/bin/env bash
# Runs a command beside a PostgreSQL cluster of its own, which is removed afterwards.
#
#   tests/storage/postgres_cluster.sh COMMAND...
#
# The command finds the cluster's URI in FREELSD_TEST_DATABASE. The cluster listens on a socket in its own folder only
# and is as durable as Debian's (fsync on). Status 77, with the reason: there is no PostgreSQL with PostGIS at hand.
set -Eeuo pipefail

skip() {
  echo "skipped: $1"
  exit 77
}

programs="$(ls -d /usr/lib/postgresql/*/bin 2>/dev/null | sort -V | tail -n 1)"
if [ ! -x "$programs/initdb" ]; then skip "no PostgreSQL at hand (Debian: postgresql-15-postgis-3)"; fi
version="$(basename "$(dirname "$programs")")"
if [ ! -e "/usr/share/postgresql/$version/extension/postgis.control" ]; then
  skip "no PostGIS for PostgreSQL $version at hand (Debian: postgresql-$version-postgis-3)"
fi

# The path of a socket is at most 107 bytes long.
folder="$(mktemp -d /tmp/freelsd-pg-XXXXXX)"
# PostgreSQL refuses to run as root.
as_owner=()
if [ "$(id -u)" -eq 0 ]; then
  chown nobody:nogroup "$folder"
  as_owner=(setpriv --reuid=nobody --regid=nogroup --clear-groups env HOME="$folder")
fi

remove() {
  if [ -e "$folder/data/postmaster.pid" ]; then "${control[@]}" -m fast stop >/dev/null || true; fi
  rm -rf "$folder"
}
trap remove EXIT

# fail LOG: shows it.
fail() {
  cat "$1" >&2
  exit 1
}

"${as_owner[@]}" "$programs/initdb" -D "$folder/data" -U freelsd -A trust -E UTF8 --locale=C.UTF-8 \
  --data-checksums >"$folder/initdb.log" 2>&1 || fail "$folder/initdb.log"
printf "listen_addresses = ''\nunix_socket_directories = '%s'\n" "$folder" >>"$folder/data/postgresql.conf"
control=("${as_owner[@]}" "$programs/pg_ctl" -D "$folder/data" -l "$folder/server.log" -w -t 120)
"${control[@]}" start >/dev/null || fail "$folder/server.log"

FREELSD_TEST_DATABASE="postgresql://freelsd@/postgres?host=$folder"
export FREELSD_TEST_DATABASE
"$programs/psql" -q "$FREELSD_TEST_DATABASE" -c 'CREATE EXTENSION postgis'
status=0
# What a test needs to stop and start the cluster.
FREELSD_TEST_CLUSTER="${control[*]}" "$@" || status=$?
exit "$status"

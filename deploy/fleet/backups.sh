# shellcheck shell=bash disable=SC2154
# Backups of a fleet, and the way back to a point in time. To be sourced by fleet.sh.

# The database first: an image is stored before its row. Image files never change, so links are copies.
backup() {
  local folder
  folder="$root/backups/$(date -u +%Y%m%dT%H%M%SZ)"
  begin "backing up the database"
  as_user postgres env PGPASSFILE="$root/secrets/database.pass" "$programs/pg_basebackup" -h 127.0.0.1 \
    -p "$(database_port)" -U "$superuser" -D "$folder/database" -X stream -c fast
  as_user postgres "$programs/pg_verifybackup" -q "$folder/database"
  begin "backing up the images"
  copy_images "$root/images" "$folder/images"
  date -u +'%Y-%m-%d %H:%M:%S.%6N+00' >"$folder/complete"
  echo "$folder"
}

# copy_images FROM TO: what is not there yet; links where both are on one file system.
copy_images() {
  mkdir -p "$2"
  cp -aln "$1/." "$2/" 2>/dev/null || cp -an "$1/." "$2/"
}

stop_servers() {
  if has_systemd; then systemctl stop freelsd-fleet.target 'freelsd-fleet@*' freelsd-fleet-nginx; else stop_servers_of_supervisor; fi
}

# What PostgreSQL needs to know to go from the backup to that time.
begin_recovery() {
  write_cluster_settings
  {
    echo "recovery_target_action = 'promote'"
    if [ -n "${given[to]:-}" ]; then echo "recovery_target_time = '${given[to]}'"; fi
  } | as_user postgres tee -a "$root/database/fleet.conf" >/dev/null
  as_user postgres touch "$root/database/recovery.signal"
  start_cluster
  write_cluster_settings
}

restore() {
  local folder="$1" former
  if [ ! -e "$folder" ]; then folder="$root/backups/$1"; fi
  [ -e "$folder/complete" ] || fail "$folder is no complete backup"
  if [[ "${given[to]:-}" == *\'* ]]; then fail "--to must be a time"; fi
  begin "stopping the servers and the database"
  stop_servers
  if cluster_answers; then archive_latest; fi
  stop_cluster
  former="$root/database.before-$(date -u +%Y%m%dT%H%M%SZ)"
  mv "$root/database" "$former"
  begin "restoring the database"
  cp -a "$folder/database" "$root/database"
  begin_recovery
  begin "restoring images"
  copy_images "$folder/images" "$root/images"
  check_images
  # Numbers of changes go on from an earlier one: whoever follows begins anew. It may still have maps that are lost
  # here, so none of their numbers is given again.
  if [ "$(ask "SELECT to_regclass('feed') IS NOT NULL")" = t ]; then
    ask "UPDATE feed SET id = replace(gen_random_uuid()::text, '-', '')" >/dev/null
    ask "UPDATE map_numbers SET last = last + 1000000" >/dev/null
  fi
  echo "restored; the former database is in $former"
  echo "start the servers again with: deploy/fleet.sh up --root $root"
}

# The latest rows are in the archive only when their file is. What is written meanwhile belongs to the next file.
archive_latest() {
  local _ wanted
  wanted="$(ask 'SELECT pg_walfile_name(pg_switch_wal() - 1)' postgres)"
  for _ in $(seq 300); do
    if as_user postgres test -e "$root/archive/$wanted"; then return; fi
    sleep 0.1
  done
  fail "the archive has no $wanted after 30 s"
}

# Every row must have its file. Files without a row stay until the servers' sweep of unused images.
check_images() {
  local sha256 num_rows=0 num_missing=0
  while read -r sha256; do
    num_rows=$((num_rows + 1))
    if [ ! -e "$root/images/${sha256:0:2}/$sha256" ]; then
      num_missing=$((num_missing + 1))
      echo "missing: $sha256" >&2
    fi
  done < <(ask 'SELECT stored_image FROM frames WHERE stored_image IS NOT NULL UNION SELECT sha256 FROM photo_tiles')
  echo "$num_rows images, $num_missing missing"
  [ "$num_missing" -eq 0 ] || fail "flights with a missing image cannot be evaluated again; their sites stay"
}

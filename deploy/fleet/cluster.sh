# shellcheck shell=bash disable=SC2154
# The PostgreSQL cluster of a fleet, in ROOT/database. To be sourced by fleet.sh.

programs=/usr/lib/postgresql/15/bin
# The servers' role owns the schema; the superuser's is for backups.
database=freelsd
role=freelsd
superuser=postgres

database_port() { echo "${setting[internal-port]}"; }

# ask_as ROLE SQL: the password comes from a file that this user may read.
ask_as() {
  as_user postgres env PGPASSFILE="$root/secrets/database.pass" "$programs/psql" -qAtX -h 127.0.0.1 \
    -p "$(database_port)" -U "$1" -d "${3:-$database}" -v ON_ERROR_STOP=1 -c "$2"
}
ask() { ask_as "$superuser" "$@"; }

cluster_answers() {
  "$programs/pg_isready" -q -h 127.0.0.1 -p "$(database_port)" -t 3
}

await_cluster() {
  local _
  for _ in $(seq 1200); do
    if cluster_answers && [ "$(ask 'SELECT pg_is_in_recovery()' postgres 2>/dev/null)" = f ]; then return; fi
    sleep 0.1
  done
  tail -n 20 "$root/log/database.log" >&2
  fail "the database does not answer after 120 s"
}

# A server takes up to 33 connections. Each committed row survives a power cut; damage of a page is noticed.
write_cluster_settings() {
  local num_servers
  num_servers="$(server_names | wc -l)"
  cat >"$root/run/cluster.conf" <<END
port = $(database_port)
listen_addresses = '127.0.0.1'
unix_socket_directories = '$root/socket'
max_connections = $((40 + 33 * num_servers))
password_encryption = scram-sha-256
wal_level = replica
archive_mode = on
archive_command = 'if test -f $root/archive/%f; then cmp -s %p $root/archive/%f; else cp %p $root/archive/%f.new && sync $root/archive/%f.new && mv $root/archive/%f.new $root/archive/%f; fi'
archive_timeout = 60
restore_command = 'cp $root/archive/%f %p'
END
  as_user postgres cp "$root/run/cluster.conf" "$root/database/fleet.conf"
  as_user postgres grep -q "^include 'fleet.conf'" "$root/database/postgresql.conf" ||
    echo "include 'fleet.conf'" | as_user postgres tee -a "$root/database/postgresql.conf" >/dev/null
}

start_cluster() {
  if cluster_answers; then return; fi
  if has_systemd; then
    systemctl start freelsd-fleet-database.service
  else
    as_user postgres "$programs/pg_ctl" -D "$root/database" -l "$root/socket/database.log" -W start >/dev/null
  fi
  await_cluster
}

stop_cluster() {
  if has_systemd; then
    systemctl stop freelsd-fleet-database.service
  elif [ -e "$root/database/postmaster.pid" ]; then
    as_user postgres "$programs/pg_ctl" -D "$root/database" -m fast -w -t 60 stop >/dev/null
  fi
}

pass_line() { printf '127.0.0.1:%s:*:%s:%s\n' "$(database_port)" "$1" "$(cat "$root/secrets/$1.word")"; }

write_passwords() {
  local name
  for name in "$role" "$superuser"; do random_word | write_secret "$name.word" postgres; done
  { pass_line "$role" && pass_line "$superuser"; } | put_secret database.pass postgres
  pass_line "$role" | put_secret server.pass freelsd
}

# The role's password reaches SQL through standard input: ps shows no part of it.
make_database() {
  local word
  word="$(cat "$root/secrets/$role.word")"
  as_user postgres env PGPASSFILE="$root/secrets/database.pass" "$programs/psql" -qX -h 127.0.0.1 \
    -p "$(database_port)" -U "$superuser" -d postgres -v ON_ERROR_STOP=1 <<END
SELECT 'CREATE ROLE $role LOGIN' WHERE NOT EXISTS (SELECT 1 FROM pg_roles WHERE rolname = '$role') \gexec
ALTER ROLE $role PASSWORD '$word';
SELECT 'CREATE DATABASE $database OWNER $role' WHERE NOT EXISTS (SELECT 1 FROM pg_database WHERE datname = '$database') \gexec
\connect $database
SET client_min_messages = warning;
CREATE EXTENSION IF NOT EXISTS postgis;
REVOKE CREATE ON SCHEMA public FROM PUBLIC;
GRANT CREATE ON SCHEMA public TO $role;
END
}

make_cluster() {
  write_passwords
  if [ ! -e "$root/database/PG_VERSION" ]; then
    make_folder "$root/database" 700 postgres
    as_user postgres "$programs/initdb" -D "$root/database" -U "$superuser" --pwfile="$root/secrets/$superuser.word" \
      -A scram-sha-256 -E UTF8 --locale=C.UTF-8 --data-checksums >"$root/log/initdb.log" 2>&1 || {
      cat "$root/log/initdb.log" >&2
      fail "the cluster could not be made"
    }
  fi
  write_cluster_settings
  if has_systemd; then write_database_unit; fi
  start_cluster
  make_database
}

# What waits, who works, and how far the archive is.
tell_of_work() {
  ask "SELECT format('work         %s frames wait, %s jobs are unfinished, %s workers',
    (SELECT count(*) FROM frames WHERE state = 0), (SELECT count(*) FROM jobs WHERE state < 2),
    (SELECT count(*) FROM workers WHERE expires_at > now()))" 2>/dev/null || true
  ask "SELECT format('archive      %s files, last one %s', archived_count, coalesce(last_archived_time::text, 'none')) ||
    CASE WHEN last_failed_time > coalesce(last_archived_time, '-infinity') THEN '; THE LATEST ATTEMPT FAILED' ELSE '' END
    FROM pg_stat_archiver"
}

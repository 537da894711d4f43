#!/usr/bin/env bash
# A fleet on one machine with Debian 12: a PostgreSQL cluster of its own, API servers, workers, and nginx in front.
#
#   deploy/fleet.sh up [--foreground]          sets up what is missing and starts it; may be repeated
#   deploy/fleet.sh status                     status 0: all of it runs
#   deploy/fleet.sh stop
#   deploy/fleet.sh backup                     the database and the images, into ROOT/backups
#   deploy/fleet.sh restore BACKUP [--to TIME] the database as at that time (default: the latest), and the images
#
#   --root DIR            where everything is kept, default /var/lib/freelsd-fleet
#   --port N              of nginx (HTTPS), default 8443
#   --internal-port N     first of the ports of loopback: the database's; servers have the next 30, default 18100
#   --workers N           default 3
#   --host NAME           that clients ask for, default this machine's
#   --server FILE         freelsd-server, default the installed one, else one that is built here
#   --foreground          supervises the processes itself and stops with Ctrl-C
#
# Where systemd runs, `up` as root makes units (freelsd-fleet.target); elsewhere a supervisor in the background.
# TIME is as PostgreSQL reads it, e.g. "2026-11-27 21:30:00+00". Passwords and tokens are in ROOT/secrets (mode 600).
set -Eeuo pipefail
deploy="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
# shellcheck disable=SC2034
program="fleet.sh"
source "$deploy/steps.sh"
source "$deploy/fleet/cluster.sh"
source "$deploy/fleet/servers.sh"
source "$deploy/fleet/supervision.sh"
source "$deploy/fleet/backups.sh"

# What the first `up` was told counts until another one is told something else.
# shellcheck disable=SC2034
num_apis=2
root=/var/lib/freelsd-fleet
declare -A setting=([port]=8443 [internal-port]=18100 [workers]=3 [host]="$(hostname)" [server]="")

usage() { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$deploy/fleet.sh"; }
is_root() { [ "$(id -u)" -eq 0 ]; }
has_systemd() { [ -d /run/systemd/system ] && is_root; }

# as_user NAME COMMAND...: as that user where this one may choose.
as_user() {
  local name="$1"
  shift
  if is_root; then
    setpriv --reuid="$name" --regid="$(id -g "$name")" --clear-groups env HOME="$root" "$@"
  else
    "$@"
  fi
}

# make_folder FOLDER MODE USER
make_folder() {
  mkdir -p "$1"
  chmod "$2" "$1"
  if is_root; then chown "$3:$(id -gn "$3")" "$1"; fi
}

# put_secret NAME USER: from standard input, for that user alone.
put_secret() {
  local file="$root/secrets/$1"
  (umask 077 && cat >"$file.new")
  if is_root; then chown "$2" "$file.new"; fi
  mv "$file.new" "$file"
}

# write_secret NAME USER: the same, unless it is there.
write_secret() { if [ -e "$root/secrets/$1" ]; then cat >/dev/null; else put_secret "$@"; fi; }

random_word() { head -c 32 /dev/urandom | base64 | tr -d '=+/\n'; }

read_settings() {
  local key value
  if [ ! -e "$root/settings" ]; then return; fi
  while IFS='=' read -r key value; do
    if [ -z "${given[$key]:-}" ]; then setting[$key]="$value"; fi
  done <"$root/settings"
}

write_settings() {
  local key
  for key in "${!setting[@]}"; do echo "$key=${setting[$key]}"; done | sort >"$root/settings"
}

install_what_is_missing() {
  begin "installing packages"
  install_missing curl jq nginx-light openssl postgresql-15 postgresql-15-postgis-3 util-linux
  if is_root && ! id freelsd >/dev/null 2>&1; then
    useradd --system --home-dir /nonexistent --no-create-home --shell /usr/sbin/nologin freelsd
  fi
  setting[server]="${setting[server]:-$(command -v freelsd-server || true)}"
  if [ -n "${setting[server]}" ]; then return; fi
  begin "building the server"
  cd "$deploy/.."
  # shellcheck disable=SC2119
  install_packages
  build release freelsd-server freelsd_web
  setting[server]="$PWD/build/release/server/freelsd-server"
  if has_systemd; then
    cmake --install build/release --prefix /usr/local --strip >/dev/null
    setting[server]=/usr/local/bin/freelsd-server
  fi
}

make_folders() {
  local server_user="freelsd" database_user="postgres"
  make_folder "$root" 755 "$(id -un)"
  make_folder "$root/secrets" 711 "$(id -un)"
  make_folder "$root/secrets/tls" 711 "$(id -un)"
  make_folder "$root/run" 755 "$(id -un)"
  make_folder "$root/log" 755 "$(id -un)"
  make_folder "$root/socket" 755 "$database_user"
  make_folder "$root/archive" 700 "$database_user"
  make_folder "$root/backups" 700 "$database_user"
  make_folder "$root/images" 750 "$server_user"
  make_folder "$root/servers" 750 "$server_user"
  make_folder "$root/nginx" 750 "$server_user"
}

up() {
  install_what_is_missing
  begin "setting up"
  make_folders
  write_settings
  make_cluster
  write_server_settings
  write_nginx_settings
  if has_systemd; then
    start_units
  elif [ -n "${given[foreground]:-}" ]; then
    supervise_all
    return
  else
    start_supervisor
  fi
  await_fleet
  status
  say_how_to_use
}

say_how_to_use() {
  echo
  echo "https://localhost:${setting[port]}/ with the token in $root/secrets/token:"
  echo "  CURL_CA_BUNDLE=$root/secrets/tls/certificate.pem freelsdctl --url https://localhost:${setting[port]}" \
    "--token $root/secrets/token flights"
}

await_fleet() {
  local _ name
  for name in $(server_names); do
    for _ in $(seq 300); do
      if is_ready "$name"; then continue 2; fi
      sleep 0.1
    done
    tail -n 3 "$root/log/$name.log" 2>/dev/null >&2 || true
    fail "$name is not ready after 30 s"
  done
}

stop() {
  if has_systemd; then systemctl stop freelsd-fleet.target freelsd-fleet-database.service; else stop_supervisor; fi
  echo "stopped"
}

# status: a line for each process.
status() {
  local name result=0
  if cluster_answers; then echo "database     answers"; else echo "database     DOES NOT ANSWER" && result=1; fi
  for name in $(server_names); do
    if is_ready "$name"; then printf '%-12s ready\n' "$name"; else printf '%-12s NOT READY\n' "$name" && result=1; fi
  done
  if curl -fskS -m 3 -o /dev/null "https://localhost:${setting[port]}/healthz" 2>/dev/null; then
    echo "nginx        answers"
  else
    echo "nginx        DOES NOT ANSWER"
    result=1
  fi
  if cluster_answers; then tell_of_work; fi
  return "$result"
}

declare -A given=()
words=()
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --foreground) given[foreground]=yes ;;
    --root) root="$(realpath -m "${2:?--root needs a folder}")"; shift ;;
    --to) given[to]="${2:?--to needs a time}"; shift ;;
    --port | --internal-port | --workers | --host | --server)
      key="${1#--}"
      setting[$key]="${2:?$1 needs a value}"
      given[$key]=yes
      shift ;;
    -*) usage >&2; fail "unknown option $1" ;;
    *) words+=("$1") ;;
  esac
  shift
done
read_settings
if [ "${words[0]:-}" != up ] && [ "${#words[@]}" -gt 0 ] && [ ! -e "$root/settings" ]; then fail "there is no fleet in $root"; fi
for key in port internal-port workers; do
  [[ "${setting[$key]}" =~ ^[1-9][0-9]{0,4}$ ]] || fail "--$key must be a number, not \"${setting[$key]}\""
done
case "${words[0]:-} ${#words[@]}" in
  "up 1") up ;;
  "status 1") status || exit 1 ;;
  "stop 1") stop ;;
  "backup 1") backup ;;
  "restore 2") restore "${words[1]}" ;;
  *) usage >&2; exit 2 ;;
esac

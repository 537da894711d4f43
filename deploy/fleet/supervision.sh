# shellcheck shell=bash disable=SC2154
# Keeps the processes of a fleet running: by systemd, or by a supervisor of its own. To be sourced by fleet.sh.

# --- systemd ---

write_database_unit() {
  cat >/etc/systemd/system/freelsd-fleet-database.service <<END
[Unit]
Description=freelsd fleet, database
After=local-fs.target network.target

[Service]
User=postgres
ExecStart=$programs/postgres -D $root/database
ExecReload=/bin/kill -HUP \$MAINPID
KillMode=mixed
KillSignal=SIGINT
TimeoutStopSec=120
TimeoutStartSec=600
Restart=on-failure
OOMScoreAdjust=-900

[Install]
WantedBy=freelsd-fleet.target
END
  systemctl daemon-reload
}

# The service's own unit, with another command and user.
write_server_unit() {
  sed -e "s|^Description=.*|Description=freelsd fleet, %i|" \
    -e "s|^After=.*|After=freelsd-fleet-database.service|" -e "/^\[Unit\]/aPartOf=freelsd-fleet.target" \
    -e "s|^ExecStart=.*|ExecStart=${setting[server]} --config $root/servers/%i.json|" \
    -e "s|^DynamicUser=.*|User=freelsd|" -e "/^StateDirectory/d" \
    -e "s|^PrivateTmp=.*|&\nReadWritePaths=$root/servers $root/images|" \
    -e "/^\[Service\]/aEnvironment=PGPASSFILE=$root/secrets/server.pass" \
    -e "s|^WantedBy=.*|WantedBy=freelsd-fleet.target|" "$deploy/freelsd.service"
}

write_nginx_unit() {
  cat <<END
[Unit]
Description=freelsd fleet, nginx
After=network.target
PartOf=freelsd-fleet.target

[Service]
User=freelsd
AmbientCapabilities=CAP_NET_BIND_SERVICE
NoNewPrivileges=yes
ProtectSystem=strict
ReadWritePaths=$root/nginx
PrivateTmp=yes
ExecStart=/usr/sbin/nginx -e stderr -c $root/nginx/nginx.conf
Restart=on-failure
RestartSec=1

[Install]
WantedBy=freelsd-fleet.target
END
}

start_units() {
  local units=(freelsd-fleet-database.service freelsd-fleet-nginx.service) name folder=/etc/systemd/system
  write_server_unit >"$folder/freelsd-fleet@.service"
  write_nginx_unit >"$folder/freelsd-fleet-nginx.service"
  printf '[Unit]\nDescription=freelsd fleet\n[Install]\nWantedBy=multi-user.target\n' >"$folder/freelsd-fleet.target"
  for name in $(server_names); do units+=("freelsd-fleet@$name.service"); done
  systemctl daemon-reload
  systemctl enable freelsd-fleet.target "${units[@]}"
  systemctl restart "${units[@]:1}"
  systemctl start freelsd-fleet.target
}

# --- The supervisor ---

supervisor() { cat "$root/run/supervisor.pid" 2>/dev/null; }
is_supervised() {
  local pid
  pid="$(supervisor)" && kill -0 "$pid" 2>/dev/null && grep -qa fleet.sh "/proc/$pid/cmdline"
}

# keep NAME COMMAND...: starts it again a second after it ended; not with wrong settings.
keep() {
  local name="$1" child="" status
  shift
  trap 'kill "$child" 2>/dev/null || true; wait "$child" 2>/dev/null || true; exit 0' TERM
  while true; do
    "$@" >>"$root/log/$name.log" 2>&1 &
    child=$!
    echo "$child" >"$root/run/$name.pid"
    status=0
    wait "$child" || status=$?
    echo "fleet.sh: $name ended with status $status" >>"$root/log/$name.log"
    if [ "$status" -eq 78 ]; then return; fi
    sleep 1 &
    wait $!
  done
}

# run_as USER COMMAND...: in place of the shell that runs it, so that its process is the command's.
run_as() {
  local name="$1"
  shift
  if is_root; then
    exec setpriv --reuid="$name" --regid="$(id -g "$name")" --clear-groups env HOME="$root" "$@"
  fi
  exec env "$@"
}

run_server() { run_as freelsd PGPASSFILE="$root/secrets/server.pass" "${setting[server]}" --config "$root/servers/$1.json"; }
run_nginx() { run_as freelsd /usr/sbin/nginx -e stderr -c "$root/nginx/nginx.conf"; }

# A database that ended is started again.
keep_database() {
  while sleep 1; do
    if [ ! -e "$root/database/postmaster.pid" ] || ! cluster_answers; then start_cluster || true; fi
  done
}

# Until a signal comes; the database stops last.
supervise_all() {
  local name kept=()
  echo $BASHPID >"$root/run/supervisor.pid"
  trap 'trap "" TERM INT; kill "${kept[@]}" 2>/dev/null || true; wait || true; stop_cluster || true; rm -f "$root/run/supervisor.pid"; exit 0' TERM INT
  for name in $(server_names); do
    keep "$name" run_server "$name" &
    kept+=($!)
  done
  keep nginx run_nginx &
  kept+=($!)
  keep_database &
  kept+=($!)
  wait
}

start_supervisor() {
  stop_servers_of_supervisor
  setsid "$deploy/fleet.sh" up --root "$root" --foreground >"$root/log/supervisor.log" 2>&1 </dev/null &
}

# The database stays.
stop_servers_of_supervisor() {
  local pid _
  if ! is_supervised; then return 0; fi
  pid="$(supervisor)"
  kill "$pid"
  for _ in $(seq 300); do
    if ! kill -0 "$pid" 2>/dev/null; then return; fi
    sleep 0.1
  done
  fail "the supervisor (process $pid) did not stop within 30 s"
}

stop_supervisor() {
  stop_servers_of_supervisor
  stop_cluster
}

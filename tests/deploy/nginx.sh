#!/usr/bin/env bash
# deploy/nginx.conf in front of a server with tokens: what passes, and what nginx keeps away.
#
#   tests/deploy/nginx.sh FREELSD_SERVER MODEL [NGINX]
#
# Needs nginx, openssl and curl; installs nothing, and listens on free loopback ports only.
set -Eeuo pipefail
server="$(realpath "$1")"
model="$(realpath "$2")"
nginx="${3:-nginx}"
root="$(cd "$(dirname "$0")/../.." && pwd)"
work="$(mktemp -d)"
program="nginx.sh"
source "$root/deploy/steps.sh"
trap clear_away EXIT

# Waits until a file has a line that matches.
await_line() {
  local _
  for _ in $(seq 200); do
    if grep -q "$2" "$1" 2>/dev/null; then return; fi
    sleep 0.05
  done
  fail "no line $2 in $1: $(cat "$1")"
}

start_server() {
  local hash
  hash="$(printf secret | sha256sum | cut -d' ' -f1)"
  (umask 077 && echo "[{\"sha256\":\"$hash\",\"scopes\":[\"read\",\"ingest\"]}]" >"$work/tokens.json")
  "$server" --data "$work/data" --listen 127.0.0.1:0 --emergency-listen 127.0.0.1:0 \
    --model "$model" --token-file "$work/tokens.json" >"$work/server.log" 2>&1 &
  pids+=($!)
  await_line "$work/server.log" 'emergency recall on'
  main_port="$(sed -n 's|.*listens on http://127.0.0.1:\([0-9]*\)/.*|\1|p' "$work/server.log")"
  emergency_port="$(sed -n 's|.*emergency recall on http://127.0.0.1:\([0-9]*\)/.*|\1|p' "$work/server.log")"
}

start_nginx() {
  openssl req -x509 -newkey rsa:2048 -nodes -keyout "$work/key.pem" -out "$work/certificate.pem" \
    -days 2 -subj /CN=localhost 2>/dev/null
  https_port="$(free_port 18443)"
  sed -e "s|/etc/freelsd/tls|$work|; s|listen 443 ssl|listen 127.0.0.1:$https_port ssl|" \
    -e "/listen \[::\]/d; s|127.0.0.1:8080|127.0.0.1:$main_port|; s|127.0.0.1:8081|127.0.0.1:$emergency_port|" \
    "$root/deploy/nginx.conf" >"$work/freelsd.conf"
  cat >"$work/nginx.conf" <<END
daemon off; pid $work/pid; error_log $work/error.log;
events { worker_connections 2048; }
http {
  access_log off;
  client_body_temp_path $work/body; proxy_temp_path $work/proxy; fastcgi_temp_path $work/fastcgi;
  uwsgi_temp_path $work/uwsgi; scgi_temp_path $work/scgi;
  include $work/freelsd.conf;
}
END
  "$nginx" -c "$work/nginx.conf" &
  pids+=($!)
  local _
  for _ in $(seq 200); do
    if [ "$(status /healthz)" = 200 ]; then return; fi
    sleep 0.05
  done
  fail "nginx does not answer: $(cat "$work/error.log")"
}

# Status of a request to a path, with more arguments for curl.
status() {
  local path="$1"
  shift
  curl -sk -o "$work/answer" -w '%{http_code}' "$@" "https://localhost:$https_port$path" || true
}

expect() {
  local wanted="$1" what="$2" got
  shift 2
  got="$(status "$@")"
  [ "$got" = "$wanted" ] || fail "$what: $got instead of $wanted"
  echo "$what: $got"
}

start_server
start_nginx
token=(-H 'Authorization: Bearer secret')
place='latitude_deg=47&longitude_deg=8&altitude_m=900'
expect 401 "a request without token" /v1/flights
expect 200 "the same with token" /v1/flights "${token[@]}"
expect 403 "deleting with a token that may not" /v1/sites/none "${token[@]}" -X DELETE
expect 200 "recall, from its own listener" "/v1/emergency?$place" "${token[@]}"
expect 201 "a new flight" /v1/flights "${token[@]}" -d '{"name":"a test"}'
head -c 5000 /dev/zero | tr '\0' a >"$work/long"
expect 400 "a header that is too long" /healthz -H "X-Long: $(cat "$work/long")"
truncate -s 40M "$work/large"
expect 413 "a body that is too large" /v1/flights "${token[@]}" --data-binary "@$work/large"
expect 404 "a stream to no flight" /v1/flights/none/stream "${token[@]}" \
  -H 'Content-Type: multipart/mixed; boundary=x' -d '--x--'

# Clients that never end their heads hold sockets of nginx, not threads of the server.
for _ in $(seq 60); do
  (
    printf 'GET /healthz HTTP/1.1\r\nHost: localhost\r\n'
    sleep 4
  ) | openssl s_client -quiet -connect "localhost:$https_port" >/dev/null 2>&1 &
done
expect 200 "health while 60 clients send slow heads" /healthz
echo "nginx.sh: everything has passed"

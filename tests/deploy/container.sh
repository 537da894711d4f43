#!/usr/bin/env bash
# The container image: at most 600 MB, serves read-only, without capabilities and not as root, keeps what it stored;
# then the same behind nginx by compose.yaml. What cannot be done here is said as "skipped: why"
# (status 77 if there is no container daemon).
#
#   tests/deploy/container.sh
set -Eeuo pipefail
cd "$(dirname "$0")/../.."
max_image_bytes=600000000
image=freelsd-test
volume="freelsd-test-$$"
project="freelsd-test-$$"
container=""
work="$(mktemp -d)"

skip() { echo "skipped: $1"; }
fail() {
  echo "container.sh: $1" >&2
  if [ -n "$container" ]; then docker logs "$container" >&2 || true; fi
  exit 1
}

compose() { docker compose -p "$project" -f deploy/compose.yaml "$@"; }

end() {
  if [ -n "$container" ]; then docker rm -f "$container" >/dev/null 2>&1 || true; fi
  docker volume rm -f "$volume" >/dev/null 2>&1 || true
  if [ -n "${FREELSD_SECRETS:-}" ]; then compose down -v >/dev/null 2>&1 || true; fi
  rm -rf "$work"
}

# What the container's own curl gets.
ask() { docker exec "$container" curl -fsS "$@"; }

start() {
  container="$(docker run -d --read-only --tmpfs /tmp --cap-drop ALL --security-opt no-new-privileges \
    -v "$volume:/var/lib/freelsd" "$image")"
  local _
  for _ in $(seq 100); do
    if ask http://127.0.0.1:8080/healthz >/dev/null 2>&1; then return; fi
    sleep 0.2
  done
  fail "the server in the container does not answer"
}

check_image() {
  docker build -t "$image" -f deploy/Dockerfile .
  local bytes
  bytes="$(docker image inspect -f '{{.Size}}' "$image")"
  echo "image: $bytes bytes"
  [ "$bytes" -le "$max_image_bytes" ] || fail "the image is larger than $max_image_bytes bytes"
  start
  [ "$(docker exec "$container" id -u)" != 0 ] || fail "it runs as root"
  if docker exec "$container" touch /usr/local/here 2>/dev/null; then fail "its root can be written"; fi
  ask http://127.0.0.1:8080/ | grep -q '<title>' || fail "there is no page"
  ask -d '{"name": "kept"}' http://127.0.0.1:8080/v1/flights >/dev/null
  docker exec "$container" freelsdctl flights | grep -q ' kept$' || fail "freelsdctl does not work in it"
  docker stop -t 15 "$container" >/dev/null
  [ "$(docker inspect -f '{{.State.ExitCode}}' "$container")" = 0 ] || fail "it did not stop cleanly"
  docker rm "$container" >/dev/null
  start
  ask http://127.0.0.1:8080/v1/flights | grep -q kept || fail "what was stored is gone with the container"
  docker rm -f "$container" >/dev/null
  container=""
  echo "image: serves read-only and not as root, keeps what it stored"
}

check_compose() {
  if ! docker compose version >/dev/null 2>&1; then
    skip "compose, it is not installed"
    return
  fi
  if [ "$(id -u)" -ne 0 ]; then
    skip "compose: its secrets need other owners, and this is not root"
    return
  fi
  export FREELSD_SECRETS="$work" FREELSD_HTTPS_PORT=18443
  mkdir "$work/tls"
  openssl req -x509 -newkey rsa:2048 -nodes -keyout "$work/tls/key.pem" -out "$work/tls/certificate.pem" \
    -days 2 -subj /CN=localhost 2>/dev/null
  printf '[{"sha256": "%s", "scopes": ["read"]}]' "$(printf secret | sha256sum | cut -d' ' -f1)" >"$work/tokens.json"
  echo '{"allowed_hosts": ["field.example"]}' >"$work/config.json"
  chmod 755 "$work"
  chmod 600 "$work/tokens.json" "$work/tls/key.pem"
  chown 10001 "$work/tokens.json"
  chown -R 101 "$work/tls"
  compose up -d --build --wait
  local url="https://127.0.0.1:$FREELSD_HTTPS_PORT"
  curl -fsSk "$url/healthz" >/dev/null || fail "nginx does not pass requests on"
  [ "$(curl -sk -o /dev/null -w '%{http_code}' "$url/v1/flights")" = 401 ] || fail "no token is wanted"
  curl -fsSk -H 'Authorization: Bearer secret' -H 'Host: field.example' "$url/v1/flights" >/dev/null ||
    fail "a listed host with a token is refused"
  echo "compose: nginx before the server, tokens wanted"
}

if ! docker info >/dev/null 2>&1; then
  skip "the container, no container daemon at hand"
  exit 77
fi
trap end EXIT
check_image
check_compose
echo "container.sh: everything that ran has passed"

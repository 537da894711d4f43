# shellcheck shell=bash disable=SC2154
# The servers of a fleet and nginx in front of them. To be sourced by fleet.sh.

server_names() {
  seq -f 'api-%g' "$num_apis"
  seq -f 'worker-%g' "${setting[workers]}"
}

# port_of NAME: of the server's listener.
port_of() {
  local first="${setting[internal-port]}"
  case "$1" in
    api-*) echo $((first + ${1#api-})) ;;
    worker-*) echo $((first + 9 + ${1#worker-})) ;;
  esac
}
emergency_port_of() { echo $(($(port_of "$1") + num_apis)); }

# ask_server PORT PATH: the token goes through stdin, so that ps cannot show it.
ask_server() {
  curl -fsS -m 3 -H @- "http://127.0.0.1:$1$2" <<<"Authorization: Bearer $(cat "$root/secrets/token")" 2>/dev/null
}

is_ready() { ask_server "$(port_of "$1")" /readyz >/dev/null; }

# The clients' token is made once; more are added to tokens.json by hand.
write_tokens() {
  local hash
  random_word | write_secret token "$(id -un)"
  hash="$(tr -d '\n' <"$root/secrets/token" | sha256sum | cut -d' ' -f1)"
  printf '[{"sha256": "%s", "scopes": ["read", "ingest", "admin"]}]\n' "$hash" | write_secret tokens.json freelsd
}

# Where no certificate was put, one that signs itself.
write_certificate() {
  if [ ! -e "$root/secrets/tls/key.pem" ]; then
    openssl req -x509 -newkey rsa:2048 -nodes -days 825 -subj "/CN=${setting[host]}" \
      -addext "subjectAltName=DNS:${setting[host]},DNS:localhost" -keyout "$root/secrets/tls/key.pem" \
      -out "$root/secrets/tls/certificate.pem" 2>"$root/log/certificate.log"
  fi
  chmod 600 "$root/secrets/tls/key.pem"
  chmod 644 "$root/secrets/tls/certificate.pem"
  if is_root; then chown freelsd "$root/secrets/tls/key.pem"; fi
}

write_server_settings() {
  local name kind
  write_tokens
  write_certificate
  for name in $(server_names); do
    kind="${name%-*}"
    jq -n --arg data "$root/servers/$name" --arg images "$root/images" --arg role "$kind" \
      --arg database "postgresql://$role@127.0.0.1:$(database_port)/$database" \
      --arg listen "127.0.0.1:$(port_of "$name")" --arg emergency "127.0.0.1:$(emergency_port_of "$name")" \
      --arg tokens "$root/secrets/tokens.json" --arg host "${setting[host]}" \
      '{data: $data, database: $database, images: $images, role: $role, listen: $listen, token_file: $tokens,
        allowed_hosts: [$host]} +
        if $role == "api" then {emergency_listen: $emergency, num_http_threads: 512, recall_cache_mib: 1024} else {} end' \
      >"$root/servers/$name.json"
    make_folder "$root/servers/$name" 750 freelsd
  done
}

# The template's words in braces, and what a container's nginx brings itself.
write_nginx_settings() {
  local name
  sed -e "s|\${FREELSD_HTTPS}|${setting[port]}|; s|\${FREELSD_TLS}|$root/secrets/tls|" \
    -e "s|\${FREELSD_API_1}|127.0.0.1:$(port_of api-1)|; s|\${FREELSD_API_2}|127.0.0.1:$(port_of api-2)|" \
    -e "s|\${FREELSD_EMERGENCY_1}|127.0.0.1:$(emergency_port_of api-1)|" \
    -e "s|\${FREELSD_EMERGENCY_2}|127.0.0.1:$(emergency_port_of api-2)|" \
    "$deploy/fleet/nginx.conf.template" >"$root/nginx/fleet.conf"
  cat >"$root/nginx/nginx.conf" <<END
daemon off;
pid $root/nginx/pid;
error_log stderr;
worker_processes auto;
events { worker_connections 4096; }
http {
  access_log off;
$(for name in client_body proxy fastcgi uwsgi scgi; do echo "  ${name}_temp_path $root/nginx/$name;"; done)
  include $root/nginx/fleet.conf;
}
END
}

# shellcheck shell=bash
# The parts of deploy/test.sh --long: which folders ask for them, and the register of their last runs. To be sourced
# after steps.sh.

readonly register=tests/LONG.md

# A part and the paths it tests: where they have changed, it is asked for.
list_parts() {
  cat <<'PARTS'
arm64            engine api deploy/arm64 deploy/arm64.sh tests/deploy/arm64.sh CMakeLists.txt
autopilot        server/mavlink server/links server/handlers/links tests/autopilot
container        deploy/Dockerfile deploy/compose.yaml deploy/packages.txt tests/deploy/container.sh
documents        README.md api deploy/README.md engine/README.md tests/deploy/documents.sh
edges            server/following server/recall storage tests/deploy/edge.sh tests/server/following
evaluation       engine server/training tests/evaluation tests/synthetic
faults           server storage tests/faults
fleet-faults     server storage/postgres deploy/fleet.sh tests/faults
freelsdctl       deploy/freelsdctl api server/handlers tests/deploy/freelsdctl.sh
fuzz             api engine/classification server/http server/intake tests/fuzz
lint             engine storage api server tests .clang-tidy
manuals          deploy/*.1 deploy/*.8
move             deploy/fleet.md server/following server/sharing storage tests/deploy/move_to_postgresql.sh
nginx            deploy/nginx.conf server/http tests/deploy/nginx.sh
odr              engine storage api server tests CMakePresets.json
package          CMakeLists.txt server/mavlink web deploy/debian deploy/*.cmake deploy/*.service deploy/package.sh tests/deploy/package.sh
postgresql       storage server/sharing tests/deploy/postgresql.sh
postgresql-tests storage server tests/storage tests/server
roles            storage/postgres server/jobs server/sharing tests/deploy/roles.sh
sanitizers       engine storage api tests/engine tests/storage tests/api CMakePresets.json
threads          server tests/server tests/sanitizers CMakePresets.json
units            deploy/*.service
PARTS
}

part_names() { list_parts | awk '{ print $1 }'; }
is_part() { part_names | grep -qxF -- "$1"; }

# The revision that is tested; + for changes that are not committed.
tested_revision() {
  local revision
  revision="$(git rev-parse --short HEAD 2>/dev/null)" || revision=unknown
  if ! git diff --quiet HEAD -- . ":!$register" 2>/dev/null; then revision+="+"; fi
  echo "$revision"
}

# record PART MINUTES RESULT: its row in the register, instead of the former one.
record() {
  local row rows
  row="| $1 | $(tested_revision) | $(date -u +%F) | $2 | ${3//|/ } |"
  rows="$(awk -F ' *[|] *' -v part="$1" '/^\|/ && $2 != "part" && $2 !~ /^-/ && $2 != part' "$register" || true)"
  {
    echo "# Long tests"
    echo
    echo "When each part of \`deploy/test.sh --long\` has run last. It writes this table."
    echo
    echo "| part | revision | date | minutes | result |"
    echo "|---|---|---|---|---|"
    printf '%s\n' "$rows" "$row" | grep . | LC_ALL=C sort
  } >"$register.new"
  mv "$register.new" "$register"
}

# last_run PART
last_run() {
  awk -F ' *[|] *' -v part="$1" '
    $2 == part { print $4 ", " $3 ", " $5 " min, " $6; found = 1 }
    END { if (!found) print "never run" }' "$register" 2>/dev/null || echo "never run"
}

# The parts that what has changed asks for, and when each has run last.
print_asked_parts() {
  local since part paths
  if ! since="$(first_revision 2>/dev/null)"; then
    echo "no history of git at hand, so what changed is unknown: deploy/test.sh --long runs everything"
    return
  fi
  echo "changes since $(git log -1 --format='%h, %cs' "$since") ask for these parts (deploy/test.sh --long PART...):"
  set -f
  while read -r part paths; do
    # shellcheck disable=SC2086
    if ! git diff --quiet "$since" -- $paths; then printf '%-17s %s\n' "$part" "$(last_run "$part")"; fi
  done < <(list_parts)
  set +f
}

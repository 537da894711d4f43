#!/usr/bin/env bash
# Checks the sources against the rules that a program can check.
#
#   deploy/lint.sh [--seconds N] [REVISION]   clang-tidy on what changed since REVISION: by default the last tag, or
#                                             else 20 commits ago
#   deploy/lint.sh --all                      clang-tidy on every file
#
# Both forms check format, length of files, number of files in a folder and comments of mutexes everywhere.
# The first form starts no clang-tidy after 5 minutes, or N seconds. It takes the newest commits' files first, and lists
# what it leaves out. Status 0 means no findings.
set -Eeuo pipefail
cd "$(dirname "$0")/.."
# shellcheck disable=SC2034
program="lint.sh"
source deploy/steps.sh

readonly max_file_lines=400
# 16 units of a header and a source, and the folder's own header and main program.
readonly max_folder_files=34
max_tidy_seconds=300
if [ "${1:-}" = --seconds ]; then
  max_tidy_seconds="${2:?--seconds needs a number}"
  shift 2
fi

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
readonly database="build/lint"
num_findings=0

# Files that git knows or that are new, by pattern; what is deleted but not committed is not among them.
source_files() {
  local file
  git ls-files --cached --others --exclude-standard -- "$@" | sort -u | while read -r file; do
    if [ -f "$file" ]; then echo "$file"; fi
  done
}

# report RULE COMMAND...: each line that the command prints is a finding.
report() {
  local rule="$1"
  shift
  local lines
  lines="$("$@")"
  if [ -z "$lines" ]; then
    echo "$rule: no findings"
    return
  fi
  local count
  count="$(wc -l <<<"$lines")"
  echo "$lines"
  echo "$rule: $count findings"
  num_findings=$((num_findings + count))
}

misformatted() {
  source_files '*.cc' '*.h' | xargs clang-format --dry-run --Werror 2>&1 | grep -F ': error: ' || true
}

long_files() {
  source_files '*.cc' '*.h' '*.js' '*.mjs' '*.css' '*.py' '*.sh' | xargs wc -l |
    awk -v most="$max_file_lines" '$2 != "total" && $1 > most { print $2 ": " $1 " lines, at most " most }'
}

full_folders() {
  source_files '*.cc' '*.h' | xargs -n 1 dirname | sort | uniq -c |
    awk -v most="$max_folder_files" '$1 > most { print $2 "/: " $1 " sources, at most " most }'
}

# A mutex's comment stands behind it or in the lines right above, and says what the mutex guards.
silent_mutexes() {
  source_files '*.cc' '*.h' | xargs awk '
    FNR == 1 { comment = "" }
    /std::([a-z]+_)*mutex [A-Za-z_0-9]+;/ && tolower(comment $0) !~ /guards/ {
      print FILENAME ":" FNR ": the comment of a mutex says what the mutex guards"
    }
    { comment = /^ *\/\// ? comment $0 : "" }
  '
}

# Sources and headers that changed since the revision, the newest first.
changed_files() {
  {
    git diff --name-only HEAD
    git ls-files --others --exclude-standard
    git log --first-parent -m --format= --name-only "$1..HEAD"
  } | awk '/\.(cc|h)$/ && !seen[$0]++' | while read -r file; do
    if [ -f "$file" ]; then echo "$file"; fi
  done
}

# A source that includes the header: its own, its test, any other, or one that includes a header that includes it; or
# else the header itself.
source_of() {
  local candidate
  for candidate in "${1%.h}.cc" "tests/${1%.h}_test.cc" $(git grep -l -F "#include \"$1\"" -- '*.cc' || true); do
    if [ -f "$candidate" ]; then
      echo "$candidate"
      return
    fi
  done
  local includer
  includer="$(git grep -l -F "#include \"$1\"" -- '*.h' | head -n 1 || true)"
  if [ -n "$includer" ]; then source_of "$includer"; else echo "$1"; fi
}

# The input's files as what clang-tidy reads: every file is in one of them.
units() {
  local file
  while read -r file; do
    if [[ "$file" == *.h ]]; then source_of "$file"; else echo "$file"; fi
  done | awk '!seen[$0]++'
}

# Flags of each source, once. They are clang's, as clang-tidy is, and g++'s precompiled headers are not for it.
configure_tidy() {
  cmake --preset release -B "$database" -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_COMPILER_LAUNCHER= -DCMAKE_UNITY_BUILD=OFF \
    -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >"$work/cmake.log" 2>&1 || {
    cat "$work/cmake.log" >&2
    fail "CMake could not configure $database"
  }
  jq 'unique_by(.file)' "$database/compile_commands.json" >"$work/compile_commands.json"
}

# tidy UNIT: appends its findings, a line each, to work/findings.
tidy() {
  if [ "$(date +%s)" -ge "$deadline" ]; then
    echo "$1" >>"$work/left_out"
    return
  fi
  local log
  log="$(mktemp -p "$work")"
  if clang-tidy -p "$work" --quiet "$1" >"$log" 2>"$log.errors"; then return; fi
  if ! grep -E ': (error|warning): ' "$log" >>"$work/findings"; then
    { echo "it ended without a finding"; cat "$log.errors"; } | sed "s|^|$1: clang-tidy failed: |" >>"$work/findings"
  fi
}

# Reads the units' names. A header's finding comes from every unit that includes it and counts once.
tidy_findings() {
  : >"$work/findings"
  : >"$work/left_out"
  export work deadline
  export -f tidy
  xargs -r -P "$(nproc)" -n 1 bash -c 'tidy "$1"' tidy <"$work/units"
  sed "s|^$PWD/||" "$work/findings" | sort -u | tee "$work/tidy_findings"
}

started="$(date +%s)"
deadline=$((started + max_tidy_seconds))
for tool in clang-format clang-tidy clang++ cmake jq; do
  command -v "$tool" >/dev/null || fail "$tool is missing: see deploy/packages.txt"
done
if [ "${1:-}" = --all ]; then
  deadline=$((started + 1000000))
  source_files '*.cc' '*.h' >"$work/files"
  since="all files"
else
  revision="$(git rev-parse --verify --quiet "${1:-$(first_revision)}^{commit}")" || fail "no such revision: ${1:-}"
  changed_files "$revision" >"$work/files"
  since="files changed since $(git log -1 --format='%h, %cs' "$revision")"
fi

report "format" misformatted
report "length of files" long_files
report "files in a folder" full_folders
report "comments of mutexes" silent_mutexes

configure_tidy
units <"$work/files" >"$work/units"
echo "clang-tidy: $since, $(wc -l <"$work/units") of them to be read"
report "clang-tidy" tidy_findings
sed -nE 's/.*\[([a-zA-Z.-]+).*\]$/\1/p' "$work/tidy_findings" | sort | uniq -c | sort -rn

num_left_out="$(wc -l <"$work/left_out")"
if [ "$num_left_out" -ne 0 ]; then
  sed 's/^/left out: /' "$work/left_out"
  echo "skipped: clang-tidy of $num_left_out older files, more than $max_tidy_seconds s of work: deploy/lint.sh --all reads them"
fi
minutes="$(awk -v s=$(($(date +%s) - started)) 'BEGIN { printf "%.1f", s / 60 }')"
if [ "$num_findings" -ne 0 ]; then fail "$num_findings findings in $minutes minutes"; fi
echo "lint.sh: everything that ran has passed, $(($(wc -l <"$work/units") - num_left_out)) files read in $minutes minutes"

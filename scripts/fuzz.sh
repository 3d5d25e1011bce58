#!/usr/bin/env bash
# Builds the fuzz targets and runs each one from the seeds in fuzz/corpus, one process per processor.
#
#   scripts/fuzz.sh SECONDS [TARGET…]
#
# An input that crashes, takes more than 5 seconds or needs more than 256 MiB is shown and stored in
# fuzz/artifacts; then the exit status is not 0. Other new inputs are discarded. Installs cargo-fuzz if it
# is missing. Needs a C++ compiler.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?usage: scripts/fuzz.sh SECONDS [TARGET…]}
shift

# Without a sanitizer, stable Rust is enough.
export CARGO_TARGET_DIR="$PWD/target/fuzz"
cargo fuzz --version >/dev/null 2>&1 || cargo install cargo-fuzz --locked
cargo fuzz build -s none 2>&1 | tail -n 3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

run() {
  local log="$work/$1.log"
  mkdir "$work/$1"
  if cargo fuzz run -s none "$1" "$work/$1" "fuzz/corpus/$1" -- \
    -max_total_time="$seconds" -timeout=5 -rss_limit_mb=1024 -dict=fuzz/words.dict >"$log" 2>&1; then
    printf '%-12s %s\n' "$1" "$(grep '^Done' "$log")"
  else
    printf '== %s failed:\n%s\n' "$1" "$(tail -n 100 "$log")" >&2
    return 1
  fi
}
export -f run
export work seconds

[ $# -gt 0 ] || mapfile -t targets < <(cargo fuzz list)
printf '%s\n' "${@:-${targets[@]}}" | xargs -P "$(nproc)" -I '{}' bash -c 'run {}'

#!/usr/bin/env bash
# Measures the tables of docs/benchmarks.md one after the other: figures of one machine, one version and one day.
#
#   scripts/benchmarks.sh OUT [TABLE…]
#
# The tables, the variables that name their inputs, and hours on 2 cores:
#
#   grids      grid worlds by both engines, `check` as a process                                        0.7
#   fleet      models/fleet.prism by both engines                                                       0.1
#   quantities `values --all` and `check` on grid worlds                                                0.2
#   networks   NETWORKS, a checkout of biodivine-boolean-models; PEER, a command (may be missing)       0.4
#   own        PERF, a folder or file as of compare_peers.py; BEFORE, an older binary (may be missing)  0.2
#   dd         PERF and stormpy: Storm's diagrams                                                       0.8
#   sparse     PERF and stormpy: Storm's sparse engine                                                  0.4
#   prism      PERF and PRISM, an installation                                                          1.5
#   robots     grid worlds without battery and Storm's two engines                                      0.2
#   games      GAMES, the folder of compare_games.py; PRISM_GAMES, an installation                      0.8
#   numbers    PERF and stormpy: probabilities against Storm                                            0.5
#   qvbs       QVBS, the folder `benchmarks` of the set; QVBS_MODELS, its JANI files, and stormpy
#              (both may be missing)                                                                    0.5
#
# MELIORA is the binary (default: target/release/meliora, which is built), PYTHON the interpreter with stormpy
# (default: python3). OUT gets NAME.csv or NAME.md of each table, its log, and the machine. A table that OUT has
# already is not measured again, so an interrupted run is continued by the same command. A table without its
# inputs is skipped by name. Nothing else should run on the machine: the load is written before each table.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?usage: scripts/benchmarks.sh OUT [TABLE…]}
shift
mkdir -p "$out"
out=$(cd "$out" && pwd)
python=${PYTHON:-python3}
if [ -z "${MELIORA:-}" ]; then
  cargo build --release --locked --quiet
  MELIORA=target/release/meliora
fi
export PYTHONDONTWRITEBYTECODE=1

{
  date -u '+%F %H:%M UTC'
  uname -srm
  grep -m 1 'model name' /proc/cpuinfo || true
  echo "$(nproc) processors, $(awk '/MemTotal/ { printf "%.0f GiB", $2 / 1048576 }' /proc/meminfo)"
  "$MELIORA" --version
} >>"$out/machine.txt"

# True if the variables are set; else says which one is not.
given() {
  local name
  for name in "$@"; do
    [ -n "${!name:-}" ] || { echo "   skipped: $name is not set"; return 1; }
  done
}

storm() {
  "$python" -c 'import stormpy' 2>/dev/null || { echo "   skipped: $python has no stormpy"; return 1; }
}

# Runs a script of this folder for a table.
measure() {
  local table=$1 status=0
  shift
  "$python" "scripts/$1.py" "${@:2}" >"$out/$table.log" 2>&1 || status=$?
  if [ "$status" -eq 0 ]; then
    touch "$out/$table.done"
  else
    echo "   failed with status $status: see $out/$table.log" >&2
    failed=1
  fi
}

peers() {
  local table=$1
  shift
  measure "$table" compare_peers --corpus "$PERF" --meliora "$MELIORA" --csv "$out/$table.csv" "$@"
}

table() {
  local csv="$out/$1.csv" markdown="$out/$1.md"
  case $1 in
    grids) measure grids bench --sizes 32,64,128,256,512 --items 3,6,12 --timeout 75 --memory 16GiB --meliora "$MELIORA" \
      --csv "$csv" --markdown "$markdown" ;;
    fleet) measure fleet bench --family models/fleet.prism --prefs models/fleet.pref --const 'L={size}' \
      --sizes 1,2,3,7,63,511 --timeout 20 --meliora "$MELIORA" --csv "$csv" --markdown "$markdown" ;;
    quantities) measure quantities bench_values --sizes 16,32,64,128 --items 6 --binary "$MELIORA" --markdown "$markdown" ;;
    networks) given NETWORKS && measure networks boolean_networks "$NETWORKS" --timeout 10 --meliora "$MELIORA" \
      --csv "$csv" --markdown "$markdown" ${PEER:+--peer "$PEER"} ;;
    own) given PERF && peers own --storm none --runs 2 --timeout 60 ${BEFORE:+--before "$BEFORE"} ;;
    dd | sparse) given PERF && storm && peers "$1" --storm "$1" --runs 1 --timeout "$([ "$1" = dd ] && echo 60 || echo 30)" ;;
    prism) given PERF PRISM && peers prism --storm none --prism "$PRISM" --runs 1 --timeout 60 ;;
    robots) storm && measure robots compare_peers --gridworld 16,32,64 --items 3,6,12 --runs 1 --timeout 20 --storm dd,sparse \
      --meliora "$MELIORA" --csv "$csv" ;;
    games) given GAMES PRISM_GAMES && measure games compare_games "$GAMES" --prism-games "$PRISM_GAMES" --runs 3 \
      --meliora "$MELIORA" --csv "$csv" --table "$markdown" ;;
    numbers) given PERF && storm && measure numbers compare_values "$PERF" --timeout 30 --binary "$MELIORA" --csv "$csv" ;;
    qvbs) given QVBS && measure qvbs qvbs_values "$QVBS" --runs 1 --timeout 60 --binary "$MELIORA" --markdown "$markdown" \
      $(storm >/dev/null && echo --storm) ${QVBS_MODELS:+--models "$QVBS_MODELS"} ;;
  esac
}

all="grids fleet quantities networks own dd sparse prism robots games numbers qvbs"
# shellcheck disable=SC2086 # names without spaces
[ $# -gt 0 ] || set -- $all
for name in "$@"; do
  grep -qw -- "$name" <<<"$all" || { echo "unknown table $name; the tables are: $all" >&2; exit 2; }
done
failed=0
for name in "$@"; do
  if [ -e "$out/$name.done" ]; then
    echo "== $name: measured before"
    continue
  fi
  echo "== $name, $(date -u '+%H:%M'), load $(cut -d ' ' -f 1 /proc/loadavg)" | tee -a "$out/machine.txt"
  table "$name" || true
done
exit "$failed"

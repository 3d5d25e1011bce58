#!/usr/bin/env bash
# Checks what would be published on crates.io, without publishing:
#
#   scripts/package.sh [--check | --install] [OPTIONS OF cargo]
#
# 1. Each crate has a description, a licence, an address and a README.
# 2. `cargo package` makes the archives of all crates, in the order in which they have to be published.
# 3. With --check, `cargo check` compiles the command from the unpacked archives alone: no file is missing in them. With
#    --install, `cargo install` builds and installs it in an empty home, as a stranger would who gets the crates from the
#    registry. In both, the crates of the workspace are found among the archives, all others in the registry.
# The last lines are the order, one `cargo publish` each.
set -euo pipefail
cd "$(dirname "$0")/.."
export CARGO_TARGET_DIR="$PWD/target"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Names and folders, each crate after those that it uses. A dependency of tests has no place in the order.
order=$(cargo metadata --format-version 1 --no-deps --locked | python3 -c '
import json, sys
packages = {p["name"]: p for p in json.load(sys.stdin)["packages"] if p["publish"] != []}
for name, p in packages.items():
    lacking = [f for f in ("description", "license", "homepage", "readme") if not p[f]]
    if lacking:
        sys.exit(f"{name} has no {lacking}")
placed = {}
while len(placed) < len(packages):
    for name, p in packages.items():
        uses = {d["name"] for d in p["dependencies"] if d["kind"] != "dev" and d["name"] in packages}
        if name not in placed and uses <= placed.keys():
            placed[name] = p
for name, p in placed.items():
    print(name, p["version"])
')
cargo package --workspace --locked --no-verify --allow-dirty --quiet
while read -r name version; do
  [ -f "target/package/$name-$version.crate" ] || { echo "$name has no archive" >&2; exit 1; }
done <<<"$order"

if [ $# -gt 0 ]; then
  mode=$1
  shift
  {
    echo "[patch.crates-io]"
    while read -r name version; do
      tar -C "$work" -xzf "target/package/$name-$version.crate"
      [ "$name" = meliora ] || echo "$name = { path = \"$work/$name-$version\" }"
    done <<<"$order"
  } >"$work/patch.toml"
  command=$work/meliora-$(sed -n 's/^meliora //p' <<<"$order")
  if [ "$mode" = --check ]; then
    cargo --config "$work/patch.toml" check --manifest-path "$command/Cargo.toml" "$@"
    sed 's/^\([^ ]*\) .*/cargo publish -p \1/' <<<"$order"
    exit
  fi
  mkdir "$work/home"
  # The toolchain stays; settings, caches and installed programs are those of a new user.
  env -u CARGO_TARGET_DIR HOME="$work/home" CARGO_HOME="$work/home/cargo" RUSTUP_HOME="${RUSTUP_HOME:-$HOME/.rustup}" \
    cargo --config "$work/patch.toml" install --path "$command" --root "$work/home" --locked "$@"
  (cd "$work/home" && env -i PATH= "$work/home/bin/meliora" check "$command/models/drone.prism" "$command/models/drone.pref")
fi

sed 's/^\([^ ]*\) .*/cargo publish -p \1/' <<<"$order"

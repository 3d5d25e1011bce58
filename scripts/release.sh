#!/usr/bin/env bash
# Builds what a release holds, for the machine that it runs on:
#
#   scripts/release.sh [--profile PROFILE] [FOLDER]
#
# - meliora-VERSION-PLATFORM.tar.gz: the command, which needs no shared library on Linux, with shell
#   completions, manual pages, models, licences and the README;
# - the wheel of the Python package for CPython 3.9 and later;
# - SHA256SUMS.
#
# FOLDER is target/dist if it is not given; what an earlier run left there is replaced. PROFILE is the profile of the wheel: release,
# or dev for a test of this script. Needs Rust and Python 3.9.
set -euo pipefail
cd "$(dirname "$0")/.."
profile=release
if [ "${1:-}" = --profile ]; then
  profile=${2:?usage: scripts/release.sh [--profile PROFILE] [FOLDER]}
  shift 2
fi
mkdir -p "${1:-target/dist}"
out=$(cd "${1:-target/dist}" && pwd)
rm -f "$out"/meliora-*.tar.gz "$out"/meliora-*.whl "$out"/SHA256SUMS
platform=$(rustc -vV | sed -n 's/^host: //p')
version=$(cargo pkgid -p meliora | sed 's/.*[#@]//')
name=meliora-$version-$platform
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The flags are those of the last step, so the libraries are built once for this and for `cargo build`.
flags=(-C strip=symbols)
case $platform in *-linux-*) flags+=(-C target-feature=+crt-static) ;; esac
CARGO_TARGET_DIR="$PWD/target" cargo rustc --release --locked -p meliora --bin meliora -- "${flags[@]}"

folder=$work/$name
mkdir -p "$folder"/{completions,man,models}
cp target/release/meliora README.md CHANGELOG.md LICENSE-* "$folder"
cp models/*.prism models/*.pref models/*.jani models/*.map "$folder/models"
meliora=$folder/meliora
for shell in bash elvish fish powershell zsh; do
  "$meliora" completions "$shell" >"$folder/completions/meliora.$shell"
done
"$meliora" man >"$folder/man/meliora.1"
"$meliora" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]\+\) .*/\1/p' | while read -r command; do
  [ "$command" = help ] || "$meliora" man "$command" >"$folder/man/meliora-$command.1"
done
tar -C "$work" -czf "$out/$name.tar.gz" "$name"

maturin=target/venv/bin/maturin
if [ ! -x "$maturin" ]; then
  python3 -m venv "$work/venv"
  "$work/venv/bin/pip" install --quiet 'maturin>=1.9,<2'
  maturin=$work/venv/bin/maturin
fi
CARGO_TARGET_DIR="$PWD/target" "$maturin" build --profile "$profile" --locked --manifest-path python/Cargo.toml --out "$out"

(cd "$out" && sha256sum -- *.tar.gz *.whl >SHA256SUMS)
ls -l "$out"

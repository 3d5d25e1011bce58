#!/usr/bin/env bash
# Builds what a release holds:
#
#   scripts/release.sh [--profile PROFILE] [--targets "TARGET…"] [FOLDER]
#
# - meliora-VERSION-TARGET.tar.gz for each target: the command, which needs no shared library, with shell completions,
#   manual pages, models, the gallery, licences and the README;
# - the wheel of the Python package (`meliora-mc`, imported as `meliora`) for CPython 3.9 and later;
# - SHA256SUMS.
#
# The targets are by default x86_64-unknown-linux-musl and aarch64-unknown-linux-musl on Linux, elsewhere this machine's.
# `--targets host` builds for this machine alone, with its own C library. A target that cannot be built here is skipped,
# and the last line names it and the missing part. FOLDER is target/dist if it is not given; what an earlier run left there
# is replaced. PROFILE is the profile of the wheel: release, or dev for a test of this script. Needs Rust and Python 3.9;
# for another processor also a C compiler for it, such as aarch64-linux-gnu-gcc (Debian: gcc-aarch64-linux-gnu).
set -euo pipefail
cd "$(dirname "$0")/.."
profile=release
host=$(rustc -vV | sed -n 's/^host: //p')
targets=$host
case $host in *-linux-*) targets="x86_64-unknown-linux-musl aarch64-unknown-linux-musl" ;; esac
while [ $# -gt 1 ]; do
  case $1 in
    --profile) profile=$2 ;;
    --targets) targets=${2/#host/$host} ;;
    *) sed -n 4p "$0" >&2 && exit 2 ;;
  esac
  shift 2
done
mkdir -p "${1:-target/dist}"
out=$(cd "${1:-target/dist}" && pwd)
rm -f "$out"/meliora-*.tar.gz "$out"/meliora_mc-*.whl "$out"/SHA256SUMS
version=$(cargo pkgid -p meliora | sed 's/.*[#@]//')
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export CARGO_TARGET_DIR="$PWD/target"
skipped=()

# Prints the part that a target lacks here; nothing if it can be built.
missing() {
  [ "$1" = "$host" ] && return
  if ! [ -d "$(rustc --print sysroot)/lib/rustlib/$1" ] && ! rustup target add "$1" >/dev/null 2>&1; then
    echo "the standard library of Rust (rustup target add $1)"
  elif [ "${1%%-*}" != "${host%%-*}" ] && ! command -v "${1%%-*}-linux-gnu-gcc" >/dev/null; then
    echo "${1%%-*}-linux-gnu-gcc"
  fi
}

# Builds the command for a target, and sets `built` to its path.
build() {
  local flags=(-C strip=symbols) options=()
  built=target/release/meliora
  case $1 in
    "$host") case $1 in *-linux-*) flags+=(-C target-feature=+crt-static) ;; esac ;;
    *)
      # One compiler assembles the few lines of machine code; Rust's own linker and C library do the rest.
      local compiler=cc
      [ "${1%%-*}" = "${host%%-*}" ] || compiler=${1%%-*}-linux-gnu-gcc
      export "CC_${1//-/_}=$compiler"
      flags+=(-C linker=rust-lld -C linker-flavor=ld.lld)
      options=(--target "$1")
      built=target/$1/release/meliora
      ;;
  esac
  # The flags are those of the last step, so the libraries are built once for this and for `cargo build`.
  cargo rustc --release --locked ${options[@]+"${options[@]}"} -p meliora --bin meliora -- "${flags[@]}"
}

# Fills a folder with the files that all targets share, written by a command that runs here.
fill() {
  local meliora=$1 folder=$2 shell command
  mkdir -p "$folder"/{completions,man,models,gallery}
  cp README.md CHANGELOG.md LICENSE-* "$folder"
  find models -maxdepth 1 -type f -exec cp {} "$folder/models" \;
  for shell in bash elvish fish powershell zsh; do
    "$meliora" completions "$shell" >"$folder/completions/meliora.$shell"
  done
  "$meliora" man >"$folder/man/meliora.1"
  "$meliora" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]\+\) .*/\1/p' | while read -r command; do
    [ "$command" = help ] || "$meliora" man "$command" >"$folder/man/meliora-$command.1"
  done
  python3 scripts/gallery --binary "$meliora" --pages "$folder/gallery"
}

same=
for target in $targets; do
  why=$(missing "$target")
  if [ -n "$why" ]; then
    skipped+=("$target: needs $why")
    continue
  fi
  build "$target"
  name=meliora-$version-$target
  mkdir -p "$work/$name"
  cp "$built" "$work/$name/meliora"
  if [ -z "$same" ] && "$built" --version >/dev/null 2>&1; then
    same=$work/same
    fill "$PWD/$built" "$same"
  fi
  [ -n "$same" ] || { echo "the first target must run on this machine" >&2; exit 1; }
  cp -R "$same"/. "$work/$name"
  tar -C "$work" -czf "$out/$name.tar.gz" "$name"
done

maturin=target/venv/bin/maturin
if [ ! -x "$maturin" ]; then
  python3 -m venv "$work/venv"
  "$work/venv/bin/pip" install --quiet 'maturin>=1.9,<2'
  maturin=$work/venv/bin/maturin
fi
"$maturin" build --strip --profile "$profile" --locked --manifest-path python/Cargo.toml --out "$out"

(cd "$out" && sha256sum -- *.tar.gz *.whl >SHA256SUMS)
ls -l "$out"
[ ${#skipped[@]} -eq 0 ] || printf 'skipped: %s\n' "${skipped[@]}"

#!/usr/bin/env bash
# Draws the pictures of docs/gallery.md again: runs every command of the page, and copies results/CASE/NAME.svg to
# docs/gallery/CASE-NAME.svg for every picture that the page shows.
# Usage: scripts/gallery.sh [PROGRAM]        (default: the program is built)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
if (($# > 0)); then
    program=$(realpath "$1")
else
    cargo build --release --locked --manifest-path "$root/Cargo.toml"
    program=$root/target/release/geodesic-ivp
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
geodesic-ivp() { "$program" "$@"; }
grep '^geodesic-ivp ' "$root/docs/gallery.md" >commands.sh
# shellcheck source=/dev/null
source ./commands.sh >/dev/null
mkdir -p "$root/docs/gallery"
rm -f "$root"/docs/gallery/*.svg
for picture in $(grep -o '(gallery/[a-z0-9-]*\.svg)' "$root/docs/gallery.md" | tr -d '()' | sort -u); do
    name=$(basename "$picture" .svg)
    cp "results/${name%-*}/${name##*-}.svg" "$root/docs/$picture"
done
ls "$root/docs/gallery"

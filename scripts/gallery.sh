#!/usr/bin/env bash
# Draws the pictures of docs/gallery again, which README and the guide show.
# Usage: scripts/gallery.sh [PROGRAM]        (default: the program is built)
set -euo pipefail
root="$(cd "$(dirname "$0")/.." && pwd)"
program="${1:-$root/target/release/geodesic-ivp}"
(($# > 0)) || (cd "$root" && cargo build --release --locked)
results="$(mktemp -d)"
trap 'rm -rf "$results"' EXIT
draw() {
    "$program" run "$1" --plot --quiet --out "$results" "${@:3}"
    cp "$results/$2.svg" "$root/docs/gallery/$1-$2.svg"
}
draw arenstorf orbit
draw double-pendulum orbit
draw light-capture orbit
draw henon-heiles section --set grid.gamma_f=2000 --set solver.accuracy=1e-8
draw schwarzschild-orbit orbit --set grid.gamma_f=2000 --set solver.accuracy=1e-10
"$program" find halo-moon --follow initial.z=0.1821:0.22 --plot --quiet --out "$results"
cp "$results/family.svg" "$root/docs/gallery/halo-moon-family.svg"

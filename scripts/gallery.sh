#!/usr/bin/env bash
# Draws the pictures of docs/gallery again, which README and the guide show.
# Usage: scripts/gallery.sh [PROGRAM]        (default: the program is built)
set -euo pipefail
root="$(cd "$(dirname "$0")/.." && pwd)"
program="${1:-$root/target/release/geodesic-ivp}"
(($# > 0)) || (cd "$root" && cargo build --release --locked)
results="$(mktemp -d)"
trap 'rm -rf "$results"' EXIT
for name in arenstorf kerr-periodic pleiades schwarzschild-orbit; do
    more=()
    [[ $name != schwarzschild-orbit ]] || more=(--set grid.gamma_f=2000 --set solver.accuracy=1e-10)
    "$program" run "$name" --plot --quiet --out "$results/$name" "${more[@]}"
    cp "$results/$name/orbit.svg" "$root/docs/gallery/$name-orbit.svg"
done

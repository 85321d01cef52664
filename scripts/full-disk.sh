#!/usr/bin/env bash
# Fills the disk of a run: a program without room must say so, and leave one whole set of files or none. This takes a
# file system in memory, so that it needs Linux and root. Kills and limits of memory are in tests/program/cli/.
# Usage: scripts/full-disk.sh [PROGRAM [ROUNDS]]        (default: target/release/geodesic-ivp, 20)
set -euo pipefail
program=$(realpath "${1:-target/release/geodesic-ivp}")
disk=$(mktemp -d)
trap 'umount "$disk" 2>/dev/null || true; rm -rf "$disk" "$disk.whole"' EXIT
run() { "$program" run quartic --plot --quiet --set "grid.n_gamma=$1" --out "$2"; }
run 40 "$disk.whole"
faults=0
declare -A codes
for ((round = 0; round < ${2:-20}; round++)); do
    size=$((8 * (1 + RANDOM % 32)))
    mount -t tmpfs -o size="${size}k" tmpfs "$disk"
    for nodes in 40 60 40; do
        code=0
        message=$(run $nodes "$disk/out" 2>&1) || code=$?
        codes[$code]=$((${codes[$code]:-0} + 1))
        found=none
        if [[ -e $disk/out/summary.json ]]; then
            found=$(grep -o '"n_gamma": [0-9]*' "$disk/out/summary.json" | head -1 | tr -dc 0-9)
            rows=$(($(wc -l <"$disk/out/trajectory.csv") - 1))
            [[ $rows == "$found" && $(ls "$disk.whole") == $(ls "$disk/out") ]] || found=mixture
        fi
        case $code:$found in
            0:$nodes) ;;
            1:none | 1:40 | 1:60) grep -q '^error:' <<<"$message" || found=silent ;;
            *) found+=" after exit code $code" ;;
        esac
        if [[ ! $found =~ ^(none|40|60)$ ]]; then
            echo "fault: $found with $nodes nodes on $size kB: $message"
            faults=$((faults + 1))
        fi
    done
    umount "$disk"
done
for code in "${!codes[@]}"; do echo "exit code $code: ${codes[$code]} times"; done
echo "$faults faults"
((faults == 0))

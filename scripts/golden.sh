#!/usr/bin/env bash
# What every shipped case prints and writes, in both systems, with 16 and with 40 digits, and more: to be the same to
# the last byte before and after a change that must not change results. Files of two commits are comparable on one
# machine only, since instructions and mathematical functions differ between machines.
# Usage: scripts/golden.sh PROGRAM FOLDER      write the files of PROGRAM into FOLDER
#        scripts/golden.sh PROGRAM FOLDER OLD  the same, then compare with the files in OLD
set -euo pipefail
if (($# < 2)); then
    sed -n 2,6p "$0" >&2
    exit 2
fi
program=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
old=${3:+$(realpath "$3")}
cd "$(dirname "$0")/.."

# One job: the name of its folder, then the arguments of the program.
job() {
    local out=$folder/$1
    shift
    rm -rf "$out"
    mkdir -p "$out"
    local code=0
    timeout 20 "$program" "$@" --out "$out/files" >"$out/stdout" 2>"$out/stderr" || code=$?
    echo "exit code $code" >"$out/exit"
    # Times are never the same, nor is the folder.
    local times="s/(_seconds\": )[0-9.e-]+/\10/; s/, [0-9.]+ m?s\$//; s/,[0-9.e-]+,converged\$/,0,converged/"
    find "$out" -type f -exec sed -i -E "s|$folder||g; $times" {} +
}
export -f job
export program folder

jobs() {
    local case name
    for case in cases/*.toml cases/hard/*.toml; do
        name=$(basename "$case" .toml)
        for system in physical-limit doubled; do
            for digits in 16 40; do
                echo "$name/$system-$digits run $case --set solver.system=$system --set solver.digits=$digits"
            done
        done
        echo "$name/accuracy run $case --set solver.accuracy=1e-9"
        for weak in 5 12 16 20 24 28 40; do
            echo "$name/gll-$weak run $case --set scheme.sbp=GLL$weak --set scheme.form=weak" \
                "--set grid.windows=8 --set grid.n_gamma=$weak"
        done
    done
    for accuracy in 1e-4 1e-6 1e-8 1e-12; do
        for case in quartic morse pendulum double-well; do
            echo "$case/accuracy-$accuracy run cases/$case.toml --set solver.accuracy=$accuracy" \
                "--set grid.gamma_f=30 --sample-gamma 0:30:0.5"
            echo "$case/time-$accuracy run cases/$case.toml --set solver.accuracy=$accuracy --set grid.t_f=7.5"
        done
    done
    echo "converge/strong converge cases/quartic.toml --n-gamma 16,32,64,128 --sbp SBP21,SBP42,GLL8 --form strong,weak"
}

jobs | xargs -P "$(nproc)" -L 1 bash -c 'job "$@"' job
runs=$(find "$folder" -name exit | wc -l)
solved=$(grep -rl 'exit code 0' --include=exit "$folder" | wc -l)
echo "$runs runs, $solved of them with exit code 0"
if [[ -n $old ]]; then
    if diff -rq "$old" "$folder"; then echo "no difference"; else exit 1; fi
fi

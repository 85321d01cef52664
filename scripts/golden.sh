#!/usr/bin/env bash
# This script pins what a user sees: what the program prints and writes for every built-in case, in both systems, with
# 16 and with 40 digits, to an accuracy, in studies, and when it refuses or fails. It takes some 170 s of processor
# time. Folders of two builds are comparable on one machine only, since instructions differ between machines.
# Usage: scripts/golden.sh PROGRAM FOLDER                 write the results of PROGRAM into FOLDER
#        scripts/golden.sh PROGRAM FOLDER [--exact] OLD   the same, then compare with the results in OLD
#        scripts/golden.sh --compare [--exact] OLD NEW    compare two folders of results
# Numbers may differ by rounding, as golden.py explains; with --exact nothing but times may differ.
set -euo pipefail
compare=$(dirname "$(realpath "$0")")/golden.py
if [[ ${1:-} == --compare ]]; then exec python3 "$compare" "${@:2}"; fi
if (($# < 2)); then
    sed -n 2,8p "$0" >&2
    exit 2
fi
program=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
# Studies use one thread, because xargs already keeps every core busy.
export program folder RAYON_NUM_THREADS=1

# A job is a line with the name of its folder and then shell commands, which run in this folder. The program is called
# `g` there, so that every call leaves its exit code. Cases are the built-in ones, so that no path enters a message.
job() {
    local name=${1%% *}
    rm -rf "${folder:?}/$name"
    mkdir -p "$folder/$name"
    cd "$folder/$name"
    echo "${1#* }" >command
    eval "${1#* }" >stdout 2>stderr || true
}
g() {
    local code=0
    timeout 60 "$program" "$@" || code=$?
    echo "exit code $code" >>exit
}
export -f job g

# Long cases are shortened except where they run as they are, and so are those whose end is a matter of rounding. The
# number of windows is for jobs that do not bring their own, also of cases that only ask for an accuracy.
declare -A short=(
    [arenstorf]="t_f=1" [fish-eye]="gamma_f=2" [henon-heiles]="gamma_f=20" [horizon-near]="gamma_f=1.5"
    [henon-heiles-megno]="gamma_f=20"
    [kepler-eccentric]="t_f=2" [kepler-polar]="gamma_f=2" [kerr-inclined]="gamma_f=60" [kerr-mino]="gamma_f=2"
    [kerr-periodic]="gamma_f=40" [kerr-photon]="gamma_f=60" [light-capture]="gamma_f=35" [long-run]="gamma_f=62.84"
    [mercury]="t_f=4e12" [pleiades]="t_f=0.5" [quartic-windows]="gamma_f=10" [schwarzschild-orbit]="gamma_f=300"
    [three-bodies]="gamma_f=2"
)
declare -A windows=(
    [arenstorf]=8 [henon-heiles]=20 [kepler-eccentric]=6 [kepler-levi-civita]=12 [kepler-polar]=20 [kerr-inclined]=12
    [kerr-mino]=5 [kerr-periodic]=18 [kerr-photon]=60 [light-capture]=24 [long-run]=20 [luneburg]=8 [mercury]=20
    [pleiades]=4 [quartic-accuracy]=20 [quartic-windows]=20 [schwarzschild-orbit]=30 [three-bodies]=7
)

case_jobs() {
    local case=$1 group=$2 sample="--sample-gamma 0:1:0.125" scheme nodes
    local cut=${short[$1]:+--set grid.${short[$1]}} grid=${windows[$1]:+--set grid.windows=${windows[$1]}}
    local weak="--set scheme.form=weak --set grid.windows=${windows[$1]:-$([[ $group == scene ]] && echo 24 || echo 8)}"
    if "$program" init "$case" | grep -qE '^(accuracy|sensitivity)'; then
        grid="--set scheme.sbp=GLL16 $weak --set solver.sensitivity=false"
    fi
    case $case in
        gamma-short | tiny-units | units) sample="" ;;
        arenstorf | kepler-eccentric | pleiades) sample="--sample-gamma 0:0.05:0.01" ;;
    esac
    echo "$case/words g check $case; g check $case $cut $grid; g init $case"
    echo "$case/expect g check $case --run --quiet"
    echo "$case/as-it-is g run $case --plot" $([[ $case == long-run ]] && echo "$cut $grid") "$sample"
    echo "$case/doubled g run $case $cut $grid --set solver.system=doubled"
    echo "$case/digits-40 g run $case $cut $grid --set solver.digits=40"
    echo "$case/doubled-40 g run $case $cut $grid --set solver.system=doubled --set solver.digits=40 --json"
    echo "$case/accuracy g run $case $cut $sample --set solver.accuracy=1e-9 --set solver.digits=16" \
        "--set solver.system=physical-limit"
    if [[ $case == *-unregularised ]]; then return; fi
    for nodes in 5 16 24 40; do
        echo "$case/gll-$nodes g run $case $cut $weak --set scheme.sbp=GLL$nodes --set grid.n_gamma=$nodes"
    done
    for scheme in "SBP21 weak 64" "SBP42 strong 64" "SBP63 weak 64" "SBP84 strong 64" "GLL12 strong 12"; do
        read -r sbp form nodes <<<"$scheme"
        echo "$case/$sbp-$form g run $case $cut --set scheme.sbp=$sbp --set scheme.form=$form" \
            "--set grid.windows=4 --set grid.n_gamma=$nodes --enclose"
    done
    echo "$case/converge g converge $case $cut $grid --n-gamma 17,34,68 --sbp SBP21,SBP42,GLL8 --form strong,weak"
}

# The remaining jobs look at one feature each. A line that continues is joined by its backslash.
other_jobs() {
    cat <<'END'
accuracies/quartic-1e-4 g run quartic --set solver.accuracy=1e-4 --set grid.gamma_f=30 --sample-gamma 0:30:0.5
accuracies/quartic-1e-12 g run quartic --set solver.accuracy=1e-12 --set grid.gamma_f=30 --sample-gamma 0:30:0.5
accuracies/quartic-time g run quartic --set solver.accuracy=1e-8 --set grid.t_f=7.5 --sample-t 0:7.5:0.5
accuracies/morse-1e-6 g run morse --set solver.accuracy=1e-6 --set grid.gamma_f=30 --sample-gamma 0:30:0.5
accuracies/pendulum-1e-12 g run pendulum --set solver.accuracy=1e-12 --set grid.gamma_f=30 --sample-t 0:20:0.5
accuracies/double-well-time g run double-well --set solver.accuracy=1e-8 --set grid.t_f=7.5 --json
accuracies/kepler-1e-5 g run kepler --set solver.accuracy=1e-5 --sample-t 0:6:0.25
accuracies/kerr-1e-11 g run kerr-inclined --set solver.accuracy=1e-11 --set grid.gamma_f=100 --sample-gamma 0:100:5
accuracies/samples-only g run quartic --set solver.accuracy=1e-8 --set grid.gamma_f=1e3 \
    --samples-only --sample-gamma 0:1000:25
accuracies/stdout g run pendulum --set solver.accuracy=1e-8 --samples-only --sample-t 0:10:0.5 --stdout
pipes/quartic g run quartic --stdout
pipes/weak g run quartic-weak --stdout --quiet
pipes/windows g run quartic-windows --set grid.gamma_f=5 --set grid.windows=10 --stdout
pipes/doubled g run quartic-sbp42 --set solver.system=doubled --stdout --quiet
pipes/digits-60 g run morse-60-digits --set solver.digits=60 --stdout --quiet
pipes/kepler g run kepler --set grid.windows=12 --stdout
pipes/two-bodies g run two-bodies --stdout
pipes/samples-only g run quartic-windows --sample-gamma 0:100:5 --samples-only --stdout
pipes/first-line g run quartic --stdout --quiet | head -1
pipes/standard-input g init harmonic | g check - --run; g init kepler | g run - --quiet
pipes/json g run quartic --json
pipes/json-scene g run kerr-photon --set grid.gamma_f=10 --set grid.windows=10 --json
pipes/json-failure g run horizon --json
pipes/json-converge g converge --json --n-gamma 16,32,64
samples/time g run quartic --sample-t 0:1.4:0.1
samples/sbp42-time g run pendulum --sample-t 0:10:0.5
samples/doubled g run quartic-sbp42 --set solver.system=doubled --sample-gamma 0:1:0.1
samples/windows g run quartic-windows --samples-only --sample-gamma 0:100:2.5
samples/digits-40 g run quartic-40-digits --sample-gamma 0:1:0.125
samples/scene g run schwarzschild-orbit --sample-t 0:2000:50
samples/outside g run quartic --sample-gamma 0:2:0.1
samples/outside-time g run quartic --sample-t 0:9:0.1
samples/malformed g run quartic --sample-t 0:1; g run quartic --sample-t 0:1:0; g run quartic --sample-t a:b:c
samples/only-without g run quartic --samples-only; g run kepler --samples-only --sample-t 0:1:0.1
events/section g run henon-heiles --set grid.gamma_f=50 --set grid.windows=50
events/accuracy g run henon-heiles --set grid.gamma_f=50 --set solver.accuracy=1e-10
events/end g run schwarzschild-plunge --set 'events={middle={when="r-5",direction="down",until=true}}'
events/none g run kepler --set 'events={never={when="x-9"}}'
ends/time g run quartic --set grid.t_f=1.2; g run quartic-weak --set grid.t_f=1.2
ends/time-doubled g run pendulum --set solver.system=doubled --set grid.t_f=3
ends/time-scene g run kepler --set grid.t_f=3
ends/until g run luneburg --set grid.windows=8 --set 'scheme={sbp="GLL16",form="weak"}' --set grid.until=x
ends/horizon-accuracy g run horizon --set solver.accuracy=1e-8
ends/unreachable-time g run horizon --set grid.t_f=1000
ends/horizon-doubled g run horizon --set solver.system=doubled
ends/coordinate-singularity g run schwarzschild-plunge --set metric.preset=schwarzschild --set 'initial={r=4.0,\
    r_dot=0.0,phi_dot=0.0,norm="timelike",solve={t_dot="+"}}' --set grid.until=r-1 --set 'expect={}'
failures/iterations g run quartic-sbp42 --set solver.max_iterations=1
failures/iterations-scene g run kepler --set grid.windows=4 --set solver.max_iterations=2
failures/coarse g run quartic-windows --set grid.windows=8
failures/accuracy g run quartic --set solver.accuracy=1e-15 --set grid.gamma_f=1000
failures/accuracy-scene g run three-bodies --set solver.accuracy=1e-15
failures/accuracy-wall g run tanh-wall --set solver.accuracy=1e-14 --set grid.gamma_f=200
failures/unregularised g run quartic-unregularised; g run linear-unregularised
failures/expectation g init quartic | sed 's/x_final = 0.16/x_final = 0.17/' | g check - --run
failures/memory g run quartic --set grid.n_gamma=1000000 --set grid.windows=1000
failures/spacelike g run quartic --set initial.x_dot=3; g run quartic --set initial.t_dot=0 --set initial.x_dot=0
failures/space g run quartic --out /dev/full; g run quartic --stdout >/dev/full
keys/unknown g check quartic --set grid.n_gama=3; g check quartic --set nothing=3; g check quartic --set grid
keys/types g check quartic --set grid.n_gamma=many; g check quartic --set grid.n_gamma=1.5; \
    g check quartic --set grid.gamma_f=nan; g check quartic --set title=3; g check quartic --set initial.x=1e999
keys/values g check quartic --set grid.n_gamma=2; g check quartic --set grid.gamma_f=-1; \
    g check quartic --set particle.mass=0; g check quartic --set solver.digits=71; \
    g check quartic --set solver.accuracy=2; g check quartic --set grid.windows=0
keys/names g check quartic --set scheme.sbp=SBP22; g check quartic --set scheme.sbp=GLL65; \
    g check quartic --set scheme.form=week; g check quartic --set solver.system=double; g check kepler --set metric.x=1
keys/excluded g check quartic --set scheme.regularised=false; \
    g check quartic --set solver.accuracy=1e-8 --set solver.digits=40; \
    g check quartic --set solver.accuracy=1e-8 --set solver.system=doubled; \
    g check kepler --set scheme.regularised=false --set scheme.form=strong --set solver.system=doubled
keys/formulas for v in 'x^2/' 'y' 'sin x' '(x' 'x**2' '1e' 'foo(x)' 'sqrt(-1-x^2)' '1/(x-1)' 'a*x'; do \
    g check quartic --set "potential={formula=\"$v\"}"; done; \
    g check morse --set 'potential={formula={expression="x^2/2",parameters={unused=1.0}}}'
keys/scenes g check kepler --set initial.z=1; g check kepler --set initial.x_dot=fast; \
    g check kerr-photon --set initial.norm=9; g check kerr-photon --set metric.preset=ker; \
    g check torus --set 'metric.components={"theta chi"="1"}'; g check kepler --set events.e.when=x+; \
    g check kepler --set 'potential.coordinates=["x","x"]'; g check kepler --set 'events={gamma={when="x"}}'
files/malformed for v in '' '[grid' 'a = ' 'title = "x' '[grid]\n[grid]' \
    'potential = 3' '\xff' '[initial]\nx = 1e'; do \
    printf "$v" >case.toml; g check case.toml; done
files/incomplete printf 'potential.free = {}\ninitial = { x = 0.0 }\n' >case.toml; g run case.toml; \
    printf 'potential = { free = {}, linear = { alpha = 1.0 } }\n' >case.toml; g run case.toml
files/missing g run nowhere.toml; g run quartik; g run .; g init quartik; g check; g nonsense; g run quartic --nonsense
files/shortest printf 'potential.free = {}\ninitial = { t = 0.0, x = 0.0, t_dot = 1.0, velocity = 0.5 }\n\
solver.accuracy = 1e-8\n' >case.toml; g check case.toml; g run case.toml
folders/replace g run quartic-sbp42 --set solver.system=doubled; g run quartic-sbp42 --plot; g run quartic-sbp42
folders/foreign mkdir mine; echo "not yours" >mine/summary.json; g run quartic --out mine; cp mine/summary.json kept; \
    g run quartic --out mine --force
folders/failure g run quartic; g run quartic --set grid.gamma_f=20.0 --set scheme.sbp=SBP42 --set grid.n_gamma=8
folders/same-name mkdir a b; g init quartic >a/q.toml; g init morse >b/q.toml; g run a/q.toml; g run b/q.toml; \
    g run a/q.toml --quiet
folders/several g run quartic horizon kepler; g run quartic morse --out both; g run quartic nowhere.toml
folders/file touch taken; g run quartic --out taken; g run quartic --out taken/below
vary/list g run quartic --vary scheme.sbp=SBP21,SBP42,GLL8,SBP99 --set grid.n_gamma=8
vary/range g run quartic --vary initial.x=0.1:0.9:9 --vary grid.n_gamma=32,64
vary/json g run quartic --vary initial.x=0.5:1:3 --json
vary/windows g run quartic-windows --set grid.gamma_f=20 --vary grid.windows=10:40:4
vary/accuracy g run quartic --set grid.gamma_f=20 --vary solver.accuracy=1e-4,1e-8,1e-15
vary/horizon g run horizon --vary grid.gamma_f=1,2,5
vary/none g run horizon --vary grid.gamma_f=4,5; g run quartic --vary grid.n_gamma=1,2
vary/refused g run quartic --vary initial.x; g run quartic --vary initial.y=1,2; g run quartic --vary initial.x=0:1:0; \
    g run quartic --vary initial.x=1,2 --plot; g run quartic --vary initial.x=1,2 --stdout; g run quartic --part 1/2
vary/section g run henon-heiles --set grid.gamma_f=20 --set grid.windows=20 --vary initial.y=-0.1:0.3:5 \
    --vary initial.x_dot=0,0.2
vary/parts g run kepler --vary initial.y_dot=1.8:2.2:5 --out whole; \
    g run kepler --vary initial.y_dot=1.8:2.2:5 --part 1/2 --out part1; g merge part1 --out missing; \
    g run kepler --vary initial.y_dot=1.8:2.2:5 --part 2/2 --out part2; g merge part1 part2 --out joined; \
    g merge part1 part1 --out twice; g merge part1 part2 --out joined-json --json; cmp whole/runs.csv joined/runs.csv; \
    g run kepler --vary initial.y_dot=1.8:2.3:5 --part 2/2 --out other; g merge part1 other --out mixed; \
    g run kepler --vary initial.y_dot=1.8:2.2:5 --part 3/2; g merge nowhere --out none
converge/paper g converge --n-gamma 16,32,64,128,256 --plot
converge/operators g converge quartic --n-gamma 24,48,96,192 --sbp SBP21,SBP42,SBP63,SBP84,GLL5,GLL16 --form strong,weak
converge/range g converge quartic --n-gamma 16,32,64,128,256 --fit-range 32:128 --quiet
converge/doubled g converge quartic --n-gamma 16,32,64 --set solver.system=doubled
converge/digits g converge quartic --n-gamma 16,32,64 --set solver.digits=40
converge/horizon g converge horizon --n-gamma 16,32
converge/refused g converge quartic --n-gamma 16; g converge quartic --n-gamma 2,3; g converge quartic --sbp SBP99
stability/quartic g stability quartic --gamma-f 5,20 --methods SBP,GLL8 --delta-gamma 0.05,0.1,0.2 --plot
stability/others g stability quartic --gamma-f 5 --methods RK4,DOP,Gauss,Taylor,Radau --delta-gamma 0.1,0.2
stability/t-dot g stability quartic --gamma-f 2 --methods SBP21,SBP42 --delta-gamma 0.05,0.1 --t-dot 1,4
stability/kepler g stability kepler --gamma-f 6 --methods SBP42,GLL8,DOP --delta-gamma 0.05,0.1
stability/schwarzschild g stability schwarzschild-orbit --gamma-f 50 --methods SBP42,GLL16 --delta-gamma 0.5,2 --json
stability/refused g stability quartic --methods SBP9; g stability quartic --delta-gamma 0; g stability kepler --t-dot 1
work-precision/quartic g work-precision quartic --longest 0.001 --methods SBP42,GLL8,RK4 --out out --quiet --plot; \
    cut -d, -f1 out/work_precision.csv | sort -u; head -1 out/drift.csv; ls out; rm -r out
work-precision/kepler g work-precision kepler --longest 0.001 --methods GLL16,RK4,DOP --out out --quiet; \
    cut -d, -f1 out/work_precision.csv | sort -u; head -1 out/drift.csv; ls out; rm -r out
work-precision/refused g work-precision quartic --methods SBP9; g work-precision horizon --longest 0.001
help/pages g --help; g --version; for c in run converge work-precision stability check merge init; do g $c --help; done
help/manual g man; g completions bash; g completions zsh; g completions nonsense
help/list g init --list
END
}

{
    other_jobs | sed -e ':join' -e '/\\$/{N;s/\\\n *//;b join' -e '}'
    # Cases are indented below their headings.
    "$program" init --list | while IFS= read -r line; do
        case $line in
            "  "*) read -r case _ <<<"$line" && case_jobs "$case" "$group" ;;
            "The paper"* | "One coordinate"*) group=one ;;
            ?*) group=scene ;;
        esac
    done
} | xargs -d '\n' -P "$(nproc)" -n 1 bash -c 'job "$1"' job
echo "The results of $(find "$folder" -name command | wc -l) jobs are written. Their exit codes are:"
find "$folder" -name exit -exec cat {} + | sort | uniq -c
if (($# > 2)); then exec python3 "$compare" "${@:3}" "$folder"; fi

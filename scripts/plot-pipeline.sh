#!/usr/bin/env bash
# A pipeline that feeds a plotting tool: x(t) of a case, straight from standard output, without files in between.
# Usage: scripts/plot-pipeline.sh CASE > x-of-t.svg          (needs gnuplot)
set -euo pipefail
geodesic-ivp run "$1" --stdout |
    gnuplot -e 'set datafile separator ","; set terminal svg background "white"; set key autotitle columnhead;
                set xlabel "t"; set ylabel "x";
                plot "/dev/stdin" using "t":"x" with linespoints'

#!/usr/bin/env bash
# Every numerical figure of the paper in one folder, with a page that puts each beside the paper's statement.
# Usage: scripts/paper-figures.sh [FOLDER]        (default: results/paper)
set -euo pipefail
folder=${1:-results/paper}
case $folder in /*) ;; *) folder=$PWD/$folder ;; esac
cd "$(dirname "$0")/.."
cargo run --release --locked --example paper_figures -- "$folder"

#!/bin/bash
# What features cost and what they bring: CPU per tracked frame against the error of the poses, for several
# numbers of features on two recordings. Runs `ulf track`, writes a table, draws it with gnuplot.
#
# usage: ULF_BINARY=build/release/ulf ULF_TEST_DATA=DIR tests/charts/tracking_speed_accuracy.sh TABLE.csv PICTURE.png
# A table that is there already is gone on with: only runs that it lacks are made. FEATURES, NEARBY and FRAMES
# (of each recording) change what is run. A run hardly depends on the seed, but much on a few features more or
# fewer: each number is tried with a few beside it (NEARBY), and their median is drawn. CPU is told as a
# multiple of cv::ORB with 1,000 features, timed in the same run, so that a busy machine matters little.
set -euo pipefail
table=${1:?a table to write} picture=${2:?a picture to draw}
: "${ULF_BINARY:?the program}" "${ULF_TEST_DATA:?the folder of recordings}"
nearby=${NEARBY:-0 -10 10} counts=${FEATURES:-300 500 700 850 1000 1250 1500} frames=${FRAMES:-100000}

track() {  # recording features
  local uri truth=$ULF_TEST_DATA/$1
  case $1 in
    handheld_kitchen) uri="replay:$truth?glob=*.color.jpg" truth+=/colmap_reference.txt ;;
    scan_synthetic) uri="replay:$truth" truth+=/groundtruth.txt ;;
  esac
  "$ULF_BINARY" track "$uri" --calibration "$ULF_TEST_DATA/$1/intrinsics.txt" --truth "$truth" --deterministic \
    --benchmark --json --features "$2" --frames "$frames" 2>/dev/null
}
field() { sed -n "s/^ *\"$1\": \([-+.0-9e]*\),*\$/\1/p" <<<"$2"; }

[ -s "$table" ] || echo "recording,features,around,cpu_over_orb,p95_over_orb,live_mm,final_mm,frames,tracked,init_frame" >"$table"
for more in $nearby; do
  for count in $counts; do
    for recording in handheld_kitchen scan_synthetic; do
      key=$recording,$((count + more)),$count
      grep -q "^$key," "$table" && continue
      report=$(track $recording $((count + more)))
      awk -v OFS=, -v name="$key" -v median="$(field cpu_over_orb "$report")" \
        -v p95="$(field cpu_ms_p95 "$report")" -v orb="$(field orb_cpu_ms_median "$report")" \
        -v live="$(field ate_live_rmse "$report")" -v final="$(field ate_final_rmse "$report")" \
        -v frames="$(field frames "$report")" -v tracked="$(field tracked "$report")" \
        -v init="$(field init_frame "$report")" \
        'BEGIN { print name, median, p95 / orb, 1000 * live, 1000 * final, frames, tracked, init }' >>"$table"
    done
  done
done

# Medians: recording, features, CPU, error live, error after.
medians=$(mktemp)
trap 'rm -f "$medians"' EXIT
for recording in handheld_kitchen scan_synthetic; do
  for count in $counts; do
    printf '%s %s' $recording "$count"
    for column in 4 6 7; do
      grep "^$recording,[0-9]*,$count," "$table" | cut -d, -f$column | sort -g |
        awk '{ v[NR] = $1 } END { printf " %s", NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2 }'
    done
    echo
  done
done >"$medians"

gnuplot <<GNUPLOT
set terminal pngcairo size 1400,620 font "DejaVu Sans,13" linewidth 1.4
set output "$picture"
set multiplot layout 1,2 title "Features per frame: what they cost and what they bring" font ",16"
set xlabel "CPU per frame, median, in units of cv::ORB with 1,000 features"
set ylabel "error of the camera centres, RMS (mm)"
set grid lc rgb "#dddddd"
set key top right opaque
set xrange [0:*]
set yrange [0:*]
set offsets 0, 0.1, graph 0.12, 0
set datafile missing "NaN"
panel(name) = sprintf("< grep ^%s $medians", name)
dots(name) = sprintf("< grep ^%s $table | tr , ' '", name)
do for [name in "handheld_kitchen scan_synthetic"] {
  set title (name eq "handheld_kitchen" ? "handheld\\\\_kitchen, against COLMAP" : "scan\\\\_synthetic, against the truth")
  set arrow 1 from first 1.3, graph 0 to first 1.3, graph 1 nohead dashtype 3 lc rgb "#888888"
  set label 1 "limit 1.3" at first 1.3, graph 0.04 offset 0.6,0 textcolor rgb "#888888"
  plot dots(name) using 4:6 with points pt 7 ps 0.6 lc rgb "#f0b090" notitle, \
       dots(name) using 4:7 with points pt 7 ps 0.6 lc rgb "#90b8e0" notitle, \
       panel(name) using 3:4 with linespoints pt 7 ps 1.3 lc rgb "#d05010" title "live", \
       panel(name) using 3:5 with linespoints pt 7 ps 1.3 lc rgb "#1060b0" title "after the run", \
       panel(name) using 3:4:2 with labels offset 0,1 textcolor rgb "#d05010" notitle
}
GNUPLOT

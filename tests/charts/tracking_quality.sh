#!/bin/bash
# What the tracker predicts about its error, against the error: draws the table of the program tracking_quality
# (a dot a frame, a line through the medians of each run's quarters).
#
# usage: tests/charts/tracking_quality.sh TABLE.csv PICTURE.png
set -euo pipefail
table=${1:?the table} picture=${2:?a picture to draw}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
runs=(simulator room scan_synthetic handheld_kitchen)
for run in "${runs[@]}"; do
  awk -F, -v run="$run" '$1 ~ "^" run && $7 > 0 { print 100 * $3 / $7, 100 * $4 / $7 }' "$table" |
    sort -g >"$work/$run.txt"
  frames=$(wc -l <"$work/$run.txt")
  for quarter in 0 1 2 3; do
    from=$((quarter * frames / 4 + 1)) to=$(((quarter + 1) * frames / 4)) middle=$((frames / 8 + 1))
    for column in 1 2; do
      sed -n "${from},${to}p" "$work/$run.txt" | cut -d' ' -f$column | sort -g | sed -n "${middle}p"
    done | paste -sd' '
  done >"$work/$run.bins.txt"
done
gnuplot <<END
set terminal pngcairo size 1000,800 font "sans,13" background "white"
set output "$picture"
set logscale xy
set xrange [0.004:3]
set yrange [0.001:10]
set xlabel "predicted error of the camera's centre (% of the distance)"
set ylabel "true error (% of the distance)"
set key top left box opaque spacing 1.2
set grid
plot x with lines lc rgb "#404040" lw 1.5 title "as predicted", \
  3*x with lines lc rgb "#a0a0a0" dt 2 title "three times, a third", x/3 with lines lc rgb "#a0a0a0" dt 2 notitle, \
  "$work/room.txt" with points pt 7 ps 0.15 lc rgb "#dcb4dc" notitle, \
  "$work/simulator.txt" with points pt 7 ps 0.15 lc rgb "#90c890" notitle, \
  "$work/scan_synthetic.txt" with points pt 7 ps 0.15 lc rgb "#a0b8f0" notitle, \
  "$work/handheld_kitchen.txt" with points pt 7 ps 0.4 lc rgb "#f0c080" notitle, \
  "$work/room.bins.txt" with linespoints pt 7 ps 1.4 lw 2 lc rgb "#903090" title "drawn room, noise 1 to 12, 300 and 1,000 features", \
  "$work/simulator.bins.txt" with linespoints pt 7 ps 1.4 lw 2 lc rgb "#207020" title "simulated studio, two seeds", \
  "$work/scan_synthetic.bins.txt" with linespoints pt 7 ps 1.4 lw 2 lc rgb "#2050c0" title "scan\\\\_synthetic", \
  "$work/handheld_kitchen.bins.txt" with linespoints pt 7 ps 1.4 lw 2 lc rgb "#d07010" title "handheld\\\\_kitchen"
END

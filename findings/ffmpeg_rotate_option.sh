#!/usr/bin/env bash
# Version:  FFmpeg 5.1 (Debian 12), and a build of 2018 (npm: @ffmpeg-installer/linux-x64 4.1.0).
# Expected: "-metadata:s:v rotate=90" writes a file that is shown turned by 90 degrees clockwise.
# Seen:     it is turned counter-clockwise, by both, and ffprobe then says "rotation=90", which counts counter-clockwise.
# Matters:  who makes test videos of a turn with this option, and takes it for clockwise, tests the other turn.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
npm install --silent --no-audit --no-fund --prefix . @ffmpeg-installer/linux-x64@4.1.0 >/dev/null 2>&1 || exit 77
old=$work/node_modules/@ffmpeg-installer/linux-x64/ffmpeg
mkdir -p debs/partial
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends 'ffmpeg=7:5.1*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu
new() { LD_LIBRARY_PATH=$libraries "$work/root/usr/bin/ffmpeg" "$@"; }
new -version 2>/dev/null | head -n 1 || exit 77
"$old" -version 2>/dev/null | head -n 1 || exit 77

first() { new -v error -i "$1" ${2:+-vf "$2"} -frames:v 1 -f rawvideo -pix_fmt gray - | md5sum; }
new -v error -f lavfi -i testsrc2=size=320x240:rate=30:duration=0.2 -pix_fmt yuv420p -c:v libx264 plain.mp4 || exit 77
new -v error -i plain.mp4 -c copy -metadata:s:v:0 rotate=90 new.mp4
"$old" -v error -i plain.mp4 -c copy -metadata:s:v:0 rotate=90 old.mp4
clockwise=$(first plain.mp4 transpose=clock)
counter=$(first plain.mp4 transpose=cclock)
holds=0
for file in new old; do
  shown=$(first $file.mp4)
  case $shown in
    "$clockwise") echo "   $file.mp4 is shown turned clockwise"; holds=1 ;;
    "$counter") echo "   $file.mp4 is shown turned counter-clockwise" ;;
    *) echo "   $file.mp4 is shown otherwise"; holds=1 ;;
  esac
done
exit $holds

#!/usr/bin/env bash
# Version:  libexif 0.6.24 (Debian 12).
# Expected: exif_data_new_from_data gives the entries of the block that it reads.
# Seen:     of a block with the maker's name alone it gives seven: a resolution of 72 per inch, "Exif Version 2.1", and
#           "ColorSpace = Uncalibrated" too. They are in no byte of the file. Without EXIF_DATA_OPTION_FOLLOW_SPECIFICATION,
#           which is set by default, there is one.
# Matters:  whoever takes "Uncalibrated" for what the camera said, as of an Adobe RGB picture, doubts every picture without
#           that entry.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  'libexif-dev=0.6.24*' 'libexif12=0.6.24*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu

cat >try.cpp <<'CPP'
#include <libexif/exif-data.h>

#include <cstdio>
int Entries(ExifData* data, bool shown) {
  int count = 0;
  for (int ifd = 0; ifd < EXIF_IFD_COUNT; ++ifd)
    for (unsigned i = 0; i < data->ifd[ifd]->count; ++i, ++count) {
      char value[100];
      ExifEntry* entry = data->ifd[ifd]->entries[i];
      if (shown)
        std::printf("   %s = %s\n", exif_tag_get_name_in_ifd(entry->tag, ExifIfd(ifd)),
                    exif_entry_get_value(entry, value, sizeof value));
    }
  return count;
}
int main() {
  // One entry: Make, four characters with the end mark.
  const unsigned char block[] = {'E',  'x',  'i', 'f', 0, 0, 'I', 'I', 42,  0,   8,   0, 0, 0, 1, 0,
                                 0x0f, 0x01, 2,   0,   4, 0, 0,   0,   'A', 'b', 'c', 0, 0, 0, 0, 0};
  ExifData* read = exif_data_new_from_data(block, sizeof block);
  ExifData* plain = exif_data_new();
  exif_data_unset_option(plain, EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_load_data(plain, block, sizeof block);
  const int by_default = Entries(read, true), without = Entries(plain, false);
  std::printf("   of a block with one entry: %d entries by default, %d without the option\n", by_default, without);
  return by_default == 7 && without == 1 &&
                 exif_content_get_entry(read->ifd[EXIF_IFD_EXIF], EXIF_TAG_COLOR_SPACE) != nullptr
             ? 0
             : 1;
}
CPP
g++ -I root/usr/include try.cpp -o try -L "$libraries" -lexif 2>errors.txt || \
  { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries ./try

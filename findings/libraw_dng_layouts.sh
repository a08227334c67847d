#!/usr/bin/env bash
# Version:  LibRaw 0.20.2 (Debian 12).
# Expected: uncompressed DNG files of one photograph are the same light however they are laid out: in strips or in tiles, as
#           a mosaic or as linear colours (LinearRaw) above a black level. What the library cannot read it refuses.
# Seen:     each is read with success, and one layout alone is right. Tiles are read as if they were strips: the samples
#           stand at other places of the picture. Of a linear file in strips with black 8000 of 65535 half light is 0.44: the
#           black level is taken off, and what is left is not scaled up to white again, as that of a mosaic is.
# Matters:  a tiled picture shows nonsense, which somebody sees; a set of linear files 12 % too dark nobody sees.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v g++ >/dev/null || exit 77
mkdir -p debs/partial
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  'libraw-dev=0.20.2*' 'libraw20=0.20.2*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
libraries=$work/root/usr/lib/x86_64-linux-gnu

cat >try.cpp <<'CPP'
#include <libraw/libraw.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>
constexpr int kSize = 64, kTile = 32, kBlack = 8000, kWhite = 65535;

struct File {
  std::string bytes = std::string("II*\0", 4) + std::string(4, '\0');
  struct Entry {
    unsigned tag, type, count;
    std::string value;
  };
  std::vector<Entry> entries;
  template <typename T>
  static std::string Bytes(const std::vector<T>& numbers) {
    return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)};
  }
  void Byte(unsigned tag, const std::string& v) { entries.push_back({tag, 1, unsigned(v.size()), v}); }
  void Text(unsigned tag, std::string v) { v += '\0'; entries.push_back({tag, 2, unsigned(v.size()), v}); }
  void Short(unsigned tag, const std::vector<unsigned short>& v) { entries.push_back({tag, 3, unsigned(v.size()), Bytes(v)}); }
  void Long(unsigned tag, const std::vector<unsigned>& v) { entries.push_back({tag, 4, unsigned(v.size()), Bytes(v)}); }
  void Ratio(unsigned tag, unsigned type, const std::vector<unsigned>& v) { entries.push_back({tag, type, unsigned(v.size() / 2), Bytes(v)}); }
  std::string Finished() {
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.tag < b.tag; });
    for (Entry& each : entries)
      if (each.value.size() > 4) {
        const unsigned at = bytes.size();
        bytes += each.value;
        if (bytes.size() % 2) bytes += '\0';
        each.value = Bytes<unsigned>({at});
      }
    const unsigned directory = bytes.size();
    std::memcpy(bytes.data() + 4, &directory, 4);
    bytes += Bytes<unsigned short>({static_cast<unsigned short>(entries.size())});
    for (Entry& each : entries) {
      each.value.resize(4);
      bytes += Bytes<unsigned short>({static_cast<unsigned short>(each.tag), static_cast<unsigned short>(each.type)}) +
               Bytes<unsigned>({each.count}) + each.value;
    }
    return bytes + std::string(4, '\0');
  }
};

// Half light on the left, a quarter on the right, in one sample (mosaic) or three (linear) a pixel, from this byte on.
std::string Dng(bool tiled, bool linear, unsigned begin = 0) {
  const int samples = linear ? 3 : 1, step = tiled ? kTile : kSize;
  File file;
  std::vector<unsigned> begins, sizes;
  std::string picture;
  for (int top = 0; top < kSize; top += step)
    for (int left = 0; left < kSize; left += step) {
      std::vector<unsigned short> block;
      for (int y = top; y < top + step; ++y)
        for (int x = left; x < left + step; ++x)
          block.insert(block.end(), samples, kBlack + (kWhite - kBlack) * (x < kSize / 2 ? 0.5 : 0.25));
      begins.push_back(begin + picture.size());
      sizes.push_back(block.size() * 2);
      picture += File::Bytes(block);
    }
  file.Long(254, {0});
  file.Long(256, {kSize});
  file.Long(257, {kSize});
  file.Short(258, std::vector<unsigned short>(samples, 16));
  file.Short(259, {1});
  file.Short(262, {static_cast<unsigned short>(linear ? 34892 : 32803)});
  file.Text(271, "Maker");
  file.Text(272, "Model");
  file.Short(277, {static_cast<unsigned short>(samples)});
  file.Short(284, {1});
  if (tiled) {
    file.Long(322, {kTile});
    file.Long(323, {kTile});
    file.Long(324, begins);
    file.Long(325, sizes);
  } else {
    file.Long(273, begins);
    file.Long(278, {kSize});
    file.Long(279, sizes);
  }
  if (!linear) {
    file.Short(33421, {2, 2});
    file.Byte(33422, std::string("\0\1\1\2", 4));
  }
  file.Byte(50706, std::string("\1\4\0\0", 4));
  file.Text(50708, "Maker Model");
  file.Long(50714, std::vector<unsigned>(samples, kBlack));
  file.Long(50717, std::vector<unsigned>(samples, kWhite));
  file.Ratio(50721, 10, {1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1});
  file.Ratio(50728, 5, {1, 1, 1, 1, 1, 1});
  file.Short(50778, {21});
  const std::string head = file.Finished();
  return begin == 0 ? Dng(tiled, linear, head.size()) : head + picture;
}

int main() {
  bool holds = true;
  for (const bool linear : {false, true})
    for (const bool tiled : {false, true}) {
      std::string bytes = Dng(tiled, linear);
      LibRaw raw;
      raw.imgdata.params.output_bps = 16;
      raw.imgdata.params.gamm[0] = raw.imgdata.params.gamm[1] = 1;
      raw.imgdata.params.no_auto_bright = 1;
      raw.imgdata.params.output_color = 0;
      raw.imgdata.params.user_mul[0] = raw.imgdata.params.user_mul[1] = raw.imgdata.params.user_mul[2] =
          raw.imgdata.params.user_mul[3] = 1;
      int status = raw.open_buffer(bytes.data(), bytes.size());
      if (status == 0) status = raw.unpack();
      if (status == 0) status = raw.dcraw_process();
      std::printf("   %s in %s: ", linear ? "linear" : "mosaic", tiled ? "tiles" : "strips");
      if (status != 0) {
        std::printf("refused, %s\n", libraw_strerror(status));
        holds = false;
        continue;
      }
      const auto light = [&](int x, int y) { return raw.imgdata.image[y * raw.imgdata.sizes.iwidth + x][1] / 65535.0; };
      const double left = light(kSize / 4, kSize / 8), right = light(kSize * 3 / 4, kSize / 8);
      std::printf("read with success, %.3f for 0.5 on the left, %.3f for 0.25 on the right\n", left, right);
      const bool right_light = left > 0.49 && left < 0.51 && right > 0.24 && right < 0.26;
      holds = holds && right_light == (!linear && !tiled);
    }
  return holds ? 0 : 1;
}
CPP
g++ -I root/usr/include try.cpp -o try -L "$libraries" -lraw -Wl,-rpath-link,"$libraries" 2>errors.txt || { head -n 3 errors.txt >&2; exit 77; }
LD_LIBRARY_PATH=$libraries ./try

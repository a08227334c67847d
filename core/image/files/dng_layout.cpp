#include "core/image/files/dng_layout.h"

#include <tiff.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

#include "core/base/binary_file.h"
#include "core/base/error.h"

namespace ulf {
namespace {

constexpr std::uint32_t kLinearLight = 34892;  // LinearRaw, which libtiff has no name for
constexpr std::size_t kEntryBytes = 12;

struct DngEntry {
  std::uint16_t type = 0;
  std::uint32_t count = 0;
  std::string bytes;  // the raw bytes of the entry
};

struct DngDirectory {
  std::uint64_t pointer_at = 0;  // position of the pointer to the directory
  std::uint64_t next = 0;
  std::map<std::uint16_t, DngEntry> entries;
};

class DngFile {
 public:
  explicit DngFile(const ReadBytesAt& read) : read_(read) {
    const std::string head = read_(0, 8);
    if (head.size() < 8) return;
    is_little_ = head[0] == 'I';
    const bool is_tiff =
        head.starts_with(std::string("II*\0", 4)) || head.starts_with(std::string("MM\0*", 4));
    if (is_tiff) AddChain(4, 0);
    const bool is_dng = !directories_.empty() && directories_.front().entries.contains(TIFFTAG_DNGVERSION);
    if (!is_dng) directories_.clear();
  }

  // Returns the first directory of the sensor's own pixels at full size.
  const DngDirectory* Raw() const {
    for (const DngDirectory& directory : directories_) {
      const std::uint32_t light = FirstOf(directory, TIFFTAG_PHOTOMETRIC);
      if ((FirstOf(directory, TIFFTAG_SUBFILETYPE) & 1) == 0 &&
          (light == PHOTOMETRIC_CFA || light == kLinearLight))
        return &directory;
    }
    return nullptr;
  }
  bool is_little() const { return is_little_; }

  std::uint32_t FirstOf(const DngDirectory& directory, std::uint16_t tag, std::uint32_t otherwise = 0) const {
    const std::vector<std::uint32_t> values = ValuesOf(directory, tag);
    return values.empty() ? otherwise : values.front();
  }
  std::vector<std::uint32_t> ValuesOf(const DngDirectory& directory, std::uint16_t tag) const {
    const auto found = directory.entries.find(tag);
    if (found == directory.entries.end()) return {};
    const DngEntry& entry = found->second;
    const std::size_t size = entry.type == TIFF_SHORT ? 2 : entry.type == TIFF_BYTE ? 1 : 4;
    constexpr std::uint32_t kMostValues = 1 << 20;
    const std::size_t count = std::min(entry.count, kMostValues);
    const std::string bytes = count * size <= 4 ? entry.bytes.substr(8, count * size)
                                                : read_(Number(entry.bytes, 8, 4), count * size);
    std::vector<std::uint32_t> values;
    for (std::size_t i = 0; i + size <= bytes.size(); i += size) values.push_back(Number(bytes, i, size));
    return values;
  }
  // Reads numbers, also fractions.
  std::vector<double> RealsOf(const DngDirectory& directory, std::uint16_t tag) const {
    const auto found = directory.entries.find(tag);
    std::vector<double> reals;
    if (found != directory.entries.end() && found->second.type == TIFF_RATIONAL) {
      const DngEntry& entry = found->second;
      constexpr std::uint32_t kMostFractions = 4096;
      const std::string bytes =
          read_(Number(entry.bytes, 8, 4), std::size_t{8} * std::min(entry.count, kMostFractions));
      for (std::size_t i = 0; i + 8 <= bytes.size(); i += 8)
        reals.push_back(static_cast<double>(Number(bytes, i, 4)) / std::max(1U, Number(bytes, i + 4, 4)));
      return reals;
    }
    for (const std::uint32_t value : ValuesOf(directory, tag)) reals.push_back(value);
    return reals;
  }
  std::uint32_t Number(const std::string& bytes, std::size_t at, std::size_t size) const {
    const std::string_view part = std::string_view(bytes).substr(at, size);
    return static_cast<std::uint32_t>(is_little_ ? LittleEndian(part) : BigEndian(part));
  }
  std::string Bytes(std::uint32_t number, std::size_t size) const {
    std::string bytes;
    for (std::size_t i = 0; i < size; ++i)
      bytes += static_cast<char>(number >> (8 * (is_little_ ? i : size - 1 - i)));
    return bytes;
  }

 private:
  // Reads the chain of directories from the one that the file names at `pointer_at`, and those inside them.
  void AddChain(std::uint64_t pointer_at, int depth) {
    constexpr std::size_t kMostDirectories = 64;
    constexpr int kMostDepth = 2;
    while (directories_.size() < kMostDirectories) {
      const std::string pointer = read_(pointer_at, 4);
      if (pointer.size() < 4) return;
      const std::uint32_t place = Number(pointer, 0, 4);
      const std::string count_bytes = read_(place, 2);
      if (place == 0 || count_bytes.size() < 2) return;
      const std::size_t count = Number(count_bytes, 0, 2);
      const std::string bytes = read_(place + 2, count * kEntryBytes + 4);
      if (bytes.size() < count * kEntryBytes + 4) return;
      DngDirectory directory{pointer_at, Number(bytes, count * kEntryBytes, 4), {}};
      for (std::size_t i = 0; i < count; ++i) {
        const std::string entry = bytes.substr(i * kEntryBytes, kEntryBytes);
        directory.entries[static_cast<std::uint16_t>(Number(entry, 0, 2))] = {
            static_cast<std::uint16_t>(Number(entry, 2, 2)), Number(entry, 4, 4), entry};
      }
      directories_.push_back(directory);
      if (const auto inside = directory.entries.find(TIFFTAG_SUBIFD);
          inside != directory.entries.end() && depth < kMostDepth) {
        const DngEntry& entry = inside->second;
        const std::uint64_t value_at =
            place + 2 + static_cast<std::uint64_t>(IndexOf(bytes, TIFFTAG_SUBIFD)) * kEntryBytes + 8;
        const std::uint64_t first = entry.count == 1 ? value_at : Number(entry.bytes, 8, 4);
        for (std::uint32_t i = 0; i < std::min<std::uint32_t>(entry.count, 16); ++i)
          AddChain(first + 4 * i, depth + 1);
      }
      if (depth > 0) return;
      pointer_at = place + 2 + count * kEntryBytes;
    }
  }
  std::size_t IndexOf(const std::string& entries, std::uint16_t tag) const {
    std::size_t i = 0;
    while (Number(entries, i * kEntryBytes, 2) != tag) ++i;
    return i;
  }

  const ReadBytesAt& read_;
  bool is_little_ = true;
  std::vector<DngDirectory> directories_;
};

std::string PatternOf(const DngFile& file, const DngDirectory& raw) {
  constexpr std::string_view kColors = "RGBCMYW";
  std::vector<std::uint32_t> colors = file.ValuesOf(raw, TIFFTAG_CFAPLANECOLOR);
  if (colors.empty()) colors = {0, 1, 2};
  std::string pattern;
  for (const std::uint32_t index : file.ValuesOf(raw, TIFFTAG_CFAPATTERN)) {
    // Each pixel names its colour itself; the list has the colours that occur.
    const bool is_listed = std::ranges::find(colors, index) != colors.end();
    pattern += is_listed && index < kColors.size() ? kColors[index] : '?';
  }
  return pattern;
}

}  // namespace

bool IsKnownMosaic(const DngLayout& layout) {
  constexpr int kBayer = 2, kXtrans = 6;
  const std::string& pattern = layout.pattern;
  if (layout.is_staggered) return false;
  if (layout.mosaic.empty()) return true;
  if (layout.mosaic == cv::Size(kBayer, kBayer))
    return pattern.empty() || pattern == "RGGB" || pattern == "BGGR" || pattern == "GRBG" ||
           pattern == "GBRG";
  if (layout.mosaic != cv::Size(kXtrans, kXtrans)) return false;
  if (pattern.empty()) return true;
  constexpr std::string_view kFromOnePixel = "GBGGRGRGRBGBGBGGRGGRGGBGBGBRGRGRGGBG";
  for (int shift_y = 0; shift_y < kXtrans; ++shift_y)
    for (int shift_x = 0; shift_x < kXtrans; ++shift_x) {
      bool is_same = pattern.size() == kFromOnePixel.size();
      for (int i = 0; is_same && i < kXtrans * kXtrans; ++i) {
        const int y = (i / kXtrans + shift_y) % kXtrans, x = (i % kXtrans + shift_x) % kXtrans;
        is_same =
            pattern[static_cast<std::size_t>(i)] == kFromOnePixel[static_cast<std::size_t>(y * kXtrans + x)];
      }
      if (is_same) return true;
    }
  return false;
}

std::optional<DngLayout> DngLayoutOf(const ReadBytesAt& read) {
  const DngFile file(read);
  const DngDirectory* const raw = file.Raw();
  if (!raw) return std::nullopt;
  DngLayout layout;
  if (file.FirstOf(*raw, TIFFTAG_PHOTOMETRIC) == PHOTOMETRIC_CFA) {
    const std::vector<std::uint32_t> period =
        file.ValuesOf(*raw, TIFFTAG_CFAREPEATPATTERNDIM);  // rows, columns
    layout.mosaic = {2, 2};
    if (period.size() == 2) layout.mosaic = {static_cast<int>(period[1]), static_cast<int>(period[0])};
    layout.is_staggered = file.FirstOf(*raw, TIFFTAG_CFALAYOUT, 1) != 1;
    layout.pattern = PatternOf(file, *raw);
  } else {
    const std::vector<std::uint32_t> period =
        file.ValuesOf(*raw, TIFFTAG_BLACKLEVELREPEATDIM);  // rows, columns
    layout.black_period = {1, 1};
    if (period.size() == 2) layout.black_period = {static_cast<int>(period[1]), static_cast<int>(period[0])};
    layout.black = file.RealsOf(*raw, TIFFTAG_BLACKLEVEL);
  }
  layout.has_plain_tiles =
      raw->entries.contains(TIFFTAG_TILEOFFSETS) && file.FirstOf(*raw, TIFFTAG_COMPRESSION, 1) == 1;
  return layout;
}

std::string DngWithoutTiles(const std::string& dng, const std::string& name) {
  const ReadBytesAt read = [&](std::uint64_t at, std::size_t count) {
    return at < dng.size() ? dng.substr(at, count) : std::string();
  };
  const DngFile file(read);
  const DngDirectory* const raw = file.Raw();
  const auto refuse = [&] {
    throw Error(
        "{}: the raw file is cut short or damaged (its tiles reach beyond its end); copy it again from the "
        "card",
        name);
  };
  if (!raw) refuse();
  if (file.FirstOf(*raw, TIFFTAG_PLANARCONFIG, 1) != 1 && file.FirstOf(*raw, TIFFTAG_SAMPLESPERPIXEL, 1) > 1)
    throw Error("{}: is a DNG of uncompressed tiles in planes, which is not read; save it with compression",
                name);
  const std::uint64_t width = file.FirstOf(*raw, TIFFTAG_IMAGEWIDTH),
                      height = file.FirstOf(*raw, TIFFTAG_IMAGELENGTH),
                      bits = file.FirstOf(*raw, TIFFTAG_BITSPERSAMPLE, 1) *
                             std::uint64_t{file.FirstOf(*raw, TIFFTAG_SAMPLESPERPIXEL, 1)},
                      tile_width = file.FirstOf(*raw, TIFFTAG_TILEWIDTH),
                      tile_height = file.FirstOf(*raw, TIFFTAG_TILELENGTH);
  const std::vector<std::uint32_t> places = file.ValuesOf(*raw, TIFFTAG_TILEOFFSETS);
  constexpr std::uint64_t kMostPx = 1 << 20, kMostBits = 256;
  if (width == 0 || height == 0 || tile_width == 0 || tile_height == 0 || bits == 0 || bits > kMostBits ||
      std::max({width, height, tile_width, tile_height}) > kMostPx || tile_width * bits % 8 != 0)
    refuse();
  const std::uint64_t across = (width + tile_width - 1) / tile_width, tile_row = tile_width * bits / 8,
                      row_bytes = (width * bits + 7) / 8;
  // The tiles hold all of it, so no more memory is allocated than the file has bytes.
  if (places.size() < across * ((height + tile_height - 1) / tile_height) || row_bytes * height > dng.size())
    refuse();
  std::string whole = dng;
  whole.resize(whole.size() + whole.size() % 2);
  const std::uint64_t pixels_at = whole.size();
  for (std::uint64_t y = 0; y < height; ++y) {
    std::string row;
    for (std::uint64_t tile = 0; tile < across; ++tile) {
      const std::uint64_t at = places[y / tile_height * across + tile] + y % tile_height * tile_row;
      if (at > dng.size() || dng.size() - at < tile_row) refuse();
      row.append(dng, at, tile_row);
    }
    whole.append(row, 0, row_bytes);
  }
  whole.resize(whole.size() + whole.size() % 2);
  constexpr std::uint64_t kMostBytes = UINT32_MAX;
  if (whole.size() > kMostBytes - 65536)
    throw Error("{}: is too large to be taken apart; save it with compression", name);

  std::map<std::uint16_t, std::string> entries;
  for (const auto& [tag, entry] : raw->entries) entries[tag] = entry.bytes;
  for (const std::uint16_t tag :
       {TIFFTAG_TILEWIDTH, TIFFTAG_TILELENGTH, TIFFTAG_TILEOFFSETS, TIFFTAG_TILEBYTECOUNTS})
    entries.erase(tag);
  for (const auto& [tag, value] : {std::pair{TIFFTAG_STRIPOFFSETS, pixels_at},
                                   {TIFFTAG_ROWSPERSTRIP, height},
                                   {TIFFTAG_STRIPBYTECOUNTS, row_bytes * height}})
    entries[tag] = file.Bytes(tag, 2) + file.Bytes(TIFF_LONG, 2) + file.Bytes(1, 4) +
                   file.Bytes(static_cast<std::uint32_t>(value), 4);
  const std::string directory_at = file.Bytes(static_cast<std::uint32_t>(whole.size()), 4);
  whole += file.Bytes(static_cast<std::uint32_t>(entries.size()), 2);
  for (const auto& [tag, entry] : entries) whole += entry;
  whole += file.Bytes(static_cast<std::uint32_t>(raw->next), 4);
  whole.replace(raw->pointer_at, 4, directory_at);
  return whole;
}

}  // namespace ulf

// Reads Exif tags by the TIFF and Exif documents alone, to check what the program writes.
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <string>

namespace ulf::test {

struct ExifTags {
  std::map<int, double> numbers;     // by tag: SHORT, LONG and RATIONAL
  std::map<int, std::string> texts;  // ASCII
  bool operator==(const ExifTags&) const = default;
};

class TiffReader {
 public:
  explicit TiffReader(std::string bytes) : bytes_(std::move(bytes)), little_(bytes_.starts_with("II")) {}
  ExifTags Read() const {
    ExifTags tags;
    constexpr std::uint32_t kFirstDirectory = 4;
    ReadDirectory(Number(kFirstDirectory, 4), tags);
    return tags;
  }

 private:
  std::uint32_t Number(std::size_t at, int count) const {
    std::uint32_t number = 0;
    for (int i = 0; i < count; ++i) {
      const auto byte = static_cast<unsigned char>(bytes_.at(at + static_cast<std::size_t>(i)));
      number |= std::uint32_t{byte} << (8 * (little_ ? i : count - 1 - i));
    }
    return number;
  }
  void ReadDirectory(std::size_t at, ExifTags& tags) const {
    constexpr int kExifDirectory = 0x8769;
    for (std::uint32_t i = 0; i < Number(at, 2); ++i) {
      const std::size_t entry = at + 2 + 12 * i;
      const int tag = static_cast<int>(Number(entry, 2));
      const std::uint32_t type = Number(entry + 2, 2), count = Number(entry + 4, 4);
      if (tag == kExifDirectory)
        ReadDirectory(Number(entry + 8, 4), tags);
      else if (type == 3)
        tags.numbers[tag] = Number(entry + 8, 2);
      else if (type == 4)
        tags.numbers[tag] = Number(entry + 8, 4);
      else if (type == 5)
        tags.numbers[tag] =
            static_cast<double>(Number(Number(entry + 8, 4), 4)) / Number(Number(entry + 8, 4) + 4, 4);
      else if (type == 2)
        tags.texts[tag] =
            std::string(bytes_.substr(count > 4 ? Number(entry + 8, 4) : entry + 8, count).c_str());
    }
  }
  std::string bytes_;
  bool little_;
};

// Of the first Exif data in the bytes of a JPEG or PNG; none if there are none.
inline ExifTags ExifTagsOf(const std::string& file) {
  const bool is_png = file.starts_with("\x89PNG");
  const std::string mark = is_png ? "eXIf" : std::string("Exif\0\0", 6);
  const std::size_t at = file.find(mark);
  return at == std::string::npos ? ExifTags{} : TiffReader(file.substr(at + mark.size())).Read();
}

inline constexpr int kExposureTimeTag = 33434, kFNumberTag = 33437, kIsoTag = 34855, kFocalLengthTag = 37386,
                     kLensModelTag = 0xA434, kMakeTag = 0x10F, kModelTag = 0x110;

}  // namespace ulf::test

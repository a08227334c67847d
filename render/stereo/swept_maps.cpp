#include "render/stereo/swept_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/digest.h"
#include "render/proxy/depth_map_files.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr char kShareFormat[] = "ulf swept maps 1";

std::string Hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

std::string IndexName(const MapShare& share) {
  return fmt::format("share-{}-of-{}.json", share.index, share.of);
}

SweptMap ReadSweptMap(const fs::path& path, const json& entry) {
  const std::string bytes = ReadWholeFile(path);
  if (Hex(FastChecksumOf(bytes)) != entry.at("checksum").get<std::string>())
    throw Error("{}: its bytes have changed; make this share again", path.string());
  const cv::Mat depth = DecodedDepthMap(bytes);
  const double plane_step = entry.at("plane_step").get<double>();
  if (depth.empty() || depth.type() != CV_32FC1 || !(plane_step >= 0) || !std::isfinite(plane_step))
    throw Error("{}: is no depth map; make this share again", path.string());
  return {depth, plane_step};
}

// None: the file is no index.
std::optional<json> ReadIndex(const fs::path& file) {
  json index = json::parse(ReadWholeFile(file), nullptr, false);
  if (!index.is_object() || index.value("format", json()) != kShareFormat) return std::nullopt;
  return index;
}

}  // namespace

MapShare MapShare::Parse(const std::string& text) {
  MapShare share{-1, -1};
  const std::size_t slash = text.find('/');
  const auto number = [&](std::string_view digits, int& value) {
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return problem == std::errc() && end == digits.data() + digits.size();
  };
  const std::string_view all = text;
  if (slash == std::string::npos || !number(all.substr(0, slash), share.index) ||
      !number(all.substr(slash + 1), share.of) || share.index < 0 || share.of < 1 || share.index >= share.of)
    throw UsageError("--maps-of {}: give K/N, a share K of N counted from 0, such as 0/4 to 3/4", text);
  return share;
}

void WriteSweptMaps(const fs::path& folder, const MapShare& share, std::uint64_t digest,
                    const SweptMaps& maps) {
  MakeFolder(folder);
  json views = json::array();
  for (const auto& [id, map] : maps) {
    std::vector<unsigned char> bytes;
    if (!cv::imencode(".tiff", map.depth, bytes)) throw Error("a depth map cannot be written as TIFF");
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::string name = fmt::format("{:06}.tiff", id);
    WriteFileAtomically(folder / name, text);
    views.push_back({{"id", id},
                     {"file", name},
                     {"plane_step", map.plane_step},
                     {"checksum", Hex(FastChecksumOf(text))}});
  }
  const json index{{"format", kShareFormat},
                   {"share", share.index},
                   {"of", share.of},
                   {"made_of", Hex(digest)},
                   {"views", views}};
  WriteFileAtomically(folder / IndexName(share), index.dump(1) + "\n");
}

SweptMaps ReadSweptMaps(const fs::path& folder, std::uint64_t digest) {
  if (!fs::is_directory(folder))
    throw Error("{}: is no folder; make the maps first, with --maps-of 0/1 --maps {}", folder.string(),
                folder.string());
  SweptMaps maps;
  int of = 0;
  std::set<int> there;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const auto index = ReadIndex(entry.path());
    if (!index) continue;
    try {
      if (index->at("made_of").get<std::string>() != Hex(digest))
        throw Error(
            "{}: was made of other photographs, poses or options; give the options of --maps-of here as "
            "well, or make the "
            "maps again in an empty folder",
            entry.path().string());
      const int shares = index->at("of").get<int>();
      if (of != 0 && shares != of)
        throw Error("{}: holds shares of {} and of {}; make the maps again in an empty folder",
                    folder.string(), of, shares);
      of = shares;
      const int share = index->at("share").get<int>();
      if (share < 0 || share >= of)
        throw Error("{}: is damaged; make this share again", entry.path().string());
      there.insert(share);
      for (const json& view : index->at("views"))
        maps[view.at("id").get<int>()] =
            ReadSweptMap(folder / fs::path(view.at("file").get<std::string>()).filename(), view);
    } catch (const json::exception&) {
      throw Error("{}: is damaged; make this share again", entry.path().string());
    }
  }
  if (of == 0)
    throw Error("{}: holds no depth maps; make them first, with --maps-of 0/1 --maps {}", folder.string(),
                folder.string());
  const std::size_t missing = static_cast<std::size_t>(of) - there.size();
  constexpr std::size_t kMostNamed = 64;
  std::vector<std::string> names;
  for (int share = 0; names.size() < std::min(missing, kMostNamed); ++share)
    if (!there.contains(share)) names.push_back(fmt::format("{}/{}", share, of));
  if (missing > 0)
    throw Error("{}: {} of its {} shares are missing; make them with --maps-of {}{}", folder.string(),
                missing, of, fmt::join(names, ", "), missing > kMostNamed ? ", ..." : "");
  return maps;
}

}  // namespace ulf::render

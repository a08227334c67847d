#include "render/stereo/swept_maps.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/digest.h"
#include "core/image/files/tiff_file.h"
#include "render/proxy/depth_map_files.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr char kShareFormat[] = "ulf swept maps 1";

std::string IndexName(const MapShare& share) {
  return fmt::format("share-{}-of-{}.json", share.index, share.of);
}

// Returns none if the file is no index.
std::optional<json> ReadIndex(const fs::path& file) {
  json index = JsonOrDiscarded(ReadWholeFile(file));
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
      !number(all.substr(slash + 1), share.of) || !share.IsValid())
    throw Refusal(
        Parameter("maps_of"), text,
        fmt::format("give K/N, a share K of N (at most {}) counted from 0, such as 0/4 to 3/4", kMost), "");
  return share;
}

void WriteSweptMaps(const fs::path& folder, const MapShare& share, std::uint64_t digest,
                    const SweptMaps& maps) {
  MakeFolder(folder);
  json views = json::array();
  for (const auto& [id, map] : maps) {
    const FileContent content = TiffContent(map.depth);
    std::string bytes(content.size, 0);
    content.copy(0, bytes);
    const std::string name = fmt::format("{:06}.tiff", id);
    WriteFileAtomically(folder / name, bytes);
    views.push_back(
        {{"id", id}, {"file", name}, {"plane_step", map.plane_step}, {"checksum", ChecksumForIndex(bytes)}});
  }
  const json index{{"format", kShareFormat},
                   {"share", share.index},
                   {"of", share.of},
                   {"made_of", ChecksumText(digest)},
                   {"views", views}};
  WriteFileAtomically(folder / IndexName(share), JsonText(index, 1) + "\n");
}

SweptMap SweptMapFiles::Read(int id, const cv::Size& size) const {
  const auto found = files_.find(id);
  if (found == files_.end())
    throw Error("{}: the depth map of view {} is missing; make the maps again in an empty folder",
                folder_.string(), id);
  const File& file = found->second;
  try {
    const cv::Mat depth = PixelsOfTiff(ReadIndexedFile(folder_ / file.name, file.checksum), size, CV_32FC1);
    if (depth.empty()) throw Error("{}: is no depth map of {}x{}", file.name, size.width, size.height);
    return {depth, file.plane_step};
  } catch (const Error& error) {
    throw Error("{}; make the maps again in an empty folder", error.what());
  }
}

SweptMapFiles FindSweptMaps(const fs::path& folder, std::uint64_t digest) {
  if (!fs::is_directory(folder))
    throw Error("{}: is no folder; make the maps first, with {} 0/1 {} {}", folder.string(),
                Parameter("maps_of"), Parameter("maps"), folder.string());
  SweptMapFiles maps(folder);
  std::optional<int> of;
  std::set<int> there;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const auto index = ReadIndex(entry.path());
    if (!index) continue;
    try {
      if (index->at("made_of").get<std::string>() != ChecksumText(digest))
        throw Error(
            "{}: was made of other photographs, masks, cameras, poses or options; give the options of {} "
            "here as well, or make the maps again in an empty folder",
            entry.path().string(), Parameter("maps_of"));
      const MapShare share{index->at("share").get<int>(), index->at("of").get<int>()};
      if (!share.IsValid())
        throw Error("{}: says share {} of {}, which there cannot be; make this share again",
                    entry.path().string(), share.index, share.of);
      if (of && share.of != *of)
        throw Error("{}: holds shares of {} and of {}; make the maps again in an empty folder",
                    folder.string(), *of, share.of);
      of = share.of;
      there.insert(share.index);
      for (const json& view : index->at("views")) {
        const double plane_step = view.at("plane_step").get<double>();
        if (!(plane_step >= 0) || !std::isfinite(plane_step))
          throw Error("{}: is damaged; make this share again", entry.path().string());
        maps.files_[view.at("id").get<int>()] = {
            fs::path(view.at("file").get<std::string>()).filename().string(),
            view.at("checksum").get<std::string>(), plane_step};
      }
    } catch (const json::exception&) {
      throw Error("{}: is damaged; make this share again", entry.path().string());
    }
  }
  if (!of)
    throw Error("{}: holds no depth maps; make them first, with {} 0/1 {} {}", folder.string(),
                Parameter("maps_of"), Parameter("maps"), folder.string());
  constexpr std::size_t kNamed = 10;
  std::vector<std::string> missing;
  for (int share = 0; share < *of && missing.size() < kNamed; ++share)
    if (!there.contains(share)) missing.push_back(fmt::format("{}/{}", share, *of));
  const std::size_t more = static_cast<std::size_t>(*of) - there.size() - missing.size();
  if (!missing.empty())
    throw Error("{}: shares are missing; make them with {} {}{}", folder.string(), Parameter("maps_of"),
                fmt::join(missing, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
  return maps;
}

}  // namespace ulf::render

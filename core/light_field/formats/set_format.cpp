#include "core/light_field/formats/set_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/name_order.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// The order is that of SetFormat.
constexpr std::array kSetFormats{"ulf",     "nerfstudio", "nerf-synthetic",     "colmap",   "llff",
                                 "bundler", "metashape",  "realityscan",        "meshroom", "opensfm",
                                 "openmvg", "visualsfm",  "gaussian-splatting", "polycam",  "tum",
                                 "euroc",   "kitti"};

std::string BeginningOf(const fs::path& file) {
  constexpr std::size_t kEnough = 4096;
  if (std::error_code unknown; !fs::is_regular_file(file, unknown)) return {};
  std::ifstream stream(file, std::ios::binary);
  std::string text = BytesAt(stream, 0, kEnough);
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  return text;
}

bool IsMetashapeFile(const fs::path& file) {
  if (Lowercase(file.extension().string()) != ".xml") return false;
  const std::string text = BeginningOf(file);
  return text.find("<document") != std::string::npos && text.find("<chunk") != std::string::npos;
}

bool IsRealityScanFile(const fs::path& file) {
  return Lowercase(file.extension().string()) == ".xmp" &&
         BeginningOf(file).find("capturingreality") != std::string::npos;
}

// Returns the beginning of a table in lower case, without blanks and quotation marks, and with one comma
// between columns, whatever separates them.
std::string Titles(const fs::path& file) {
  std::string text = Lowercase(BeginningOf(file));
  std::ranges::replace_if(
      text, [](char c) { return c == ';' || c == '\t'; }, ',');
  std::erase_if(text, [](char c) { return c == ' ' || c == '"'; });
  const auto repeated =
      std::unique(text.begin(), text.end(), [](char a, char b) { return a == ',' && b == ','; });
  text.erase(repeated, text.end());
  return text;
}

// RealityScan's csv with poses and lenses. Its other tables begin with "#name", too.
bool IsRealityScanTable(const fs::path& file) {
  if (Lowercase(file.extension().string()) != ".csv") return false;
  const std::string text = Titles(file);
  return text.find("#name,") != std::string::npos && text.find(",heading,pitch,roll,f") != std::string::npos;
}
bool IsAnyRealityScanTable(const fs::path& file) {
  return Lowercase(file.extension().string()) == ".csv" &&
         Titles(file).find("#name,x,y,") != std::string::npos;
}

// Returns the beginning of a JSON file; "" for other endings.
std::string BeginningOfJson(const fs::path& file) {
  return Lowercase(file.extension().string()) == ".json" ? BeginningOf(file) : std::string();
}

bool BeginsWith(const std::string& text, char first) {
  const std::size_t at = text.find_first_not_of(" \t\r\n");
  return at != std::string::npos && text[at] == first;
}

bool IsMeshroomFile(const fs::path& file) {
  const bool is_sfm = Lowercase(file.extension().string()) == ".sfm";
  const std::string text = is_sfm ? BeginningOf(file) : BeginningOfJson(file);
  return text.find("\"version\"") != std::string::npos &&
         (is_sfm || text.find("\"featuresFolders\"") != std::string::npos ||
          text.find("\"viewId\"") != std::string::npos);
}

bool IsOpenSfmFile(const fs::path& file) {
  const std::string text = BeginningOfJson(file);
  return BeginsWith(text, '[') &&
         (text.find("\"projection_type\"") != std::string::npos ||
          text.find("\"shots\"") != std::string::npos || text.find("\"coordinates\"") != std::string::npos);
}

bool IsOpenMvgFile(const fs::path& file) {
  return BeginningOfJson(file).find("\"sfm_data_version\"") != std::string::npos;
}

bool IsVisualSfmFile(const fs::path& file) {
  return Lowercase(file.extension().string()) == ".nvm" &&
         BeginningOf(file).find("NVM_V") != std::string::npos;
}

bool IsGaussianFile(const fs::path& file) {
  const std::string text = BeginningOfJson(file);
  return BeginsWith(text, '[') && text.find("\"img_name\"") != std::string::npos;
}

// Returns whether the JSON file is another program's and no transforms.json.
bool IsOtherJson(const fs::path& file) {
  return IsMeshroomFile(file) || IsOpenSfmFile(file) || IsOpenMvgFile(file) || IsGaussianFile(file);
}

bool IsBundlerFile(const fs::path& file) {
  return Lowercase(file.extension().string()) == ".out" && BeginningOf(file).starts_with("# Bundle file");
}

// Returns the files of the folder for which `is_one` is true: those of the names that programs give their
// result (beside reconstruction.json lies reconstruction.geocoords.json), then the others, by name.
std::vector<fs::path> FilesIn(const fs::path& folder, bool (*is_one)(const fs::path&)) {
  const auto order = [](const fs::path& file) {
    constexpr std::array kUsual{"reconstruction.json", "sfm_data.json", "bundle.out", "cameras.json"};
    return std::pair(std::ranges::find(kUsual, file.filename().string()) == kUsual.end(), file);
  };
  std::vector<fs::path> files;
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(folder.lexically_normal(), unknown))
    if (entry.is_regular_file(unknown) && is_one(entry.path())) files.push_back(entry.path());
  std::ranges::sort(files, {}, order);
  return files;
}

// Returns the first of these files in the folder or in one of its `below`; empty if none.
fs::path FirstFileIn(const fs::path& folder, std::initializer_list<const char*> below,
                     bool (*is_one)(const fs::path&)) {
  for (const char* inside : below)
    if (const std::vector<fs::path> files = FilesIn(folder / inside, is_one); !files.empty())
      return files.front();
  return {};
}

// Returns whether the folder holds the part of a COLMAP model that names it.
bool IsColmapModel(const fs::path& folder, const fs::path& source, const char* named_by) {
  for (const char* ending : {"bin", "txt"}) {
    // A list images.txt or cameras.txt beside photographs need not be COLMAP's.
    const bool may_be_another = folder == source && ending == std::string("txt");
    const char* other = named_by == std::string("images") ? "cameras" : "points3D";
    if (HoldsColmapPart(folder, named_by, ending) &&
        (!may_be_another || HoldsColmapPart(folder, other, ending)))
      return true;
  }
  return false;
}

// Returns the folders 0, 1, ... in `folder`, in the order of their numbers.
std::vector<fs::path> NumberedFolders(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(folder, unknown)) {
    std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") == std::string::npos && entry.is_directory(unknown))
      names.push_back(std::move(name));
  }
  std::ranges::sort(names, NameOrder);
  std::vector<fs::path> folders;
  for (const std::string& name : names) folders.push_back(folder / name);
  return folders;
}

}  // namespace

const char* Name(SetFormat format) { return kSetFormats[static_cast<std::size_t>(format)]; }

std::optional<SetFormat> SetFormatFromName(const std::string& name) {
  if (name == "auto") return std::nullopt;
  const auto found = std::ranges::find(kSetFormats, name);
  if (found != kSetFormats.end()) return static_cast<SetFormat>(found - kSetFormats.begin());
  throw Refusal(Parameter("format"), name, "there is no such format",
                fmt::format("there are auto, {}", fmt::join(kSetFormats, ", ")));
}

std::vector<SetFormat> FormatsIn(const fs::path& source) {
  std::vector<SetFormat> formats;
  for (std::size_t i = 0; i < kSetFormats.size(); ++i)
    if (const auto format = static_cast<SetFormat>(i); !PlaceOf(format, source).empty())
      formats.push_back(format);
  return formats;
}

fs::path PlaceOf(SetFormat format, const fs::path& source) {
  std::error_code unknown;
  const bool is_file = fs::is_regular_file(source, unknown);
  const auto has = [&](const char* name) { return fs::is_regular_file(source / name, unknown); };
  const std::string name = source.filename().string();
  // Returns `source` if it is such a file, or else the first in it.
  const auto file_of_kind = [&](bool (*is_one)(const fs::path&),
                                std::initializer_list<const char*> below = {"."}) {
    if (is_file) return is_one(source) ? source : fs::path();
    return FirstFileIn(source, below, is_one);
  };
  switch (format) {
    case SetFormat::kUlf:
      return has(kJournalFile) ? source : fs::path();
    case SetFormat::kTransforms:
      if (is_file)
        return Lowercase(source.extension().string()) == ".json" && !name.starts_with("transforms_") &&
                       !IsOtherJson(source)
                   ? source
                   : fs::path();
      return has(kTransformsFile) && !has(kJournalFile) ? source / kTransformsFile : fs::path();
    case SetFormat::kNerfSynthetic:
      if (is_file) return name == kNerfSyntheticFile ? source.parent_path() : fs::path();
      return fs::exists(source / kNerfSyntheticFile, unknown) ? source : fs::path();
    case SetFormat::kColmap: {
      const bool is_part = name.starts_with("cameras.") || name.starts_with("images.");
      const fs::path folder = is_file && is_part ? source.parent_path() : source;
      // A light field holds such a model of itself.
      return !(has(kJournalFile) || ColmapModelsIn(folder).empty()) ? folder : fs::path();
    }
    case SetFormat::kLlff:
      if (is_file) return Lowercase(source.extension().string()) == ".npy" ? source : fs::path();
      return has(kLlffFile) ? source / kLlffFile : fs::path();
    case SetFormat::kBundler:
      return file_of_kind(IsBundlerFile, {".", "bundle", "bundler"});
    case SetFormat::kMetashape:
      return file_of_kind(IsMetashapeFile);
    case SetFormat::kRealityScan: {
      if (is_file && IsAnyRealityScanTable(source)) return source;
      if (is_file) return IsRealityScanFile(source) ? source.parent_path() : fs::path();
      const fs::path first = FirstFileIn(source, {".", "images"}, IsRealityScanFile);
      return first.empty() ? FirstFileIn(source, {".", "images"}, IsRealityScanTable) : first.parent_path();
    }
    case SetFormat::kMeshroom:
      return file_of_kind(IsMeshroomFile);
    case SetFormat::kOpenSfm:
      return file_of_kind(IsOpenSfmFile, {".", "opensfm"});
    case SetFormat::kOpenMvg:
      return file_of_kind(IsOpenMvgFile);
    case SetFormat::kVisualSfm:
      return file_of_kind(IsVisualSfmFile);
    case SetFormat::kGaussian:
      return file_of_kind(IsGaussianFile);
    case SetFormat::kPolycam: {
      const auto is_filled = [&](const fs::path& folder) {
        return fs::is_directory(folder, unknown) && !fs::is_empty(folder, unknown);
      };
      const auto holds = [&](const fs::path& keyframes, const char* cameras, const char* images) {
        return is_filled(keyframes / cameras) && is_filled(keyframes / images);
      };
      for (const fs::path& keyframes : {source / "keyframes", source}) {
        if (holds(keyframes, kPolycamCorrected, "corrected_images")) return keyframes / kPolycamCorrected;
        if (keyframes.filename() == "keyframes" && holds(keyframes, "cameras", "images"))
          return keyframes / "cameras";
      }
      return {};
    }
    case SetFormat::kTum: {
      const fs::path list = is_file && name == kTumListFile ? source : source / kTumListFile;
      return fs::is_regular_file(list, unknown) &&
                     fs::is_regular_file(list.parent_path() / kTumPosesFile, unknown)
                 ? list
                 : fs::path();
    }
    case SetFormat::kEuroc:
      for (const fs::path& mav0 : {source / "mav0", source})
        if (fs::is_regular_file(mav0 / "cam0" / "sensor.yaml", unknown)) return mav0;
      return {};
    case SetFormat::kKitti:
      return has("calib.txt") && BeginningOf(source / "calib.txt").starts_with("P0:") &&
                     (fs::is_directory(source / "image_2", unknown) ||
                      fs::is_directory(source / "image_0", unknown))
                 ? source
                 : fs::path();
  }
  return {};
}

std::vector<fs::path> RivalsOf(const fs::path& place) {
  std::error_code unknown;
  if (!fs::is_regular_file(place, unknown)) return {};
  for (const auto is_one :
       {IsMetashapeFile, IsRealityScanTable, IsMeshroomFile, IsOpenSfmFile, IsOpenMvgFile, IsVisualSfmFile}) {
    if (!is_one(place)) continue;
    std::vector<fs::path> files = FilesIn(FolderOf(place), is_one);
    std::erase_if(files, [&](const fs::path& file) { return file.filename() == place.filename(); });
    return files;
  }
  return {};
}

bool HoldsColmapPart(const fs::path& folder, const std::string& part, const char* ending) {
  std::error_code unknown;
  return fs::exists(folder / (part + "." + ending), unknown);
}

std::vector<fs::path> ColmapModelsIn(const fs::path& source) {
  // A model without its images still counts, so that its reader can name the missing file.
  for (const char* named_by : {"images", "cameras"}) {
    const auto is_model = [&](const fs::path& folder) { return IsColmapModel(folder, source, named_by); };
    if (is_model(source)) return {source};
    for (const char* place : {"sparse", "colmap/sparse", "colmap", "dense/sparse", "dense",
                              "distorted/sparse", "undistorted/sparse", "."}) {
      const fs::path folder = (source / place).lexically_normal();
      std::vector<fs::path> models = NumberedFolders(folder);
      for (fs::path& model : models)
        if (!is_model(model)) model /= "sparse";  // dense/0/sparse of 'colmap automatic_reconstructor'
      std::erase_if(models, [&](const fs::path& model) { return !is_model(model); });
      if (!models.empty()) return models;
      if (place != std::string(".") && is_model(folder)) return {folder};
    }
  }
  return {};
}

}  // namespace ulf

#include "core/light_field/folder/derived_files.h"

#include <spdlog/spdlog.h>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/light_field/folder/opened_folder.h"
#include "core/light_field/folder/view_files.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/points/point_io.h"

namespace ulf {

namespace fs = std::filesystem;

void WriteDerivedFiles(const LightField& light_field) {
  const fs::path sparse = light_field.root / "sparse" / "0";
  MakeFolderIn(light_field.root, "sparse/0");
  const auto made_from = StampOf(light_field.root / kJournalFile);
  const ColmapFiles colmap = ToColmapText(ToColmap(light_field), made_from);
  WriteFileAtomically(sparse / "cameras.txt", colmap.cameras);
  WriteFileAtomically(sparse / "images.txt", colmap.images);
  WriteFileAtomically(sparse / "points3D.txt", colmap.points3d);
  if (!light_field.points.empty()) WritePoints(light_field);
  WriteFileAtomically(light_field.root / kTransformsFile, TransformsJsonText(light_field, made_from));
}

void WriteDerivedFilesOrWarn(const LightField& light_field) {
  try {
    WriteDerivedFiles(light_field);
  } catch (const Error& error) {
    spdlog::warn("{}; 'ulf repair {}' makes transforms.json and sparse/ later", error.what(),
                 ShellWord(light_field.root.string()));
  }
}

std::size_t MakeMissingPictures(const LightField& light_field) {
  std::size_t made = 0, missing = 0;
  bool full = false;
  for (const View& view : light_field.views) {
    if (!PictureFollowsFromMaster(view) || fs::exists(light_field.root / view.image_path)) continue;
    if (full) {
      ++missing;
      continue;
    }
    if (made++ == 0)
      spdlog::info("{}: making the photographs of images/ that are still missing from their masters",
                   light_field.root.string());
    try {
      WritePictureFromMaster(light_field.root, view, SizeOf(light_field.CameraOf(view)));
    } catch (const DiskFullError& error) {
      spdlog::warn("{}; photographs missing in images/ are read from masters/", error.what());
      full = true;
      ++missing;
    } catch (const std::exception& error) {
      spdlog::warn("{}; {} is still missing", error.what(), view.image_path);
      ++missing;
    }
  }
  return missing;
}

std::optional<fs::path> MoveToKept(const fs::path& dir, const std::string& name, const std::string& as) {
  if (!fs::exists(dir / name)) return std::nullopt;
  MakeFolderIn(dir, "kept");
  return MoveWithoutReplacing(dir / name, dir / "kept" / as);
}

void LinkToKept(const fs::path& dir, const std::string& name) {
  if (!fs::exists(dir / name)) return;
  MakeFolderIn(dir, "kept");
  fs::path kept = dir / "kept" / name;
  for (int number = 2; !LinkOrCopy(dir / name, kept); ++number)
    kept =
        dir / "kept" /
        fmt::format("{}-{}{}", fs::path(name).stem().string(), number, fs::path(name).extension().string());
}

void KeepForeignFiles(const fs::path& dir, const FolderCheck& check, bool points_are_in_doubt) {
  const auto keep = [&](const char* name, const char* as) {
    if (const auto kept = MoveToKept(dir, name, as))
      spdlog::warn("{}: another program, or a person, changed it; it is kept as {}", (dir / name).string(),
                   kept->string());
  };
  if (!check.transforms.IsOurs()) keep(kTransformsFile, kTransformsFile);
  if (!check.model.IsOurs()) keep("sparse/0", "sparse");
  if (points_are_in_doubt)
    for (const char* points : {"points.ply", "points.ulf"}) keep(points, points);
}

}  // namespace ulf

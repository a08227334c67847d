#include "core/light_field/exchange/export_light_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <opencv2/core/utility.hpp>
#include <set>
#include <unordered_map>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/parallel_for.h"
#include "core/image/exr_file.h"
#include "core/image/raw_file.h"
#include "core/light_field/exchange/colmap_binary.h"
#include "core/light_field/exchange/colmap_text.h"
#include "core/light_field/exchange/image_names.h"
#include "core/light_field/exchange/staged_folder.h"
#include "core/light_field/exchange/transforms_json.h"
#include "core/light_field/light_field_io.h"
#include "core/light_field/points/point_ply.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// All photographs of an export are in one folder.
std::string NameInExport(const std::string& image_path, std::set<std::string>& taken) {
  std::string name = SafeName(NameInImagesFolder(image_path));
  std::ranges::replace_if(
      name, [](char c) { return c == '/' || c == '\\'; }, '_');
  return UniqueName(name, taken);
}

std::string Ending(const std::string& path) { return Lowercase(fs::path(path).extension().string()); }

bool StaysAsItIs(const View& view, const std::vector<Undistortion>& cameras) {
  return cameras.empty() || cameras[static_cast<std::size_t>(view.camera)].is_identity;
}

std::vector<Undistortion> UndistortAll(const LightField& light_field) {
  std::vector<Undistortion> cameras;
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i)
    cameras.push_back(UndistortionOf(light_field.cameras[i],
                                     fmt::format("{}: camera {}", light_field.root.string(), i + 1)));
  return cameras;
}

void MoveObservations(const LightField& from, const std::vector<Undistortion>& cameras, LightField& to) {
  std::unordered_map<int, int> camera_of;
  for (const View& view : from.views) camera_of[view.id] = view.camera;
  for (ScenePoint& point : to.points)
    std::erase_if(point.track, [&](ViewObservation& seen) {
      const auto found = camera_of.find(seen.view_id);
      if (found == camera_of.end()) return true;
      const Undistortion& undistortion = cameras[static_cast<std::size_t>(found->second)];
      if (undistortion.is_identity) return false;
      const auto ray = undistortion.from.RayFromImg(seen.in_img);
      const auto img = ray ? undistortion.to.ImgFromCam(*ray) : std::nullopt;
      if (!img || !undistortion.to.Contains(*img)) return true;
      seen.in_img = *img;
      return false;
    });
}

// `colors`: of an EXR.
std::string Encoded(const std::string& ending, const cv::Mat& pixels, const ExrColors& colors = {}) {
  if (ending == ".exr") {
    std::vector<ExrChannel> channels;
    const std::string names = pixels.channels() == 1 ? "Y" : "BGR";
    for (int c = 0; c < static_cast<int>(names.size()); ++c)
      channels.push_back({names.substr(static_cast<std::size_t>(c), 1), pixels, c});
    return ExrBytes(channels, ExrCompression::kZip, colors);
  }
  return PngBytes(pixels);
}

// If one view has a mask, every view gets one: nerfstudio takes all or none.
cv::Mat MaskOf(const LightField& light_field, const View& view) {
  const CameraModel& camera = light_field.CameraOf(view);
  const cv::Mat mask = ReadViewMask(light_field, view);
  return mask.empty() ? cv::Mat(camera.height, camera.width, CV_8U, cv::Scalar(255)) : mask;
}

struct Files {
  std::vector<std::pair<fs::path, std::string>> contents;
  bool copied = false;
};

class Pictures {
 public:
  Pictures(const LightField& from, const LightField& to, const std::vector<Undistortion>& cameras,
           const fs::path& folder)
      : from_(from), to_(to), cameras_(cameras), folder_(folder) {
    for (const Undistortion& undistortion : cameras)
      maps_.push_back(undistortion.is_identity ? UndistortionMap{} : MapOf(undistortion));
  }

  Files Of(std::size_t index) const {
    const View &view = from_.views[index], &exported = to_.views[index];
    const bool stays = StaysAsItIs(view, cameras_);
    Image image = ReadRecordedImage(from_, view);  // checked, too
    const fs::path original = from_.root / view.image_path;
    Files files;
    const bool is_raw = IsRawFile(original);  // no other program takes it
    if (is_raw) image.pixels = Srgb8(image);
    files.copied = stays && !is_raw && fs::is_regular_file(original);
    files.contents.emplace_back(
        folder_ / exported.image_path,
        files.copied
            ? ReadWholeFile(original)
            : Encoded(
                  Ending(exported.image_path), stays ? image.pixels : Undistorted(MapFor(view), image.pixels),
                  Ending(original) == ".exr" && fs::exists(original) ? ExrColorsOf(original) : std::nullopt));
    if (exported.mask_path.empty()) return files;
    const cv::Mat mask = MaskOf(from_, view);
    files.contents.emplace_back(folder_ / exported.mask_path,
                                Encoded(".png", stays ? mask : UndistortedMask(MapFor(view), mask)));
    return files;
  }

 private:
  const UndistortionMap& MapFor(const View& view) const {
    return maps_[static_cast<std::size_t>(view.camera)];
  }
  const LightField &from_, &to_;
  const std::vector<Undistortion>& cameras_;
  const fs::path folder_;
  std::vector<UndistortionMap> maps_;
};

// Makes a few at a time on all processors, then writes them in order.
void WritePictures(const Pictures& pictures, std::size_t count, const ExportOptions& options,
                   ExportSummary& summary) {
  const std::size_t at_once = 4 * static_cast<std::size_t>(std::max(1, cv::getNumThreads()));
  for (std::size_t done = 0; done < count; done += at_once) {
    if (options.stop && options.stop()) throw Error("stopped before the end, as asked; nothing was exported");
    const std::size_t some = std::min(at_once, count - done);
    std::vector<Files> files(some);
    std::vector<std::exception_ptr> problems(some);
    ParallelFor(some, [&](std::size_t i) {
      try {
        files[i] = pictures.Of(done + i);
      } catch (...) {
        problems[i] = std::current_exception();
      }
    });
    for (const std::exception_ptr& problem : problems)
      if (problem) std::rethrow_exception(problem);
    FileBatch batch;
    for (const Files& of_view : files) {
      ++(of_view.copied ? summary.copied : summary.made);
      summary.masks += of_view.contents.size() - 1;
      for (const auto& [path, bytes] : of_view.contents) batch.Write(path, ContentOf(bytes));
    }
    batch.Commit();
    if (options.progress)
      options.progress(static_cast<double>(done + some) / static_cast<double>(count),
                       fmt::format("photograph {} of {}", done + some, count));
  }
}

void WriteModel(const LightField& exported, ExportForm form, const fs::path& folder) {
  if (form == ExportForm::kNerfstudio) {
    if (!exported.points.empty()) WriteFileAtomically(folder / "points.ply", PointPlyBytes(exported.points));
    WriteFileAtomically(folder / kTransformsFile, TransformsJsonText(exported));
    return;
  }
  const ColmapReconstruction model = ToColmap(exported);
  const bool binary = form == ExportForm::kColmapBinary;
  const ColmapFiles files = binary ? ToColmapBinary(model) : ToColmapText(model);
  const fs::path sparse = folder / "sparse" / "0";
  const char* ending = binary ? ".bin" : ".txt";
  MakeFolder(sparse);
  WriteFileAtomically(sparse / (std::string("cameras") + ending), files.cameras);
  WriteFileAtomically(sparse / (std::string("images") + ending), files.images);
  WriteFileAtomically(sparse / (std::string("points3D") + ending), files.points3d);
}

// nerfstudio has one kind of lens for all of a set.
void RequireOneKind(const LightField& light_field) {
  const auto fisheyes = std::ranges::count_if(light_field.cameras, [](const CameraModel& camera) {
    return camera.distortion == Distortion::kFisheye;
  });
  if (fisheyes > 0 && fisheyes < static_cast<std::ptrdiff_t>(light_field.cameras.size()))
    throw UsageError(
        "{}: some of its lenses are fisheyes and some are not, but nerfstudio reads one kind of lens per "
        "transforms.json; give --undistort",
        light_field.root.string());
}

}  // namespace

LightField AsExported(const LightField& light_field, bool undistort, std::vector<Undistortion>* undistorted) {
  LightField exported = light_field;
  std::vector<Undistortion> cameras;
  if (undistort) cameras = UndistortAll(light_field);
  for (std::size_t i = 0; i < cameras.size(); ++i) exported.cameras[i] = cameras[i].to;
  exported.flat_fields.clear();
  exported.color_profiles.clear();
  const bool masks =
      std::ranges::any_of(light_field.views, [&](const View& view) { return HasMask(light_field, view); });
  std::set<std::string> taken;
  for (View& view : exported.views) {
    const bool is_there = fs::is_regular_file(light_field.root / view.image_path);
    fs::path path = view.image_path;
    if (!(StaysAsItIs(view, cameras) && is_there && !IsRawFile(path)) && Ending(view.image_path) != ".exr")
      path.replace_extension(".png");
    const std::string name = NameInExport(path.generic_string(), taken);
    view.image_path = "images/" + name;
    view.mask_path = masks ? "masks/" + name + ".png" : "";
    view.master_path.clear();
    view.master_transfer.reset();
    view.master_mosaic = Mosaic::kNone;
    view.exposures.clear();
    view.merged.reset();
  }
  if (undistort) MoveObservations(light_field, cameras, exported);
  MeasurePoints(exported);
  if (undistorted) *undistorted = std::move(cameras);
  return exported;
}

void RequireExportable(const LightField& light_field, const fs::path& out, const ExportOptions& options) {
  const fs::path inside =
      fs::weakly_canonical(out).lexically_relative(fs::weakly_canonical(light_field.root));
  if (!inside.empty() && *inside.begin() != "..")
    throw UsageError("-o {}: lies in the light field, which stays as it is; choose a folder beside it",
                     out.string());
  const StagedFolder tried(out);
  if (options.undistort)
    UndistortAll(light_field);
  else if (options.form == ExportForm::kNerfstudio)
    RequireOneKind(light_field);
}

ExportSummary ExportLightField(const LightField& light_field, const fs::path& out,
                               const ExportOptions& options) {
  RequireExportable(light_field, out, options);
  ExportSummary summary;
  StagedFolder folder(out);
  const LightField exported = AsExported(light_field, options.undistort, &summary.cameras);
  MakeFolder(folder.path() / "images");
  if (!exported.views.empty() && !exported.views.front().mask_path.empty())
    MakeFolder(folder.path() / "masks");
  WritePictures(Pictures(light_field, exported, summary.cameras, folder.path()), exported.views.size(),
                options, summary);
  WriteModel(exported, options.form, folder.path());
  summary.points = StatisticsOf(exported.points);
  folder.Commit();
  return summary;
}

}  // namespace ulf

#include "core/light_field/exchange/export_light_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/available_memory.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/parallel_for.h"
#include "core/image/files/picture_kind.h"
#include "core/light_field/exchange/conversions.h"
#include "core/light_field/exchange/exported_photographs.h"
#include "core/light_field/exchange/staged_folder.h"
#include "core/light_field/exchange/writers/set_writers.h"
#include "core/light_field/exchange/writers/unit_cube.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/image_names.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/points/point_io.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// The requirements of a form for photographs and masks.
struct FormRules {
  bool has_points = true;
  MaskPlace masks = MaskPlace::kBeside;
  bool by_stem = false;    // photographs differ by their names without the ending
  bool one_lens = false;   // one pinhole camera for all
  bool has_depths = true;  // its readers take depth maps
};

FormRules RulesOf(ExportForm form) {
  switch (form) {
    case ExportForm::kColmapText:
    case ExportForm::kColmapBinary:
    case ExportForm::kNerfstudio:
      return {};
    case ExportForm::kInstantNgp:
      return {.has_points = false, .masks = MaskPlace::kDynamic, .by_stem = true};
    case ExportForm::kNerfSynthetic:
      return {.has_points = false,
              .masks = MaskPlace::kAlpha,
              .by_stem = true,
              .one_lens = true,
              .has_depths = false};
    case ExportForm::kRealityScan:
      return {.has_points = false, .masks = MaskPlace::kLayer, .by_stem = true, .has_depths = false};
    case ExportForm::kMetashape:
      return {.masks = MaskPlace::kSuffix, .by_stem = true, .has_depths = false};
  }
  return {};
}

bool IsColmap(ExportForm form) {
  return form == ExportForm::kColmapText || form == ExportForm::kColmapBinary;
}

bool IsUndistorted(const ExportOptions& options) {
  return options.undistort || RulesOf(options.form).one_lens;
}

// All photographs of an export are in one folder.
std::string NameInExport(const std::string& image_path, std::set<std::string>& taken) {
  std::string name = SafeName(NameInImagesFolder(image_path));
  std::ranges::replace_if(
      name, [](char c) { return c == '/' || c == '\\'; }, '_');
  return UniqueName(name, taken);
}

std::vector<Undistortion> UndistortAll(const LightField& light_field, bool one_lens) {
  std::vector<std::string> owners;
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i)
    owners.push_back(fmt::format("{}: camera {}", light_field.root.string(), i + 1));
  if (one_lens) return UndistortionsToOne(light_field.cameras, owners);
  std::vector<Undistortion> cameras;
  for (std::size_t i = 0; i < owners.size(); ++i)
    cameras.push_back(UndistortionOf(light_field.cameras[i], owners[i]));
  return cameras;
}

void MoveObservations(const LightField& from, const std::vector<Undistortion>& cameras, LightField& to) {
  for (ScenePoint& point : to.points)
    std::erase_if(point.track, [&](ViewObservation& seen) {
      const View* view = from.FindView(seen.view_id);
      if (!view) return true;
      const Undistortion& undistortion = cameras[static_cast<std::size_t>(view->camera)];
      if (undistortion.is_identity) return false;
      const auto ray = undistortion.from.RayFromImg(seen.in_img);
      const auto img = ray ? undistortion.to.ImgFromCam(*ray) : std::nullopt;
      if (!img || !undistortion.to.Contains(*img)) return true;
      seen.in_img = *img;
      return false;
    });
}

void Add(const std::optional<ExifFacts>& said, ExposureCounts& all) {
  if (!said) return;
  ++all.photographs;
  all.times += said->exposure_s.has_value();
  all.f_numbers += said->f_number.has_value();
  all.isos += said->iso.has_value();
}

void Add(const DepthSummary& of_view, DepthSummary& all) {
  all.maps += of_view.maps;
  all.pixels += of_view.pixels;
  all.known += of_view.known;
  all.beyond += of_view.beyond;
}

// Makes a few at a time on all processors, then writes them in order.
void WritePictures(const ExportedPhotographs& pictures, std::size_t count, std::size_t at_once,
                   const ExportOptions& options, ExportSummary& summary) {
  CopiedColorEncodings meanings;
  for (std::size_t done = 0; done < count; done += at_once) {
    if (options.stop && options.stop()) throw Error("stopped before the end, as asked; nothing was exported");
    const std::size_t some = std::min(at_once, count - done);
    std::vector<ExportedFiles> files(some);
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
    for (const ExportedFiles& of_view : files) {
      ++(of_view.copied ? summary.copied : summary.made);
      meanings.Add(of_view.stored);
      summary.masks += of_view.has_mask;
      Add(of_view.exposure, summary.exposures);
      Add(of_view.depths, summary.depths);
      for (const auto& [path, bytes] : of_view.contents) batch.Write(path, ContentOf(bytes));
    }
    batch.Commit();
    if (options.progress)
      options.progress(static_cast<double>(done + some) / static_cast<double>(count),
                       fmt::format("photograph {} of {}", done + some, count));
  }
  if (std::string doubt = meanings.Doubt(summary.copied); !doubt.empty())
    summary.doubts.push_back(std::move(doubt));
}

void WriteColmap(const LightField& exported, const ExportOptions& options, const fs::path& folder,
                 const fs::path& out, ExportSummary& summary) {
  ColmapFolder colmap =
      ColmapFolderOf(exported, options.form == ExportForm::kColmapBinary, out, options.colmap);
  for (const auto& [path, contents] : colmap.files) {
    MakeFolder((folder / path).parent_path());
    WriteFileAtomically(folder / path, contents);
  }
  summary.commands = std::move(colmap.commands);
  std::ranges::move(colmap.doubts, std::back_inserter(summary.doubts));
}

void WriteNerfSynthetic(const LightField& exported, const fs::path& folder) {
  const Similarity3 nerf_from_world = NerfFromWorld(exported, SubjectForExport(exported, "nerf-synthetic"));
  const std::string testing = NerfSyntheticText(exported, nerf_from_world, true);
  WriteFileAtomically(folder / "transforms_train.json", NerfSyntheticText(exported, nerf_from_world, false));
  WriteFileAtomically(folder / "transforms_val.json", testing);  // some readers need it
  WriteFileAtomically(folder / "transforms_test.json", testing);
}

void WriteXmpFiles(const LightField& exported, const fs::path& folder) {
  constexpr std::size_t kAtOnce = 64;  // files open at the same time
  for (std::size_t done = 0; done < exported.views.size(); done += kAtOnce) {
    FileBatch batch;
    for (std::size_t i = done; i < std::min(done + kAtOnce, exported.views.size()); ++i) {
      const View& view = exported.views[i];
      const std::string text = RealityScanXmpText(exported.CameraOf(view), view.camera, view.cam_from_world);
      batch.Write(folder / fs::path(view.image_path).replace_extension(".xmp"), ContentOf(text));
    }
    batch.Commit();
  }
}

// The same numbers for both programs; nerfstudio itself takes the unit from its command line alone.
void NameDepths(const LightField& exported, const ExportOptions& options, nlohmann::json& document) {
  if (!options.depths) return;
  const bool is_ngp = options.form == ExportForm::kInstantNgp;
  document[is_ngp ? "integer_depth_scale" : "depth_unit_scale_factor"] = options.depths->png_unit;
  for (std::size_t i = 0; i < exported.views.size(); ++i)
    document["frames"][i][is_ngp ? "depth_path" : "depth_file_path"] =
        DepthPathOf(exported.views[i].image_path) + ".png";
}

// In instant-ngp's keys: the time of a place in the picture, from 0 at the upper edge's pose to 1 at the
// lower edge's.
void NameEdgePoses(const LightField& light_field, const LightField& exported, const ExportOptions& options,
                   nlohmann::json& document) {
  if (!options.edge_poses) return;
  bool any = false;
  for (std::size_t i = 0; i < exported.views.size(); ++i) {
    const auto poses = options.edge_poses(light_field.views[i], exported.CameraOf(exported.views[i]));
    if (!poses) continue;
    any = true;
    nlohmann::json& frame = document["frames"][i];
    frame["transform_matrix_start"] = OpenGlRows(poses->upper_from_world.Inverse().Matrix());
    frame["transform_matrix_end"] = OpenGlRows(poses->lower_from_world.Inverse().Matrix());
  }
  if (any) document["rolling_shutter"] = {0, 0, 1};
}

void WriteTransforms(const LightField& light_field, const LightField& exported, const ExportOptions& options,
                     const fs::path& folder) {
  nlohmann::json document =
      options.form == ExportForm::kInstantNgp ? InstantNgpDocument(exported) : TransformsDocument(exported);
  NameDepths(exported, options, document);
  NameEdgePoses(light_field, exported, options, document);
  WriteFileAtomically(folder / kTransformsFile, JsonText(document, 1) + "\n");
}

void WriteModel(const LightField& light_field, const LightField& exported, const ExportOptions& options,
                const fs::path& folder, const fs::path& out, ExportSummary& summary) {
  const ExportForm form = options.form;
  if (!exported.points.empty() && (form == ExportForm::kNerfstudio || form == ExportForm::kMetashape))
    WriteFileAtomically(folder / "points.ply", PointPlyBytes(exported.points));
  switch (form) {
    case ExportForm::kColmapText:
    case ExportForm::kColmapBinary:
      return WriteColmap(exported, options, folder, out, summary);
    case ExportForm::kNerfstudio:
    case ExportForm::kInstantNgp:
      return WriteTransforms(light_field, exported, options, folder);
    case ExportForm::kNerfSynthetic:
      return WriteNerfSynthetic(exported, folder);
    case ExportForm::kRealityScan:
      return WriteXmpFiles(exported, folder);
    case ExportForm::kMetashape:
      return WriteFileAtomically(folder / "cameras.xml", MetashapeXmlText(exported));
  }
}

// nerfstudio has one lens model for the whole set.
void RequireOneKind(const LightField& light_field) {
  const auto fisheyes = std::ranges::count_if(light_field.cameras, [](const CameraModel& camera) {
    return camera.distortion == Distortion::kFisheye;
  });
  if (fisheyes > 0 && fisheyes < static_cast<std::ptrdiff_t>(light_field.cameras.size()))
    throw Refusal(light_field.root.string(), "",
                  "some of its lenses are fisheyes and some are not, but nerfstudio reads one kind of lens "
                  "per transforms.json",
                  "give " + Parameter("undistort"));
}

// instant-ngp would ignore the sixth order of radial distortion.
void RequireNoSixthOrder(const LightField& light_field) {
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i) {
    const CameraModel& camera = light_field.cameras[i];
    if (camera.distortion == Distortion::kRadialTangential && camera.coefficients[4] != 0)
      throw Refusal(light_field.root.string(), "",
                    fmt::format("camera {} has k3 = {}, which instant-ngp does not know", i + 1,
                                camera.coefficients[4]),
                    "give " + Parameter("undistort"));
  }
}

bool AnyMask(const LightField& light_field) {
  return std::ranges::any_of(light_field.views, [&](const View& view) { return HasMask(light_field, view); });
}

// Returns the views and points of the export, with paths relative to it.
LightField AsExported(const LightField& light_field, const ExportOptions& options,
                      std::vector<Undistortion>& cameras) {
  const FormRules rules = RulesOf(options.form);
  const bool undistort = IsUndistorted(options);
  LightField exported = light_field;
  if (undistort) cameras = UndistortAll(light_field, rules.one_lens);
  for (std::size_t i = 0; i < cameras.size(); ++i) exported.cameras[i] = cameras[i].to;
  exported.flat_fields.clear();
  exported.color_profiles.clear();
  // What is resampled to one instant may lie outside the photograph.
  const bool masks = AnyMask(light_field) || options.resampling, alpha = rules.masks == MaskPlace::kAlpha;
  std::set<std::string> taken;
  for (std::size_t i = 0; i < exported.views.size(); ++i) {
    View& view = exported.views[i];
    fs::path path = view.image_path;
    path.replace_extension(
        alpha ? ".png" : EndingInExport(light_field, view, StaysAsItIs(view, cameras, options), options));
    std::string name = path.generic_string(), ending;
    if (rules.by_stem || options.depths) {
      ending = path.extension().string();
      name.resize(name.size() - ending.size());
    }
    if (rules.by_stem) std::ranges::replace(name, '.', '_');  // a reader would take the rest for the ending
    name = NameInExport(name, taken) + ending;
    view.image_path = (!alpha ? "images/" : IsForTesting(i) ? "test/" : "train/") + name;
    view.mask_path = masks ? MaskPathOf(rules.masks, name) : "";
    view.master_path.clear();
    view.master_transfer.reset();
    view.master_mosaic = Mosaic::kNone;
    view.exposures.clear();
    view.merged.reset();
  }
  if (undistort) MoveObservations(light_field, cameras, exported);
  MeasurePoints(exported);
  if (IsColmap(options.form) && StatisticsOf(exported.points).tracked > 0)  // otherwise as in colmap_model.h
    std::erase_if(exported.points, [](const ScenePoint& point) { return point.track.empty(); });
  return exported;
}

}  // namespace

std::size_t PicturesAtOnce(const LightField& light_field, std::uint64_t available) {
  constexpr std::uint64_t kBytesOfPixel = 32;  // linear light before and after resampling, the map between
  std::uint64_t most_pixels = 1;
  for (const CameraModel& camera : light_field.cameras)
    most_pixels = std::max(
        most_pixels, static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height));
  const auto usual = static_cast<std::uint64_t>(4 * std::max(1, cv::getNumThreads()));
  return static_cast<std::size_t>(
      std::clamp<std::uint64_t>(available / 2 / (kBytesOfPixel * most_pixels), 1, usual));
}

bool HasPoints(ExportForm form) { return RulesOf(form).has_points; }

bool HasDepths(ExportForm form) { return RulesOf(form).has_depths; }

void RequireOutside(const fs::path& light_field, const fs::path& out, std::string_view parameter) {
  const fs::path inside = fs::weakly_canonical(out).lexically_relative(fs::weakly_canonical(light_field));
  if (!inside.empty() && *inside.begin() != "..")
    throw Refusal(Parameter(parameter), out.string(), "lies in the light field, which stays as it is",
                  "choose a folder beside it");
}

void RequireExportable(const LightField& light_field, const fs::path& out, const ExportOptions& options) {
  if (light_field.views.empty())
    throw Error("{}: the light field holds no views to export; capture or import some first",
                light_field.root.string());
  RequireOutside(light_field.root, out);
  const StagedFolder tried(out);
  if (IsUndistorted(options)) UndistortAll(light_field, RulesOf(options.form).one_lens);
  if (options.form == ExportForm::kInstantNgp) UnitCubeOf(light_field);
  if (options.form == ExportForm::kNerfSynthetic) SubjectForExport(light_field, "nerf-synthetic");
  if (options.undistort) return;
  if (options.form == ExportForm::kNerfstudio) RequireOneKind(light_field);
  if (options.form == ExportForm::kInstantNgp) RequireNoSixthOrder(light_field);
  if (options.form == ExportForm::kRealityScan) RequireRealityScanLenses(light_field);
}

void RequireRoomFor(const LightField& light_field, const fs::path& out, const ExportOptions& options) {
  if (IsUndistorted(options) || RulesOf(options.form).masks == MaskPlace::kAlpha) return;
  std::uint64_t bytes = 0;
  for (const View& view : light_field.views) {
    std::error_code missing;
    const std::uint64_t size = fs::file_size(light_field.root / view.image_path, missing);
    if (!missing && !IsRawFile(view.image_path)) bytes += size;
  }
  RequireRoom(StagedFolder(out).path(), bytes);
}

ExportSummary ExportLightField(const LightField& light_field, const fs::path& out,
                               const ExportOptions& options) {
  RequireExportable(light_field, out, options);
  RequireRoomFor(light_field, out, options);
  ExportSummary summary;
  StagedFolder folder(out);
  const FormRules rules = RulesOf(options.form);
  const LightField exported = AsExported(light_field, options, summary.cameras);
  for (const View& view : exported.views)
    for (const std::string& path : {view.image_path, view.mask_path})
      if (!path.empty()) MakeFolder((folder.path() / path).parent_path());
  if (options.depths) MakeFolder(folder.path() / "depths");
  WritePictures(
      ExportedPhotographs(light_field, exported, summary.cameras, rules.masks, options, folder.path()),
      exported.views.size(), PicturesAtOnce(light_field, AvailableMemory()), options, summary);
  WriteModel(light_field, exported, options, folder.path(), out, summary);
  if (options.form == ExportForm::kNerfSynthetic)
    std::ranges::move(
        NerfSyntheticDoubts(exported, SubjectForExport(exported, "nerf-synthetic"), AnyMask(light_field)),
        std::back_inserter(summary.doubts));
  summary.points = StatisticsOf(exported.points);
  folder.Commit();
  return summary;
}

}  // namespace ulf

#include "tests/fuzz/fuzz_targets.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <sstream>
#include <string>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device/feature_file.h"
#include "acquisition/device/frame_recording.h"
#include "core/base/error.h"
#include "core/geometry/digest.h"
#include "core/geometry/trajectory.h"
#include "core/image/files/dng_layout.h"
#include "core/image/files/exif.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_end.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/exchange/readers/npy_file.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/points/point_io.h"
#include "render/output/path_files.h"
#include "render/photographs/pyramid_file.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/mesh_file.h"
#include "render/stereo/swept_maps.h"
#include "tracking/map/map_file.h"
#include "tracking/sources/pose_stream.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

void RequireFinite(const Rigid3& pose) {
  if (!pose.rotation.coeffs().allFinite() || !pose.translation.allFinite())
    Broken("a pose that is not finite");
}

void RequireInside(const std::string& path) {
  const fs::path inside = fs::path(path).lexically_normal();
  if (inside.is_absolute() || (!inside.empty() && *inside.begin() == ".."))
    Broken("a file outside the light field's folder");
}

void RequireSound(const LightField& light_field) {
  for (const View& view : light_field.views) {
    RequireFinite(view.cam_from_world);
    if (view.camera < 0 || static_cast<std::size_t>(view.camera) >= light_field.cameras.size())
      Broken("a view of a camera that there is not");
    // Masks of other programs' sets lie beside their photographs, by a rule; ours are told by the file.
    for (const std::string& path : {view.image_path, view.master_path}) RequireInside(path);
  }
  for (const CameraModel& camera : light_field.cameras)
    if (camera.width <= 0 || camera.height <= 0 || !(camera.fx > 0) || !(camera.fy > 0))
      Broken("a camera without a size or a focal length");
  for (const ScenePoint& point : light_field.points)
    if (!point.position_in_world.allFinite()) Broken("a point that is not finite");
}

// Of a file that names masks, too.
void RequireOwnPaths(const LightField& light_field) {
  RequireSound(light_field);
  for (const View& view : light_field.views) RequireInside(view.mask_path);
}

void ReadSet(std::string_view bytes, SetFormat format, std::span<const char* const> names) {
  RequireSound(ReadPosedSet(FuzzFolder(bytes, names), format, FuzzPhotographs()).light_field);
}

// Each way to read; refuses what all of them refuse.
void ReadByOneOf(std::initializer_list<std::function<void()>> ways) {
  std::optional<Error> refused;
  std::size_t refusals = 0;
  for (const auto& read : ways) {
    try {
      read();
    } catch (const Error& error) {
      refused = error;
      ++refusals;
    }
  }
  if (refusals == ways.size()) throw Error("{}", refused->what());
}

void Transforms(std::string_view bytes) {
  const fs::path file = FuzzFile(bytes, "transforms.json");
  PutFuzzPhotographs(file.parent_path() / "images");
  ReadByOneOf({[&] { RequireOwnPaths(ReadTransformsJson(file)); },
               [&] { RequireSound(ReadTransformsSet(file, FuzzPhotographs())); }});
}
void NerfSynthetic(std::string_view bytes) {
  const fs::path folder = FuzzFolder(bytes, std::array{"transforms_train.json", "transforms_test.json"});
  for (const char* const part : {"train", "test"}) PutFuzzPhotographs(folder / part);
  RequireSound(ReadPosedSet(folder, SetFormat::kNerfSynthetic, {}).light_field);
}
void JournalLines(std::string_view bytes) {
  RequireOwnPaths(ReadJournal(FuzzFile(bytes, kJournalFile)).light_field);
}
void ColmapText(std::string_view bytes) {
  ReadSet(bytes, SetFormat::kColmap,
          std::array{"cameras.txt", "images.txt", "points3D.txt", "rigs.txt", "frames.txt"});
}
void ColmapBinary(std::string_view bytes) {
  ReadSet(bytes, SetFormat::kColmap,
          std::array{"cameras.bin", "images.bin", "points3D.bin", "rigs.bin", "frames.bin"});
}
void Llff(std::string_view bytes) { ReadSet(bytes, SetFormat::kLlff, std::array{"poses_bounds.npy"}); }
void Bundler(std::string_view bytes) {
  ReadSet(bytes, SetFormat::kBundler, std::array{"bundle.out", "list.txt"});
}
void Metashape(std::string_view bytes) {
  RequireSound(
      ReadPosedSet(FuzzFile(bytes, "cameras.xml"), SetFormat::kMetashape, FuzzPhotographs()).light_field);
}
void RealityScan(std::string_view bytes) {
  ReadSet(bytes, SetFormat::kRealityScan, std::array{"0001.xmp", "0002.xmp", "0003.xmp"});
}
void TumSet(std::string_view bytes) {
  RequireSound(ReadPosedSet(FuzzFolder(bytes, std::array{"rgb.txt", "groundtruth.txt"}), SetFormat::kTum,
                            FuzzPhotographs(), CameraModel::Pinhole(64, 48, 60))
                   .light_field);
}
void ReadFileOfSet(std::string_view bytes, SetFormat format, const char* name) {
  RequireSound(ReadPosedSet(FuzzFile(bytes, name), format, FuzzPhotographs()).light_field);
}
void Meshroom(std::string_view bytes) { ReadFileOfSet(bytes, SetFormat::kMeshroom, "cameras.sfm"); }
void OpenSfm(std::string_view bytes) { ReadFileOfSet(bytes, SetFormat::kOpenSfm, "reconstruction.json"); }
void OpenMvg(std::string_view bytes) { ReadFileOfSet(bytes, SetFormat::kOpenMvg, "sfm_data.json"); }
void VisualSfm(std::string_view bytes) { ReadFileOfSet(bytes, SetFormat::kVisualSfm, "model.nvm"); }
void RealityScanTable(std::string_view bytes) {
  ReadFileOfSet(bytes, SetFormat::kRealityScan, "cameras.csv");
}
void GaussianSplatting(std::string_view bytes) {
  ReadSet(bytes, SetFormat::kGaussian, std::array{"cameras.json", "cfg_args", "input.ply"});
}
void Polycam(std::string_view bytes) {
  const fs::path folder = FuzzFolder(
      bytes, std::array{"keyframes/corrected_cameras/0001.json", "keyframes/corrected_cameras/0002.json"});
  PutFuzzPhotographs(folder / "keyframes/corrected_images");
  RequireSound(ReadPosedSet(folder, SetFormat::kPolycam, {}).light_field);
}
void Euroc(std::string_view bytes) {
  ReadSet(bytes, SetFormat::kEuroc,
          std::array{"mav0/cam0/sensor.yaml", "mav0/cam0/data.csv", "mav0/mocap0/data.csv",
                     "mav0/mocap0/sensor.yaml"});
}
void Kitti(std::string_view bytes) {
  const fs::path folder = FuzzFolder(bytes, std::array{"calib.txt", "poses.txt", "times.txt"});
  PutFuzzPhotographs(folder / "image_0");
  RequireSound(ReadPosedSet(folder, SetFormat::kKitti, {}).light_field);
}
void Tum(std::string_view bytes) {
  for (const TimedPose& pose : ReadTum(FuzzFile(bytes, "trajectory.txt"))) RequireFinite(pose.cam_from_world);
}

void Calibration(std::string_view bytes) {
  const auto as = [&](const char* name) {
    return [bytes, name] {
      for (const auto& [mode, calibration] : acquisition::ReadCalibrationFile(FuzzFile(bytes, name)).modes)
        if (!(calibration.camera.fx > 0) || calibration.camera.width <= 0)
          Broken("a camera without a focal length");
    };
  };
  ReadByOneOf({as("calibration.json"), as("calibration.yaml"), as("calibration.xml"), as("cameras.txt")});
}
void PointPly(std::string_view bytes) {
  for (const ScenePoint& point : ReadPointPly(FuzzFile(bytes, "points.ply")))
    if (!point.position_in_world.allFinite()) Broken("a point that is not finite");
}
void Mesh(std::string_view bytes) {
  const bool is_ply = bytes.starts_with("ply");
  const render::TriangleMesh mesh =
      render::ReadMeshFile(FuzzFile(bytes, is_ply ? "mesh.ply" : "mesh.obj")).mesh;
  for (const auto& triangle : mesh.triangles)
    for (const auto corner : triangle)
      if (static_cast<std::size_t>(corner) >= mesh.vertices.size()) Broken("a corner that is no vertex");
}
void Features(std::string_view bytes) { acquisition::ReadFeatureFile(FuzzFile(bytes, "features.json")); }
void Recording(std::string_view bytes) {
  const fs::path folder = FuzzFolder(bytes, std::array{"frames.jsonl"});
  for (const auto& entry : acquisition::ReadFrameRecording(folder).entries)
    for (const fs::path& file : {entry.file, entry.raw_file})
      if (!file.empty()) RequireInside(file.lexically_relative(folder));
}
void SentLines(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    const auto sent = tracking::ReadSentLine(std::string(bytes.substr(0, end)));
    if (sent)
      if (const auto* const pose = std::get_if<tracking::SentPose>(&*sent))
        RequireFinite(pose->world_from_tool);
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
  }
}
// A checksum at the end would keep the fuzzer out: it is put there anew.
std::string WithChecksum(std::string_view bytes, std::uint64_t checksum) {
  return std::string(bytes) + std::string(reinterpret_cast<const char*>(&checksum), sizeof checksum);
}
void MapFile(std::string_view bytes) {
  const std::string file = WithChecksum(bytes, ChecksumOf(bytes));
  const CameraModel camera = CameraModel::Pinhole(64, 48, 60);
  tracking::Map map(camera);
  tracking::MapFromBytes(file, 0, camera, map);
}
void Path(std::string_view bytes) {
  const bool is_json = bytes.starts_with("{");
  const render::PathRequest request{.path = {}, .camera = CameraModel::Pinhole(64, 48, 60)};
  const render::CameraPath path = render::PathFromFile(FuzzFile(bytes, is_json ? "path.json" : "path.txt"),
                                                       request, render::RenderScene{});
  for (const Rigid3& pose : path.cam_from_world) RequireFinite(pose);
}
void Exr(std::string_view bytes) {
  const std::string file = FuzzFile(bytes, "master.exr");
  ReadByOneOf({[&] { ReadExr(file); }, [&] { ReadExrChannel(file, "R"); },
               [&] { ExrAttribute(file, "colorInteropID"); }});
}
void Picture(std::string_view bytes) {
  const bool is_tiff = bytes.starts_with("II") || bytes.starts_with("MM"),
             is_jpeg = bytes.starts_with("\xFF\xD8");
  const std::string file = FuzzFile(bytes, is_tiff   ? "master.tiff"
                                           : is_jpeg ? "photograph.jpg"
                                                     : "photograph.png");
  ReadImageHeader(file);
  ImageFileIsWhole(file);
  ReadImageSize(file);
  std::istringstream stream{std::string(bytes)};
  const auto claimed = ReadImageHeader(file) ? std::nullopt : ClaimedSize(stream);
  const cv::Mat pixels = ReadImageFile(file);
  if (claimed && *claimed != cv::Size2d(pixels.size()))
    Broken("a picture of another size than it was checked for");
}
// What is read of a DNG before LibRaw sees it.
void Dng(std::string_view bytes) {
  const std::string file(bytes);
  const auto layout = DngLayoutOf([&](std::uint64_t at, std::size_t count) {
    return at < file.size() ? file.substr(static_cast<std::size_t>(at), count) : std::string();
  });
  if (!layout) throw Error("no DNG");
  if (IsKnownMosaic(*layout) && !layout->mosaic.empty() && !layout->pattern.empty() &&
      layout->pattern.size() != static_cast<std::size_t>(layout->mosaic.area()))
    Broken("a mosaic of another size than its pattern");
  if (layout->has_plain_tiles && DngWithoutTiles(file, "a.dng").size() > 4 * file.size())
    Broken("a picture in one strip that is larger than its tiles");
}
void Exif(std::string_view bytes) {
  const int orientation = ReadExif(std::string(bytes)).orientation;
  if (orientation < 1 || orientation > 8) Broken("an orientation that Exif does not have");
}

// What the files beside a light field belong to: two views of a camera without distortion.
LightField TwoViews() {
  LightField light_field;
  light_field.cameras = {CameraModel::Pinhole(64, 48, 60)};
  light_field.views.resize(2);
  for (int i = 0; i < 2; ++i) light_field.views[static_cast<std::size_t>(i)].id = i + 1;
  light_field.views[1].cam_from_world.translation.x() = -0.5;
  return light_field;
}

void PointsFile(std::string_view bytes) {
  const StoredPoints stored = PointsFromBytes(WithChecksum(bytes, ChecksumOf(bytes)), TwoViews());
  if (!stored.problem.empty()) throw Error("{}", stored.problem);
  for (const ScenePoint& point : stored.points) {
    if (!point.position_in_world.allFinite()) Broken("a point that is not finite");
    for (const ViewObservation& seen : point.track)
      if (!seen.in_img.allFinite()) Broken("an observation that is not finite");
  }
}
void DepthMaps(std::string_view bytes) {
  const auto mesh = std::make_shared<render::TriangleMesh>(
      render::TriangleMesh{{{-1, -1, 3}, {1, -1, 3}, {0, 1, 4}}, {{0, 1, 2}}});
  const fs::path folder = FuzzFolder(bytes, std::array{"depth/maps.json", "depth/1.png"});
  for (const auto& [id, map] : render::ReadDepthMaps(folder, TwoViews(), mesh).maps) {
    const render::ViewDepthMap& read = map->Get();
    if (read.inverse_depth.type() != CV_16UC1 || read.inverse_depth.cols != read.camera.width ||
        read.inverse_depth.rows != read.camera.height)
      Broken("a depth map of another size than its camera");
  }
}
void SweptMaps(std::string_view bytes) {
  const fs::path folder = FuzzFolder(bytes, std::array{"share-0-of-1.json", "000001.tiff"});
  constexpr std::uint64_t kDigest = 1;
  const render::SweptMap map = render::FindSweptMaps(folder, kDigest).Read(1, {8, 6});
  if (map.depth.type() != CV_32FC1 || map.depth.size() != cv::Size(8, 6) || !(map.plane_step >= 0))
    Broken("no depth map");
}

class SmallPhotograph : public render::Photograph {
 public:
  SmallPhotograph() : Photograph({8, 6}, false) {}
  cv::Mat Level(int level) const override { return cv::Mat::zeros(LevelSize(level), type()); }
};
// The file's head ends with a checksum, as MapFile()'s end does.
void Pyramid(std::string_view bytes) {
  const SmallPhotograph photograph;
  constexpr std::size_t kFixed = 48;  // pyramid_file.cpp, Head
  const std::size_t head =
      std::min(kFixed + 8 * static_cast<std::size_t>(photograph.LevelCount()), bytes.size());
  const std::string file = WithChecksum(bytes.substr(0, head), FastChecksumOf(bytes.substr(0, head))) +
                           std::string(bytes.substr(head));
  const fs::path path = FuzzFile(file, "pyramid");
  constexpr std::uint64_t kKey = 1;
  bool is_read = false;
  for (int level = 0; level < photograph.LevelCount(); ++level)
    if (const auto read = render::ReadPyramidFile(path, kKey, photograph, level)) {
      is_read = true;
      if (read->pixels.size() != photograph.LevelSize(level) || read->pixels.type() != photograph.type())
        Broken("a level of another size");
    }
  if (!is_read) throw Error("no level can be used");
}

constexpr std::array kTargets{
    FuzzTarget{"transforms", Transforms},
    FuzzTarget{"nerf_synthetic", NerfSynthetic},
    FuzzTarget{"journal", JournalLines},
    FuzzTarget{"colmap_text", ColmapText},
    FuzzTarget{"colmap_binary", ColmapBinary},
    FuzzTarget{"llff", Llff},
    FuzzTarget{"bundler", Bundler},
    FuzzTarget{"metashape", Metashape},
    FuzzTarget{"realityscan", RealityScan},
    FuzzTarget{"realityscan_csv", RealityScanTable},
    FuzzTarget{"meshroom", Meshroom},
    FuzzTarget{"opensfm", OpenSfm},
    FuzzTarget{"openmvg", OpenMvg},
    FuzzTarget{"visualsfm", VisualSfm},
    FuzzTarget{"gaussian_splatting", GaussianSplatting},
    FuzzTarget{"polycam", Polycam},
    FuzzTarget{"tum_set", TumSet},
    FuzzTarget{"euroc", Euroc},
    FuzzTarget{"kitti", Kitti},
    FuzzTarget{"tum", Tum},
    FuzzTarget{"calibration", Calibration},
    FuzzTarget{"point_ply", PointPly},
    FuzzTarget{"mesh", Mesh},
    FuzzTarget{"features", Features},
    FuzzTarget{"recording", Recording},
    FuzzTarget{"sent_lines", SentLines},
    FuzzTarget{"map_file", MapFile},
    FuzzTarget{"camera_path", Path},
    FuzzTarget{"exr", Exr},
    FuzzTarget{"picture", Picture},
    FuzzTarget{"dng", Dng},
    FuzzTarget{"exif", Exif},
    FuzzTarget{"points_file", PointsFile},
    FuzzTarget{"depth_maps", DepthMaps},
    FuzzTarget{"swept_maps", SweptMaps},
    FuzzTarget{"pyramid", Pyramid},
    FuzzTarget{"camera_image", CameraImageDoor},
    FuzzTarget{"gige_answer", GigeAnswerDoor},
    FuzzTarget{"gvcp", GvcpRequestsDoor},
};

}  // namespace

std::span<const FuzzTarget> FuzzTargets() { return kTargets; }

const FuzzTarget* FuzzTargetByName(std::string_view name) {
  const auto found = std::ranges::find(kTargets, name, &FuzzTarget::name);
  return found == kTargets.end() ? nullptr : &*found;
}

}  // namespace ulf::test

#include "core/light_field/formats/colmap_rigs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/geometry/byte_stream.h"
#include "core/light_field/formats/text_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// SensorType of src/colmap/util/types.h; an IMU (1) has no images.
constexpr std::int32_t kCameraSensor = 0;
constexpr std::string_view kCameraSensorName = "CAMERA";

using ColmapRig = std::map<std::uint32_t, Rigid3>;  // sensor_from_rig by the camera's number

struct ColmapFrame {
  struct ImageOf {
    std::uint32_t camera = 0, image = 0;
  };
  std::uint32_t rig = 0;
  Rigid3 rig_from_world;
  std::vector<ImageOf> images;
};

// ---- The values of both kinds of file, read one after another. ----

class ColmapRigBytes {
 public:
  explicit ColmapRigBytes(const fs::path& file) : file_(file), bytes_(ReadWholeFile(file)), in_(bytes_) {
    left_ = in_.Get<std::uint64_t>();
  }
  // Goes to the next rig or frame. Returns false at the end.
  bool Next() {
    RequireWhole();
    return left_ > 0 && left_-- > 0;
  }
  std::uint32_t Id() { return in_.Get<std::uint32_t>(); }
  std::uint64_t DataId() { return in_.Get<std::uint64_t>(); }
  std::size_t Count() {
    constexpr std::size_t kLeastBytes = 8;  // of a sensor
    return in_.Count(kLeastBytes);
  }
  bool IsCamera() { return in_.Get<std::int32_t>() == kCameraSensor; }
  bool HasPose() { return in_.Get<std::uint8_t>() != 0; }
  Rigid3 Pose() {
    Rigid3 pose;
    for (const int part : {3, 0, 1, 2}) pose.rotation.coeffs()(part) = in_.Get<double>();
    pose.translation = in_.Get3();
    return pose;
  }
  std::string Where() const { return file_.string(); }
  void RequireWhole() const {
    if (in_.IsShort())
      throw Error("{}: is cut short, or a count in it is wrong; copy it again, or write the model anew",
                  Where());
  }

 private:
  const fs::path file_;
  const std::string bytes_;
  ByteReader in_;
  std::uint64_t left_ = 0;
};

class ColmapRigRows {
 public:
  explicit ColmapRigRows(const fs::path& file) : path_(file), file_(OpenTextFile(file)) {}
  bool Next() {
    for (std::string line; std::getline(file_, line);) {
      ++number_;
      if (IsEmptyOrComment(line)) continue;
      row_ = std::istringstream(line);
      return true;
    }
    return false;
  }
  std::uint32_t Id() { return Get<std::uint32_t>(); }
  std::uint64_t DataId() { return Get<std::uint64_t>(); }
  std::size_t Count() {
    constexpr std::size_t kMost = 1 << 20;
    const auto count = Get<std::size_t>();
    return count > kMost ? Refuse() : count;
  }
  bool IsCamera() { return Get<std::string>() == kCameraSensorName; }
  bool HasPose() { return Get<int>() == 1; }
  Rigid3 Pose() {
    Rigid3 pose;
    for (const int part : {3, 0, 1, 2}) pose.rotation.coeffs()(part) = Get<double>();
    for (int i = 0; i < 3; ++i) pose.translation(i) = Get<double>();
    return pose;
  }
  std::string Where() const { return fmt::format("{}, line {}", path_.string(), number_); }
  void RequireWhole() const {}

 private:
  template <typename T>
  T Get() {
    T value{};
    if (!(row_ >> value)) Refuse();
    return value;
  }
  [[noreturn]] std::size_t Refuse() const {
    throw Error("{}: is no row of a rig or frame of COLMAP; write the model anew", Where());
  }
  const fs::path path_;
  std::ifstream file_;
  std::istringstream row_;
  int number_ = 0;
};

template <typename Values>
std::map<std::uint32_t, ColmapRig> ReadColmapRigs(const fs::path& file) {
  std::map<std::uint32_t, ColmapRig> rigs;
  for (Values in(file); in.Next();) {
    ColmapRig& rig = rigs[in.Id()];
    const std::size_t count = in.Count();
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_camera = in.IsCamera();
      const std::uint32_t id = in.Id();
      const bool is_reference = i == 0;
      if (!is_reference && !in.HasPose()) continue;
      Rigid3 pose = is_reference ? Rigid3{} : in.Pose();
      in.RequireWhole();
      NormalizeColmapPose(pose, fmt::format("{}, sensor {} of a rig", in.Where(), id));
      if (is_camera) rig[id] = pose;
    }
  }
  return rigs;
}

template <typename Values>
std::vector<ColmapFrame> ReadColmapFrames(const fs::path& file) {
  std::vector<ColmapFrame> frames;
  for (Values in(file); in.Next();) {
    const std::uint32_t id = in.Id();
    ColmapFrame& frame = frames.emplace_back();
    frame.rig = in.Id();
    frame.rig_from_world = in.Pose();
    in.RequireWhole();
    NormalizeColmapPose(frame.rig_from_world, fmt::format("{}, frame {}", in.Where(), id));
    const std::size_t count = in.Count();
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_camera = in.IsCamera();
      const std::uint32_t sensor = in.Id();
      const auto image = static_cast<std::uint32_t>(in.DataId());
      if (is_camera) frame.images.push_back({sensor, image});
    }
  }
  return frames;
}

template <typename Values>
std::map<std::uint32_t, Rigid3> RigPosesIn(const fs::path& rigs_file, const fs::path& frames_file) {
  const std::map<std::uint32_t, ColmapRig> rigs = ReadColmapRigs<Values>(rigs_file);
  std::map<std::uint32_t, Rigid3> poses;
  for (const ColmapFrame& frame : ReadColmapFrames<Values>(frames_file)) {
    const auto rig = rigs.find(frame.rig);
    if (rig == rigs.end()) continue;
    for (const auto& [camera, image] : frame.images)
      if (const auto sensor = rig->second.find(camera); sensor != rig->second.end())
        poses[image] = sensor->second * frame.rig_from_world;
  }
  return poses;
}

// Compares except for rounding in text.
bool IsSameUpToRounding(const Rigid3& given, const Rigid3& pose) {
  constexpr double kRounding = 1e-6;
  const double length = given.rotation.norm();
  return length > 0 && given.translation.allFinite() &&
         RotationAngle(given.rotation.normalized() * pose.rotation.conjugate()) <= kRounding &&
         (given.translation - pose.translation).norm() <= kRounding * (1 + pose.translation.norm());
}

std::array<double, 7> ColmapPoseNumbers(const Rigid3& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

}  // namespace

std::map<std::uint32_t, Rigid3> ReadColmapRigPoses(const fs::path& dir, bool binary) {
  const char* ending = binary ? ".bin" : ".txt";
  const fs::path rigs = dir / (std::string("rigs") + ending), frames = dir / (std::string("frames") + ending);
  std::error_code unknown;
  if (!fs::exists(rigs, unknown) || !fs::exists(frames, unknown)) return {};
  return binary ? RigPosesIn<ColmapRigBytes>(rigs, frames) : RigPosesIn<ColmapRigRows>(rigs, frames);
}

void SettleColmapPoses(const fs::path& dir, bool binary, ColmapReconstruction& model) {
  const std::map<std::uint32_t, Rigid3> by_rigs = ReadColmapRigPoses(dir, binary);
  const fs::path file = dir / (binary ? "images.bin" : "images.txt");
  std::size_t moved = 0, scaled = 0;
  double most_off = 0;
  for (ColmapReconstruction::Image& image : model.images) {
    Rigid3& pose = image.cam_from_world;
    const auto by_rig = by_rigs.find(image.id);
    if (by_rig != by_rigs.end()) {
      moved += !IsSameUpToRounding(pose, by_rig->second);
      pose = by_rig->second;  // which two far transforms may have brought beyond all numbers
    }
    const double off =
        NormalizeColmapPose(pose, fmt::format("{}, image {} ({})", file.string(), image.id, image.name));
    scaled += off > kQuaternionTolerance;
    most_off = std::max(most_off, off);
  }
  if (moved > 0)
    model.doubts.push_back(fmt::format(
        "{}: {} {} another pose by rigs and frames than in {}; that by the rig is taken, as COLMAP does",
        dir.string(), Counted(moved, "image"), moved == 1 ? "has" : "have", file.filename().string()));
  if (scaled > 0)
    model.doubts.push_back(fmt::format("{}: {} whose length is not 1 (off by up to {:.2g}): normalised",
                                       file.string(), Counted(scaled, "quaternion"), most_off));
}

ColmapRigFiles ToColmapRigs(const ColmapReconstruction& model, bool binary) {
  ColmapRigFiles files;
  if (!binary) {
    files.rigs = "# RIG_ID NUM_SENSORS REF_SENSOR_TYPE REF_SENSOR_ID, then other sensors: none\n";
    for (const ColmapReconstruction::Camera& camera : model.cameras)
      files.rigs += fmt::format("{} 1 {} {}\n", camera.id, kCameraSensorName, camera.id);
    files.frames =
        "# FRAME_ID RIG_ID RIG_FROM_WORLD[QW QX QY QZ TX TY TZ] NUM_DATA_IDS DATA_IDS[] as SENSOR_TYPE "
        "SENSOR_ID DATA_ID\n";
    for (const ColmapReconstruction::Image& image : model.images)
      files.frames += fmt::format("{} {} {} 1 {} {} {}\n", image.id, image.camera,
                                  fmt::join(ColmapPoseNumbers(image.cam_from_world), " "), kCameraSensorName,
                                  image.camera, image.id);
    return files;
  }
  ByteWriter rigs, frames;
  constexpr std::uint32_t kOne = 1;
  rigs.Put(static_cast<std::uint64_t>(model.cameras.size()));
  for (const ColmapReconstruction::Camera& camera : model.cameras) {
    rigs.Put(camera.id);
    rigs.Put(kOne);  // sensor
    rigs.Put(kCameraSensor);
    rigs.Put(camera.id);
  }
  frames.Put(static_cast<std::uint64_t>(model.images.size()));
  for (const ColmapReconstruction::Image& image : model.images) {
    frames.Put(image.id);
    frames.Put(image.camera);  // its rig
    for (const double number : ColmapPoseNumbers(image.cam_from_world)) frames.Put(number);
    frames.Put(kOne);  // image
    frames.Put(kCameraSensor);
    frames.Put(image.camera);
    frames.Put(static_cast<std::uint64_t>(image.id));
  }
  return {std::move(rigs.bytes()), std::move(frames.bytes())};
}

}  // namespace ulf

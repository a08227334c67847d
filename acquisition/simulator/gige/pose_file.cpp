#include "acquisition/simulator/gige/pose_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>

#include "core/base/error.h"

namespace ulf::acquisition {

PoseFile::PoseFile(const std::filesystem::path& file, const std::string& scene) {
  if (file.empty()) return;
  file_ = std::fopen(file.c_str(), "w");
  if (!file_) throw Error("{}: cannot be written: {}", file.string(), std::strerror(errno));
  Put(fmt::format(
      "# ulf simulate, scene {}: camera-to-world poses in TUM's format, metres\n"
      "# timestamp[s, device clock, start of exposure] tx ty tz qx qy qz qw (middle of exposure)\n",
      scene));
}

bool PoseFile::Put(const std::string& text) {
  std::clearerr(file_);
  const bool taken = std::fwrite(text.data(), 1, text.size(), file_) == text.size();
  return std::fflush(file_) == 0 && taken;
}

PoseFile::~PoseFile() {
  if (file_) std::fclose(file_);
}

bool PoseFile::Write(std::uint64_t frame_id, std::uint64_t device_ns, const Frame& frame, double hand_s) {
  if (!file_) return true;
  const Rigid3 world_from_cam = frame.known_cam_from_world->Inverse();
  const Eigen::Vector3d& t = world_from_cam.translation;
  const Eigen::Quaterniond& q = world_from_cam.rotation;
  return Put(
      fmt::format("# frame {} hand_s {:.6f}\n{}.{:09d} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                  frame_id, hand_s, device_ns / 1000000000u, device_ns % 1000000000u, t.x(), t.y(), t.z(),
                  q.x(), q.y(), q.z(), q.w()));
}

}  // namespace ulf::acquisition

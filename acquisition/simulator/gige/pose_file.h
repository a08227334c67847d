// The poses that the simulated camera writes beside its stream, in TUM's format (simulated_gige_camera.h).
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

#include "core/frames/frame.h"

namespace ulf::acquisition {

class PoseFile {
 public:
  // `file`: empty: nothing is written. Throws Error where it cannot be.
  PoseFile(const std::filesystem::path& file, const std::string& scene);
  ~PoseFile();
  PoseFile(const PoseFile&) = delete;
  PoseFile& operator=(const PoseFile&) = delete;

  // `device_ns`: the frame's time at its client; `hand_s`: of the hand's motion. In the file when this
  // returns true; false where the disk is full, and the next one is tried again.
  bool Write(std::uint64_t frame_id, std::uint64_t device_ns, const Frame& frame, double hand_s);

 private:
  bool Put(const std::string& text);
  std::FILE* file_ = nullptr;
};

}  // namespace ulf::acquisition

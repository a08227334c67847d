// Writes the poses of the simulated camera beside its stream, in TUM's format (simulated_gige_camera.h).
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

#include "core/frames/frame.h"

namespace ulf::acquisition {

class PoseFile {
 public:
  // An empty `file` is not written. Throws Error if the file cannot be written.
  PoseFile(const std::filesystem::path& file, const std::string& scene);
  ~PoseFile();
  PoseFile(const PoseFile&) = delete;
  PoseFile& operator=(const PoseFile&) = delete;

  // Writes a frame's pose to the file. `device_ns`: the frame's time at its client; `hand_s`: that of the
  // hand's motion. Returns false if it could not be written, as on a full disk; later calls try again.
  bool Write(std::uint64_t frame_id, std::uint64_t device_ns, const Frame& frame, double hand_s);

 private:
  bool Put(const std::string& text);
  std::FILE* file_ = nullptr;
};

}  // namespace ulf::acquisition

#include "coverage/capture_start.h"

#include <spdlog/fmt/fmt.h>

#include <chrono>

#include "acquisition/atomic_file.h"
#include "acquisition/error.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

void WriteFiles(const fs::path& folder, std::size_t number, const Frame& photograph) {
  for (const auto* file : {&photograph.encoded, &photograph.raw})
    if (*file)
      WriteFileAtomically(folder / fmt::format("{:06}{}", number, (*file)->extension), *(*file)->bytes);
}

}  // namespace

bool TakeFirstFrames(Device& device, const std::string& uri, const std::function<bool()>& stop,
                     std::vector<Frame>& taken) {
  constexpr std::chrono::seconds kPatience(10);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < until && !stop()) {
    auto frame = device.Next(std::chrono::milliseconds(200));
    for (const DeviceEvent& event : device.TakeEvents()) fmt::print(stderr, "{}\n", event.text);
    if (!frame && IsOver(device.State())) break;
    if (!frame) continue;
    const bool live = frame->kind == FrameKind::kLive;
    if (live && frame->status != FrameStatus::kComplete) continue;  // the device counts them
    taken.push_back(std::move(*frame));
    if (live) return true;
  }
  if (stop()) return false;
  throw Error("{}: no complete frame came; see 'ulf devices' for what is known about it", uri);
}

void KeepPhotographs(Device& device, const std::vector<Frame>& taken, LightFieldWriter* writer,
                     const fs::path& dir) {
  std::vector<Frame> photographs;
  for (const Frame& frame : taken)
    if (frame.kind == FrameKind::kStill) photographs.push_back(frame);
  try {
    device.Stop();
    while (auto frame = device.TakesStills() ? device.Next(std::chrono::milliseconds(0)) : std::nullopt)
      if (frame->kind == FrameKind::kStill) photographs.push_back(std::move(*frame));
    // A recording still has its own.
    if (photographs.empty() || !device.IsLive()) return;
    const fs::path folder = writer ? dir / "unposed" : fs::path(dir.string() + ".photographs");
    if (!writer) MakeFolder(folder);
    for (std::size_t i = 0; i < photographs.size(); ++i) {
      if (writer)
        writer->KeepUnposed(photographs[i]);
      else
        WriteFiles(folder, i + 1, photographs[i]);
    }
    fmt::print(stderr, "{} photographs had come already: they are kept in {}\n", photographs.size(),
               folder.string());
  } catch (const std::exception& error) {
    fmt::print(stderr, "{} photographs had come already and cannot be kept: {}\n", photographs.size(),
               error.what());
  }
}

}  // namespace ulf

#include "coverage/capture_start.h"

#include <spdlog/fmt/fmt.h>

#include <chrono>
#include <map>

#include "acquisition/counted.h"
#include "acquisition/error.h"
#include "coverage/kept_photographs.h"

namespace ulf {
namespace fs = std::filesystem;

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
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());  // what is in hand is kept all the same
  }
  try {
    while (auto frame = device.TakesStills() ? device.Next(std::chrono::milliseconds(0)) : std::nullopt)
      if (frame->kind == FrameKind::kStill) photographs.push_back(std::move(*frame));
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
  }
  if (photographs.empty() || !device.IsLive()) return;  // a recording still has its own
  std::map<fs::path, std::size_t> kept_in;
  std::size_t lost = 0;
  std::string problem;
  for (const Frame& photograph : photographs) {
    fs::path folder;
    const auto keep_in = [&](const fs::path& where, const auto& write) {
      if (!folder.empty()) return;
      try {
        write();
        folder = where;
      } catch (const std::exception& error) {
        problem = error.what();
      }
    };
    if (writer) keep_in(dir / "unposed", [&] { writer->KeepUnposed(photograph); });
    keep_in(FolderBeside(dir), [&] { KeepBeside(FolderBeside(dir), photograph); });
    ++(folder.empty() ? lost : kept_in[folder]);
  }
  for (const auto& [folder, count] : kept_in)
    fmt::print(stderr, "{} had come already: kept in {}\n", Counted(count, "photograph"), folder.string());
  if (lost > 0)
    fmt::print(stderr, "{} had come already and cannot be kept: {}\n", Counted(lost, "photograph"), problem);
}

}  // namespace ulf

#include "acquisition/gphoto2/photograph_downloads.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/base/host_time.h"

namespace ulf::acquisition {
namespace {

// The pauses double, so that a file is given up after 6 s. A busy camera, which writes to its card, gets
// longer. All guessed.
constexpr int kTries = 6;
constexpr double kFirstRetryS = 0.2, kFirstBusyPauseS = 0.1, kLongestBusyPauseS = 1.6;
constexpr double kBusyPatienceS = 20;

}  // namespace

void PhotographDownloads::Announced(const GphotoFile& where, DownloadedFile file, double now_s) {
  waiting_.push_back({where, std::move(file), now_s, now_s});
}

bool PhotographDownloads::Awaits(const std::string& stem) const {
  return std::any_of(waiting_.begin(), waiting_.end(),
                     [&](const Waiting& waiting) { return StemOf(waiting.where.name) == stem; });
}

PhotographDownloads::Outcome PhotographDownloads::Work(double now_s) {
  Outcome outcome;
  for (std::size_t i = 0; i < waiting_.size();) {
    Waiting& waiting = waiting_[i];
    if (waiting.again_s > now_s) {
      ++i;
      continue;
    }
    const auto began = std::chrono::steady_clock::now();
    const GphotoResult result = camera_.Download(waiting.where, waiting.file.bytes);
    bool done = true;
    if (result.ok()) {
      spdlog::debug("{}, {} bytes in {:.3f} s", waiting.where.Path(), waiting.file.bytes.size(),
                    SecondsSince(began));
      outcome.downloaded.emplace_back(waiting.where, std::move(waiting.file));
    } else {
      done = GivesUp(result, now_s, waiting, outcome);
      if (done) outcome.given_up.push_back(std::move(waiting.file));
    }
    if (done)
      waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
    else
      ++i;
    if (!result.ok() && !result.Busy())
      break;  // the caller checks first whether the camera is still connected
  }
  return outcome;
}

bool PhotographDownloads::GivesUp(const GphotoResult& result, double now_s, Waiting& waiting,
                                  Outcome& outcome) {
  waiting.file.bytes.clear();
  if (!result.Busy()) outcome.failure = result;
  if (result.Busy() && now_s - waiting.announced_s < kBusyPatienceS) {
    waiting.busy_pause_s = std::clamp(2 * waiting.busy_pause_s, kFirstBusyPauseS, kLongestBusyPauseS);
    waiting.again_s = now_s + waiting.busy_pause_s;
    return false;
  }
  const std::string path = waiting.where.Path();
  if (!result.Busy() && !result.NoSuchFile() && ++waiting.failures < kTries) {
    waiting.again_s = now_s + std::ldexp(kFirstRetryS, waiting.failures - 1);
    if (waiting.failures == 1)
      outcome.messages.push_back(
          fmt::format("{} could not be downloaded ({}); ulf tries again", path, result.text));
    return false;
  }
  outcome.messages.push_back(
      result.NoSuchFile()
          ? fmt::format("{} was announced, but is no longer in the camera: this photograph is lost", path)
          : fmt::format("{} was not downloaded ({}); it is still in the camera: copy it from the card", path,
                        result.text));
  return true;
}

std::vector<std::pair<GphotoFile, DownloadedFile>> PhotographDownloads::GiveUpAll() {
  std::vector<std::pair<GphotoFile, DownloadedFile>> all;
  for (Waiting& waiting : waiting_) all.emplace_back(waiting.where, std::move(waiting.file));
  waiting_.clear();
  return all;
}

}  // namespace ulf::acquisition

#include "acquisition/gphoto2/photograph_recovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/base/counted.h"

namespace ulf::acquisition {
namespace {

// A camera that has just been switched on may be busy for seconds: so many questions, each a round of its
// thread. Guessed.
constexpr int kBusyListings = 100;

}  // namespace

std::string NamesOf(const std::vector<FileInCamera>& files) {
  std::string names;
  for (const auto& [where, file] : files) names += (names.empty() ? "" : ", ") + where.Path();
  return names;
}

std::optional<PhotographRecovery::Found> PhotographRecovery::Work() {
  if (!to_fetch_) return std::nullopt;
  Found found;
  std::vector<GphotoFile>& since = found.since;
  if (to_fetch_->last) {
    std::vector<std::string> names;
    const GphotoResult result = camera_.FilesIn(to_fetch_->last->folder, names);
    if (result.Busy() && ++busy_listings_ < kBusyListings) return std::nullopt;
    if (!result.ok() && gone_(result)) return std::nullopt;
    if (!result.ok())
      notice_(fmt::format(
          "the camera does not say what it holds ({}): photographs taken while the link was gone are "
          "on its card",
          result.text));
    since = left_.PhotographsAfter(*to_fetch_, std::move(names));
    if (!LeaveOlder(since)) return std::nullopt;
  } else if (to_fetch_->released_s > 0) {
    notice_(
        "a photograph may have been taken while the link was gone, and none before: ulf cannot tell which "
        "file of the card it is; copy it from there");
  }
  std::vector<FileInCamera>& files = found.files;
  files = std::move(to_fetch_->waiting);
  found.counted = files.size();
  std::ranges::move(UnfetchedPhotographs::CameSince(*to_fetch_, since), std::back_inserter(files));
  to_fetch_.reset();
  if (!files.empty())
    notice_(fmt::format("{} that stayed in the camera when its link dropped: {}",
                        Counted(files.size(), "file"), NamesOf(files)));
  return found;
}

// Leaves out what the camera wrote before the last file that it announced, by its own clock, whatever that
// shows: a card may hold higher numbers from earlier sessions, and the same. Returns false when the camera is
// gone.
bool PhotographRecovery::LeaveOlder(std::vector<GphotoFile>& files) {
  constexpr double kOneAfterAnother_s =
      60;  // the two files of a photograph are written in either order; guessed
  std::optional<double> last_s;
  if (files.empty()) return true;
  if (const GphotoResult result = camera_.WrittenAt(*to_fetch_->last, last_s); !result.ok() && gone_(result))
    return false;
  if (!last_s) return true;
  std::vector<FileInCamera> older;
  for (const GphotoFile& file : files) {
    std::optional<double> written_s;
    if (const GphotoResult result = camera_.WrittenAt(file, written_s); !result.ok() && gone_(result))
      return false;
    if (written_s && *written_s < *last_s - kOneAfterAnother_s) older.emplace_back(file, DownloadedFile{});
  }
  if (older.empty()) return true;
  std::erase_if(files, [&](const GphotoFile& file) {
    return std::ranges::any_of(older, [&](const FileInCamera& each) { return each.first.name == file.name; });
  });
  constexpr std::size_t kMostNames = 5;
  const std::size_t count = older.size();
  older.resize(std::min(count, kMostNames));
  notice_(fmt::format(
      "{} not fetched, because the camera's clock says that they are from before: {}{}; if that was "
      "set back meanwhile, copy them from the card",
      Counted(count, "file"), NamesOf(older), count > kMostNames ? ", ..." : ""));
  return true;
}

}  // namespace ulf::acquisition

#include "coverage/operator/stored_pictures.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <exception>

#include "core/light_field/journal.h"
#include "core/light_field/light_field_io.h"

namespace ulf::coverage {

StoredPictures::StoredPictures(const std::filesystem::path& light_field) {
  on_disk_.root = light_field;
  thread_ = std::thread([this] { Loop(); });
}

StoredPictures::~StoredPictures() {
  {
    const MutexLock lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::size_t StoredPictures::Want(std::vector<int> ids) {
  const MutexLock lock(mutex_);
  std::erase_if(ids, [this](int id) ULF_REQUIRES(mutex_) { return unreadable_.contains(id); });
  const std::size_t to_come = ids.size();
  std::erase_if(ids, [this](int id) ULF_REQUIRES(mutex_) { return read_.contains(id); });
  if (ids != wanted_) {
    wanted_ = std::move(ids);
    changed_.notify_all();
  }
  return to_come;
}

std::map<int, PosedPicture> StoredPictures::Take() {
  const MutexLock lock(mutex_);
  return std::exchange(read_, {});
}

std::optional<std::string> StoredPictures::TakeProblem() {
  const MutexLock lock(mutex_);
  if (problems_.empty()) return std::nullopt;
  std::string first = std::move(problems_.front());
  problems_.erase(problems_.begin());
  return first;
}

void StoredPictures::Say(const std::string& problem) {
  const MutexLock lock(mutex_);
  problems_.push_back(problem);
}

const View* StoredPictures::Find(int id) const {
  const auto found = std::lower_bound(on_disk_.views.begin(), on_disk_.views.end(), id,
                                      [](const View& view, int wanted) { return view.id < wanted; });
  return found != on_disk_.views.end() && found->id == id ? &*found : nullptr;
}

// Not as a light field is opened: that makes what a killed writer left unfinished.
void StoredPictures::ReadJournal() {
  constexpr std::chrono::milliseconds kSoonest(500);
  constexpr int kShareOfTime = 20;  // long journals take long to read
  const auto start = Clock::now();
  try {
    on_disk_ = ulf::ReadJournal(on_disk_.root / "journal.jsonl").light_field;
  } catch (const std::exception& error) {
    if (!std::exchange(said_journal_, true))
      Say(fmt::format("{}; review shows only what was recorded since it began", error.what()));
  }
  const auto now = Clock::now();
  journal_due_ = now + std::max<Clock::duration>(kSoonest, kShareOfTime * (now - start));
}

void StoredPictures::Read(const View& view) {
  const int id = view.id;
  std::string problem;
  try {
    PosedPicture picture = PosedPicture::Of(ReadRecordedImage(on_disk_, view), on_disk_.CameraOf(view),
                                            view.cam_from_world, static_cast<std::uint64_t>(id));
    const MutexLock lock(mutex_);
    read_.insert_or_assign(id, std::move(picture));
    return;
  } catch (const std::exception& error) {
    problem = fmt::format("{}; review goes without view {}", error.what(), id);
  }
  // One that has been taken back meanwhile is nobody's any more.
  ReadJournal();
  const bool is_still_there = Find(id) != nullptr;
  const MutexLock lock(mutex_);
  unreadable_.insert(id);
  if (is_still_there) problems_.push_back(problem);
}

void StoredPictures::Loop() {
  constexpr int kNiceness = 10;  // tracking comes first, and the disk's own threads
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNiceness);  // of this thread alone
  MutexLock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this]() ULF_REQUIRES(mutex_) { return over_ || !wanted_.empty(); });
    if (over_) return;
    const std::vector<int> wanted = wanted_;
    lock.unlock();
    const View* next = nullptr;
    for (std::size_t i = 0; i < wanted.size() && !next; ++i) next = Find(wanted[i]);
    const bool reads_journal = !next && Clock::now() >= journal_due_;
    if (next) {
      const int id = next->id;
      Read(*next);
      lock.lock();
      std::erase(wanted_, id);
    } else if (reads_journal) {
      ReadJournal();
      lock.lock();
    } else {
      lock.lock();
      changed_.wait_until(lock, journal_due_,
                          [&]() ULF_REQUIRES(mutex_) { return over_ || wanted_ != wanted; });
    }
  }
}

}  // namespace ulf::coverage

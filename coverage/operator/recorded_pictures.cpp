#include "coverage/operator/recorded_pictures.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "core/light_field/folder/journal.h"
#include "core/light_field/folder/view_images.h"

namespace ulf::coverage {
namespace {

// Guessed.
constexpr std::size_t kPicturesMostDrawn = 3;    // by Nearest(); more blur, fewer jump
constexpr std::size_t kPicturesMostFetched = 8;  // around a camera, ahead of its movement
constexpr double kPicturesLeastShare = 0.01;     // of the nearest one's weight; less is not worth drawing

using Eigen::Vector3d;

struct Candidate {
  double cosine;  // between the directions of the view and of the camera
  std::size_t view;
  bool operator<(const Candidate& other) const { return cosine > other.cosine; }  // the nearest first
};

void SortFirst(std::vector<Candidate>& candidates, std::size_t count) {
  const auto end = candidates.begin() + static_cast<long>(std::min(count, candidates.size()));
  std::partial_sort(candidates.begin(), end, candidates.end());
  candidates.erase(end, candidates.end());
}

}  // namespace

// A picture under a lens that another has replaced; the journal may have been read before that.
void RecordedPictures::ConvertToLens(PosedPicture& picture) const {
  const int width = picture.camera.width, height = picture.camera.height;
  if (std::ranges::any_of(former_lenses_, [&](const CameraModel& former) {
        return former.ScaledTo(width, height) == picture.camera;
      }))
    picture.camera = lens_->ScaledTo(width, height);
}

void RecordedPictures::Follow(const CaptureState& state) {
  if (lens_ && *lens_ != state.recorded_camera) {
    former_lenses_.push_back(*lens_);
    lens_ = state.recorded_camera;
    for (auto& [id, held] : held_) ConvertToLens(held.picture);
  }
  lens_ = state.recorded_camera;
  const auto is_there = [&](int id) { return std::ranges::binary_search(state.view_ids, id); };
  std::erase_if(held_, [&](const auto& held) {
    if (is_there(held.first)) return false;
    bytes_ -= held.second.picture.jpeg.size();
    return true;
  });
  if (stored_)
    for (auto& [id, picture] : stored_->Take())
      if (is_there(id)) Hold(id, std::move(picture));
  const auto& newest = state.newest_view;
  if (!newest || newest->id <= newest_) return;
  newest_ = newest->id;
  if (is_there(newest_))
    Hold(newest_, PosedPicture::Of(newest->frame.image, newest->camera, newest->cam_from_world,
                                   static_cast<std::uint64_t>(newest_)));
}

void RecordedPictures::Hold(int id, PosedPicture picture) {
  ConvertToLens(picture);
  Held& held = held_[id];
  bytes_ += picture.jpeg.size() - held.picture.jpeg.size();
  held = {std::move(picture), ++clock_};
  MakeRoom();
}

// Drops the pictures that were drawn least recently; they can be read again.
void RecordedPictures::MakeRoom() {
  while (bytes_ > most_bytes_ && held_.size() > 1) {
    const auto oldest = std::ranges::min_element(
        held_, [](const auto& a, const auto& b) { return a.second.used < b.second.used; });
    bytes_ -= oldest->second.picture.jpeg.size();
    held_.erase(oldest);
  }
}

std::vector<WeightedPicture> RecordedPictures::Nearest(const CaptureState& state,
                                                       const Rigid3& cam_from_world) {
  missing_ = 0;
  if (!state.subject || !state.coverage) return {};
  const Vector3d& subject = state.subject->center_in_world;
  const Vector3d direction = (cam_from_world.OriginInSource() - subject).normalized();
  const std::vector<CriterionView>& views = state.coverage->views();
  std::vector<Candidate> all, at_hand;
  auto held = held_.begin();  // by id, as the views are
  for (std::size_t i = 0; i < std::min(views.size(), state.view_ids.size()); ++i) {
    all.push_back({direction.dot((views[i].center_in_world - subject).normalized()), i});
    while (held != held_.end() && held->first < state.view_ids[i]) ++held;
    if (held != held_.end() && held->first == state.view_ids[i]) at_hand.push_back(all.back());
  }
  SortFirst(all, kPicturesMostFetched);
  std::vector<int> lacking;
  for (const Candidate& candidate : all)
    if (!held_.contains(state.view_ids[candidate.view])) lacking.push_back(state.view_ids[candidate.view]);
  if (!stored_ && !lacking.empty() && !state.light_field.empty())
    stored_ = std::make_unique<StoredPictures>(state.light_field);
  if (stored_) missing_ = stored_->Want(std::move(lacking));

  SortFirst(at_hand, kPicturesMostDrawn + 1);
  const auto angle = [&](std::size_t i) { return std::acos(std::clamp(at_hand[i].cosine, -1.0, 1.0)); };
  const std::size_t count = at_hand.size();
  const double end =
      count > kPicturesMostDrawn ? angle(kPicturesMostDrawn) : 2 * (count > 0 ? angle(count - 1) : 0) + 1e-6;
  std::vector<WeightedPicture> nearest;
  for (std::size_t i = 0; i < std::min(count, kPicturesMostDrawn); ++i) {
    const double share = 1 - angle(i) / std::max(end, 1e-9);
    if (i > 0 && share <= kPicturesLeastShare) continue;
    Held& drawn = held_.at(state.view_ids[at_hand[i].view]);
    drawn.used = ++clock_;
    // The pose may have been corrected since.
    const CriterionView& view = views[at_hand[i].view];
    const Eigen::Quaterniond rotation(view.cam_from_world);
    drawn.picture.cam_from_world = {rotation, -(rotation * view.center_in_world)};
    nearest.push_back({&drawn.picture, static_cast<float>(std::max(kPicturesLeastShare, share * share))});
  }
  return nearest;
}

std::optional<std::string> RecordedPictures::TakeProblem() {
  return stored_ ? stored_->TakeProblem() : std::nullopt;
}

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

// It reads only the journal: opening a light field would complete what a killed writer left.
void StoredPictures::ReadJournal() {
  constexpr std::chrono::milliseconds kSoonest(500);  // guessed, as the next one
  constexpr int kShareOfTime = 20;  // at most one part in so many of the time goes into reading the journal
  const auto start = Clock::now();
  try {
    on_disk_ = ulf::ReadJournal(on_disk_.root / "journal.jsonl").light_field;
  } catch (const std::exception& error) {
    if (!std::exchange(said_journal_, true))
      Say(fmt::format("{}; the review shows only views recorded after this program started", error.what()));
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
    problem = fmt::format("{}; the review leaves out view {}", error.what(), id);
  }
  // No problem is reported for a view that has been taken back meanwhile.
  ReadJournal();
  const bool is_still_there = Find(id) != nullptr;
  const MutexLock lock(mutex_);
  unreadable_.insert(id);
  if (is_still_there) problems_.push_back(problem);
}

void StoredPictures::Loop() {
  constexpr int kNiceness = 10;  // below tracking and the threads that write
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

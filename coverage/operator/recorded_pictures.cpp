#include "coverage/operator/recorded_pictures.h"

#include <algorithm>
#include <cmath>

namespace ulf::coverage {
namespace {

using Eigen::Vector3d;

bool Holds(const std::vector<int>& view_ids, int id) {
  return std::binary_search(view_ids.begin(), view_ids.end(), id);
}

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

void RecordedPictures::Follow(const CaptureState& state) {
  DropTakenBack(state.view_ids);
  if (stored_)
    for (auto& [id, picture] : stored_->Take())
      if (Holds(state.view_ids, id)) Hold(id, std::move(picture));
  const auto& newest = state.newest_view;
  if (!newest || newest->id <= newest_) return;
  newest_ = newest->id;
  if (Holds(state.view_ids, newest_))
    Hold(newest_, PosedPicture::Of(newest->frame.image, newest->camera, newest->cam_from_world,
                                   static_cast<std::uint64_t>(newest_)));
}

void RecordedPictures::DropTakenBack(const std::vector<int>& view_ids) {
  std::erase_if(held_, [&](const auto& held) {
    if (Holds(view_ids, held.first)) return false;
    bytes_ -= held.second.picture.jpeg.size();
    return true;
  });
}

void RecordedPictures::Hold(int id, PosedPicture picture) {
  Held& held = held_[id];
  bytes_ += picture.jpeg.size() - held.picture.jpeg.size();
  held = {std::move(picture), ++clock_};
  MakeRoom();
}

// Those that were not looked at for longest: whatever was dropped can be read again.
void RecordedPictures::MakeRoom() {
  while (bytes_ > options_.most_bytes && held_.size() > 1) {
    const auto oldest = std::min_element(held_.begin(), held_.end(), [](const auto& a, const auto& b) {
      return a.second.used < b.second.used;
    });
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
  SortFirst(all, options_.most_fetched);
  std::vector<int> lacking;
  for (const Candidate& candidate : all)
    if (!held_.contains(state.view_ids[candidate.view])) lacking.push_back(state.view_ids[candidate.view]);
  Fetch(state, std::move(lacking));

  SortFirst(at_hand, options_.most_drawn + 1);
  const auto angle = [&](std::size_t i) { return std::acos(std::clamp(at_hand[i].cosine, -1.0, 1.0)); };
  const std::size_t count = at_hand.size();
  const double end = count > options_.most_drawn ? angle(options_.most_drawn)
                                                 : 2 * (count > 0 ? angle(count - 1) : 0) + 1e-6;
  std::vector<WeightedPicture> nearest;
  for (std::size_t i = 0; i < std::min(count, options_.most_drawn); ++i) {
    const double share = 1 - angle(i) / std::max(end, 1e-9);
    if (i > 0 && share <= options_.least_share) continue;
    Held& drawn = held_.at(state.view_ids[at_hand[i].view]);
    drawn.used = ++clock_;
    // Poses are corrected while the capture goes on.
    const CriterionView& view = views[at_hand[i].view];
    const Eigen::Quaterniond rotation(view.cam_from_world);
    drawn.picture.cam_from_world = {rotation, -(rotation * view.center_in_world)};
    nearest.push_back({&drawn.picture, static_cast<float>(std::max(options_.least_share, share * share))});
  }
  return nearest;
}

void RecordedPictures::Fetch(const CaptureState& state, std::vector<int> ids) {
  if (!stored_) {
    if (ids.empty() || state.light_field.empty()) return;
    stored_ = std::make_unique<StoredPictures>(state.light_field);
  }
  missing_ = stored_->Want(std::move(ids));
}

std::optional<std::string> RecordedPictures::TakeProblem() {
  return stored_ ? stored_->TakeProblem() : std::nullopt;
}

}  // namespace ulf::coverage

#include "tracking/sources/poses_spec.h"

namespace ulf::tracking {
namespace {

class TrackerSource : public PoseSource {
 public:
  TrackerSource(const CameraModel& camera, const TrackerOptions& options) : tracker_(camera, options) {}
  Track Step(const Frame& frame) override { return tracker_.Step(frame); }
  std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near) const override {
    return tracker_.Locate(photograph.image, camera, near);
  }
  Rigid3 PoseOf(const Anchored& anchor) const override { return tracker_.PoseOf(anchor); }
  std::optional<Rigid3> PoseNow(const Track& track) const override { return tracker_.PoseNow(track); }
  int MapNow(const Track& track) const override { return tracker_.MapNow(track); }
  std::vector<VisiblePoint> VisiblePoints() const override { return tracker_.VisiblePoints(); }
  std::vector<ExpectedPoint> ExpectedPoints() const override { return tracker_.ExpectedPoints(); }
  void NoteView(int view_id, const Track& track) override { tracker_.NoteView(view_id, track); }
  std::vector<ScenePoint> Points() const override { return tracker_.Points(); }
  bool SeedMap(std::span<const SeedView> views, const SeedProgress& progress) override {
    return tracker_.SeedMap(views, progress);
  }
  void SaveMap(const std::filesystem::path& file, std::uint64_t key) const override {
    tracker_.SaveMap(file, key);
  }
  std::string RestoreMap(const std::filesystem::path& file, std::uint64_t key) override {
    return tracker_.RestoreMap(file, key);
  }
  void Finish() override { tracker_.Finish(); }
  TrackerStatistics Statistics() const override { return tracker_.Statistics(); }

 private:
  Tracker tracker_;
};

}  // namespace

std::unique_ptr<PoseSource> MakeTrackerSource(const CameraModel& camera, const TrackerOptions& options) {
  return std::make_unique<TrackerSource>(camera, options);
}

}  // namespace ulf::tracking

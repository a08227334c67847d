// The cache of photographs in graphics memory. Of each view it holds the pyramid level that a picture reads,
// up to a limit of memory, in texture arrays for one size each. The least recently used level is evicted.
//
// Require() is for pictures that must be exact: it waits for missing levels. If they do not all fit at once,
// the caller draws with the resident ones and requires the rest afterwards. Offer() is for pictures that must
// not wait: it takes the levels that the loader has read meanwhile, and substitutes other levels for missing
// ones, which RequestMissing() then lets the loader read.
//
// The context must be current for all functions, and for Release().
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/photographs/photograph.h"
#include "render/photographs/photograph_loader.h"

namespace ulf::render {

class GlPhotographs {
 public:
  struct LevelRequest {
    int view = 0;  // index into the scene's views
    int level = 0;
  };
  struct Place {
    unsigned texture = 0;  // GL_TEXTURE_2D_ARRAY
    int layer = 0;
    bool operator==(const Place&) const = default;
  };

  // Returns the memory for photographs: `asked_mb`, or if that is 0, three quarters of what the driver says
  // is free, or 2048 MB if it does not say.
  static std::size_t LimitBytes(double asked_mb);

  // `photographs` are those of the scene's views, in their order. All textures together never take more than
  // `limit_bytes`, or than the coarsest level of one photograph if that is larger.
  void Build(std::vector<std::shared_ptr<const Photograph>> photographs, std::size_t limit_bytes);

  // Makes as many of the first `level_requests` resident as fit, at least one, and returns how many. A level
  // that is larger than the limit is replaced by a coarser one. Throws what reading them throws.
  std::size_t Require(std::span<const LevelRequest> level_requests);
  // Returns whether all requested levels are resident, coarsened alike until they fit at once; for a missing
  // one it uses another level of the view, or none. Further requests for the same picture are offered
  // together with the earlier ones. It warns once of a photograph that cannot be read, and then ignores it.
  bool Offer(std::span<const LevelRequest> level_requests);
  // Requests from the loader what the last Offer() lacked, then what is expected.
  void RequestMissing() { RequestFromLoader(missing_, true); }
  // Sets what RequestMissing() requests last.
  void Expect(std::vector<LevelRequest> level_requests) { expected_ = std::move(level_requests); }

  // Returns the place of the view's photograph after Require() or Offer(); none if it has no level.
  std::optional<Place> PlaceOf(int view) const;
  std::optional<int> LevelOf(int view) const;
  bool HasAll(std::span<const LevelRequest> level_requests) const;
  // Returns whether they fit into graphics memory at the same time.
  bool HasRoomFor(std::span<const LevelRequest> level_requests) const;

  struct Counts {
    std::size_t uploads = 0;
    std::size_t bytes = 0, most_bytes = 0;  // of textures
  };
  const Counts& counts() const { return counts_; }
  std::size_t limit_bytes() const { return limit_bytes_; }
  int array_count() const { return static_cast<int>(arrays_.size()); }

  void Release();

 private:
  using Key = PhotographLoader::Key;
  struct Slot {
    std::optional<Key> key;
    std::uint64_t used = 0;  // clock_ at the last use
  };
  struct Array {
    unsigned texture = 0;
    cv::Size size;
    std::vector<Slot> slots;  // by layer
  };
  struct Found {
    Array* array;
    std::size_t layer;
  };

  static Key KeyOf(const LevelRequest& level_request) { return {level_request.view, level_request.level}; }
  std::size_t LayerBytes(const cv::Size& size) const;
  int PreviewLevel(const LevelRequest& level_request) const;
  LevelRequest WithinLimit(LevelRequest level_request) const;
  const Photograph& PhotographOf(int view) const { return *photographs_[static_cast<std::size_t>(view)]; }
  Array MakeArray(const cv::Size& size, std::size_t layers);
  void Forget(const Key& key);
  void Remove(Array& array);
  void Grow(Array& array, std::size_t layers);
  std::optional<Found> FreeSlot(const cv::Size& size, std::size_t wanted);
  std::optional<Found> LeastUsedSlot(const cv::Size& size);
  static std::uint64_t LastUse(const Array& array);
  Array* LeastUsedArray(const cv::Size& other_than) const;
  std::optional<Found> MakeRoomFor(const cv::Size& size, std::size_t wanted);
  void Upload(const Found& where, const Key& key, const cv::Mat& pixels);
  std::optional<Key> ClosestTo(const Key& key) const;
  void Use(const Key& key);
  std::vector<LevelRequest> CoarsenedToFit(std::span<const LevelRequest> requests);
  bool TakeFromLoader(const LevelRequest& level_request, std::size_t& copied, std::size_t wanted);
  void RequestFromLoader(std::span<const LevelRequest> missing, bool preview_first);

  std::vector<std::shared_ptr<const Photograph>> photographs_;
  std::size_t limit_bytes_ = 0;
  bool linear_ = false;
  std::vector<std::unique_ptr<Array>> arrays_;
  std::map<Key, Found> where_;
  std::map<int, Key> serving_;  // by view, of the last Require() or Offer()
  std::uint64_t clock_ = 0;     // counts Require() and Offer()
  std::vector<LevelRequest> missing_, expected_;
  std::vector<bool> unreadable_;  // views
  bool warned_too_large_ = false;
  Counts counts_;
  std::unique_ptr<PhotographLoader> loader_;
};

}  // namespace ulf::render

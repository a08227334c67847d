#include "render/gl/gl_photographs.h"

#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/base/at.h"
#include "core/base/error.h"
#include "render/gl/gl_objects.h"

namespace ulf::render {

// The largest texture array. Measured on llvmpipe: 1.26 GB works, 2.3 GB does not.
constexpr std::size_t kMostArrayBytes = 1000000000;
// Offer() copies no more than this in one call; more would delay the picture. Guessed.
constexpr std::size_t kOfferedBytes = std::size_t{32} << 20;
// For a view without any level the loader first reads one that is coarser by this: 1/64 of the bytes.
constexpr int kPreviewLevels = 3;

std::size_t GlPhotographs::LimitBytes(double asked_mb) {
  // The limit if the driver does not say what is free, and the used share of what is free. Guessed.
  constexpr double kUsualMb = 2048, kShare = 0.75;
  if (asked_mb > 0) return static_cast<std::size_t>(1e6 * asked_mb);
  GLint free_kb[4] = {};
  if (epoxy_has_gl_extension("GL_NVX_gpu_memory_info"))
    glGetIntegerv(GL_GPU_MEMORY_INFO_CURRENT_AVAILABLE_VIDMEM_NVX, free_kb);
  else if (epoxy_has_gl_extension("GL_ATI_meminfo"))
    glGetIntegerv(GL_TEXTURE_FREE_MEMORY_ATI, free_kb);
  return free_kb[0] > 0 ? static_cast<std::size_t>(kShare * 1024 * free_kb[0])
                        : static_cast<std::size_t>(1e6 * kUsualMb);
}

void GlPhotographs::Build(std::vector<std::shared_ptr<const Photograph>> photographs,
                          std::size_t limit_bytes) {
  photographs_ = std::move(photographs);
  linear_ = photographs_.front()->linear();
  limit_bytes_ = limit_bytes;  // but at least the coarsest level of every photograph
  for (const auto& photograph : photographs_)
    limit_bytes_ = std::max(limit_bytes_, LayerBytes(photograph->LevelSize(photograph->LevelCount() - 1)));
  unreadable_.assign(photographs_.size(), false);
  loader_ = std::make_unique<PhotographLoader>();
}

std::size_t GlPhotographs::LayerBytes(const cv::Size& size) const {
  const std::size_t pixel_bytes = linear_ ? 8 : 4;  // drivers hold three channels of 8 bits as four
  return static_cast<std::size_t>(size.area()) * pixel_bytes;
}

int GlPhotographs::PreviewLevel(const LevelRequest& level_request) const {
  return std::min(level_request.level + kPreviewLevels, PhotographOf(level_request.view).LevelCount() - 1);
}

GlPhotographs::LevelRequest GlPhotographs::WithinLimit(LevelRequest level_request) const {
  const Photograph& photograph = PhotographOf(level_request.view);
  while (level_request.level + 1 < photograph.LevelCount() &&
         LayerBytes(photograph.LevelSize(level_request.level)) > limit_bytes_)
    ++level_request.level;
  return level_request;
}

GlPhotographs::Array GlPhotographs::MakeArray(const cv::Size& size, std::size_t layers) {
  Array array{0, size, std::vector<Slot>(layers)};
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &array.texture);
  glTextureStorage3D(array.texture, 1, linear_ ? GL_RGBA16F : GL_SRGB8_ALPHA8, size.width, size.height,
                     static_cast<GLsizei>(layers));
  CheckMade("making room for photographs", [&] { glDeleteTextures(1, &array.texture); });
  counts_.bytes += layers * LayerBytes(size);
  counts_.most_bytes = std::max(counts_.most_bytes, counts_.bytes);
  SetSampling(array.texture, GL_LINEAR);
  return array;
}

void GlPhotographs::Forget(const Key& key) {
  where_.erase(key);
  const auto serves = serving_.find(key.first);
  if (serves != serving_.end() && serves->second == key) serving_.erase(serves);
}

void GlPhotographs::Remove(Array& array) {
  for (const Slot& slot : array.slots)
    if (slot.key) Forget(*slot.key);
  glDeleteTextures(1, &array.texture);
  counts_.bytes -= array.slots.size() * LayerBytes(array.size);
  std::erase_if(arrays_, [&](const auto& each) { return each.get() == &array; });
}

void GlPhotographs::Grow(Array& array, std::size_t layers) {
  Array larger = MakeArray(array.size, layers);
  glCopyImageSubData(array.texture, GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, larger.texture, GL_TEXTURE_2D_ARRAY, 0,
                     0, 0, 0, array.size.width, array.size.height, static_cast<GLsizei>(array.slots.size()));
  CheckGl("moving photographs to where there is more room");
  glDeleteTextures(1, &array.texture);
  counts_.bytes -= array.slots.size() * LayerBytes(array.size);
  array.texture = larger.texture;
  array.slots.resize(layers);  // the first layers keep their contents
}

// Returns an empty layer, in a new array or a larger one if there is room. `wanted` is the number of layers
// that the caller needs.
std::optional<GlPhotographs::Found> GlPhotographs::FreeSlot(const cv::Size& size, std::size_t wanted) {
  Array* largest = nullptr;
  for (const auto& array : arrays_) {
    if (array->size != size) continue;
    for (std::size_t layer = 0; layer < array->slots.size(); ++layer)
      if (!array->slots[layer].key) return Found{array.get(), layer};
    if (!largest || array->slots.size() > largest->slots.size()) largest = array.get();
  }
  const std::size_t layer_bytes = LayerBytes(size);
  const std::size_t room = (limit_bytes_ - counts_.bytes) / layer_bytes;
  const std::size_t most =
      std::max<std::size_t>(1, std::min(kMostArrayBytes / layer_bytes, At(MostLayers())));
  if (largest) {
    // One array is faster to draw from than several. While it is copied both take memory.
    const std::size_t before = largest->slots.size();
    const std::size_t layers = std::min(std::max(2 * before, before + wanted), photographs_.size());
    if (layers > before && layers <= std::min(room, most)) {
      Grow(*largest, layers);
      return Found{largest, before};
    }
  }
  const std::size_t layers = std::min({std::max(wanted, largest ? largest->slots.size() : 0), room, most});
  if (layers == 0) return std::nullopt;
  arrays_.push_back(std::make_unique<Array>(MakeArray(size, layers)));
  return Found{arrays_.back().get(), 0};
}

// Returns none if all layers of this size are in use.
std::optional<GlPhotographs::Found> GlPhotographs::LeastUsedSlot(const cv::Size& size) {
  std::optional<Found> least;
  for (const auto& array : arrays_) {
    if (array->size != size) continue;
    for (std::size_t layer = 0; layer < array->slots.size(); ++layer) {
      const std::uint64_t used = array->slots[layer].used;
      if (used < clock_ && (!least || used < least->array->slots[least->layer].used))
        least = Found{array.get(), layer};
    }
  }
  return least;
}

std::uint64_t GlPhotographs::LastUse(const Array& array) {
  std::uint64_t last = 0;
  for (const Slot& slot : array.slots) last = std::max(last, slot.used);
  return last;
}

// Searches the arrays of other sizes.
GlPhotographs::Array* GlPhotographs::LeastUsedArray(const cv::Size& other_than) const {
  Array* least = nullptr;
  for (const auto& array : arrays_)
    if (array->size != other_than && (!least || LastUse(*array) < LastUse(*least))) least = array.get();
  return least;
}

std::optional<GlPhotographs::Found> GlPhotographs::MakeRoomFor(const cv::Size& size, std::size_t wanted) {
  for (;;) {
    if (const auto found = FreeSlot(size, wanted)) return found;
    const auto slot = LeastUsedSlot(size);
    Array* const array = LeastUsedArray(size);
    if (slot && (!array || slot->array->slots[slot->layer].used <= LastUse(*array))) return slot;
    if (!array || LastUse(*array) >= clock_) return slot;
    Remove(*array);
  }
}

void GlPhotographs::Upload(const Found& where, const Key& key, const cv::Mat& pixels) {
  Slot& slot = where.array->slots[where.layer];
  if (slot.key) Forget(*slot.key);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(where.array->texture, 0, 0, 0, static_cast<GLint>(where.layer), pixels.cols,
                      pixels.rows, 1, linear_ ? GL_BGRA : GL_BGR, linear_ ? GL_HALF_FLOAT : GL_UNSIGNED_BYTE,
                      pixels.data);
  CheckGl("copying photographs");
  ++counts_.uploads;
  slot.key = key;
  where_[key] = where;
  Use(key);
}

void GlPhotographs::Use(const Key& key) {
  const Found& found = where_.at(key);
  found.array->slots[found.layer].used = clock_;
  serving_[key.first] = key;
}

void GlPhotographs::RequestFromLoader(std::span<const LevelRequest> missing, bool preview_first) {
  std::vector<PhotographLoader::Request> requests;
  const auto ask = [&](const LevelRequest& level_request) {
    const auto view = At(level_request.view);
    if (!unreadable_[view]) requests.push_back({KeyOf(level_request), photographs_[view]});
  };
  if (preview_first)
    for (const LevelRequest& level_request : missing)
      if (!serving_.contains(level_request.view)) ask({level_request.view, PreviewLevel(level_request)});
  for (const LevelRequest& level_request : missing) ask(level_request);
  for (const LevelRequest& level_request : expected_) {
    const LevelRequest within = WithinLimit(level_request);
    if (!where_.contains(KeyOf(within))) ask(within);
  }
  loader_->SetRequests(std::move(requests));
}

std::size_t GlPhotographs::Require(std::span<const LevelRequest> requests) {
  ++clock_;
  serving_.clear();
  std::vector<LevelRequest> level_requests, missing;
  for (const LevelRequest& level_request : requests) {
    level_requests.push_back(WithinLimit(level_request));
    if (level_requests.back().level != level_request.level && !std::exchange(warned_too_large_, true))
      spdlog::warn(
          "one photograph alone is larger than {} MB of graphics memory ({}): a coarser level is used",
          limit_bytes_ / 1000000, Parameter("gpu_memory"));
    if (const Key key = KeyOf(level_requests.back()); where_.contains(key))
      Use(key);
    else
      missing.push_back(level_requests.back());
  }
  RequestFromLoader(missing, false);
  // Resident levels stay, except those of the last requests if the first ones would otherwise find no room.
  std::size_t left = missing.size(), done = 0, staying = level_requests.size();
  for (; done < staying; ++done) {
    const Key key = KeyOf(level_requests[done]);
    if (where_.contains(key)) continue;
    const cv::Size size = PhotographOf(key.first).LevelSize(key.second);
    auto room = MakeRoomFor(size, left);
    while (!room && staying > done + 1) {
      --staying;
      if (const auto last = where_.find(KeyOf(level_requests[staying])); last != where_.end()) {
        last->second.array->slots[last->second.layer].used = clock_ - 1;
        room = MakeRoomFor(size, 1);
      }
    }
    if (!room) break;
    Upload(*room, key, loader_->Wait(key));
    --left;
  }
  return done;
}

bool GlPhotographs::HasAll(std::span<const LevelRequest> level_requests) const {
  return std::ranges::all_of(level_requests, [&](const LevelRequest& level_request) {
    return where_.contains(KeyOf(WithinLimit(level_request)));
  });
}

bool GlPhotographs::HasRoomFor(std::span<const LevelRequest> level_requests) const {
  std::size_t bytes = 0;
  for (const LevelRequest& level_request : level_requests)
    bytes += LayerBytes(PhotographOf(level_request.view).LevelSize(level_request.level));
  return bytes <= limit_bytes_;
}

std::optional<GlPhotographs::Key> GlPhotographs::ClosestTo(const Key& key) const {
  std::optional<Key> closest;
  const auto distance = [&](int level) {
    constexpr int kFiner = 100;  // prefers every coarser level: a finer one flickers
    return level >= key.second ? level - key.second : kFiner + key.second - level;
  };
  for (auto at = where_.lower_bound({key.first, 0}); at != where_.end() && at->first.first == key.first; ++at)
    if (!closest || distance(at->first.second) < distance(closest->second)) closest = at->first;
  return closest;
}

// Returns the requests, coarser by the same number of levels until they fit at the same time.
std::vector<GlPhotographs::LevelRequest> GlPhotographs::CoarsenedToFit(
    std::span<const LevelRequest> requests) {
  std::vector<LevelRequest> level_requests;
  for (int coarser = 0;; ++coarser) {
    level_requests.clear();
    std::size_t bytes = 0;
    bool any_finer = false;
    for (const LevelRequest& level_request : requests) {
      const Photograph& photograph = PhotographOf(level_request.view);
      level_requests.push_back(
          {level_request.view, std::min(level_request.level + coarser, photograph.LevelCount() - 1)});
      bytes += LayerBytes(photograph.LevelSize(level_requests.back().level));
      any_finer = any_finer || level_requests.back().level + 1 < photograph.LevelCount();
    }
    if (coarser > 0 && !std::exchange(warned_too_large_, true))
      spdlog::warn(
          "the photographs of a picture do not fit into {} MB of graphics memory ({}): coarser levels are "
          "used",
          limit_bytes_ / 1000000, Parameter("gpu_memory"));
    if (bytes <= limit_bytes_ || !any_finer) return level_requests;
  }
}

// Takes the level from the loader, or else a coarser one. Returns whether the level itself is resident now.
bool GlPhotographs::TakeFromLoader(const LevelRequest& level_request, std::size_t& copied,
                                   std::size_t wanted) {
  for (const int level : {level_request.level, PreviewLevel(level_request)}) {
    if (level != level_request.level && serving_.contains(level_request.view)) return false;
    const Key key{level_request.view, level};
    const auto pixels = loader_->Take(key);
    if (!pixels) continue;
    auto room = MakeRoomFor(pixels->size(), wanted);
    if (Array* const other = LeastUsedArray(pixels->size()); !room && other) {
      // Another level of many views takes the room: they will be read at this size as well.
      Remove(*other);
      room = MakeRoomFor(pixels->size(), wanted);
    }
    if (!room) return false;
    copied += LayerBytes(pixels->size());
    Upload(*room, key, *pixels);
    return level == level_request.level;
  }
  return false;
}

bool GlPhotographs::Offer(std::span<const LevelRequest> requests) {
  ++clock_;
  serving_.clear();
  std::vector<LevelRequest> missing;
  missing_.clear();
  for (const LevelRequest& level_request : CoarsenedToFit(requests)) {
    if (unreadable_[At(level_request.view)]) continue;
    const auto serves = ClosestTo(KeyOf(level_request));
    if (serves) Use(*serves);
    if (!serves || serves->second != level_request.level) missing.push_back(level_request);
  }
  std::size_t copied = 0, left = missing.size();
  for (const LevelRequest& level_request : missing) {
    try {
      if (copied >= kOfferedBytes || !TakeFromLoader(level_request, copied, left))
        missing_.push_back(level_request);
    } catch (const Error& error) {
      spdlog::warn("{}", error.what());
      unreadable_[At(level_request.view)] = true;
    }
    --left;
  }
  return missing_.empty();
}

std::optional<GlPhotographs::Place> GlPhotographs::PlaceOf(int view) const {
  const auto serves = serving_.find(view);
  if (serves == serving_.end()) return std::nullopt;
  const Found& found = where_.at(serves->second);
  return Place{found.array->texture, static_cast<int>(found.layer)};
}

std::optional<int> GlPhotographs::LevelOf(int view) const {
  const auto serves = serving_.find(view);
  if (serves == serving_.end()) return std::nullopt;
  return serves->second.second;
}

void GlPhotographs::Release() {
  for (const auto& array : arrays_) glDeleteTextures(1, &array->texture);
  arrays_.clear();
  where_.clear();
  serving_.clear();
  loader_.reset();
  counts_.bytes = 0;
}

}  // namespace ulf::render

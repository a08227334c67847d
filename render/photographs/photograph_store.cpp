#include "render/photographs/photograph_store.h"

#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <list>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "core/base/at.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/mutex.h"
#include "core/geometry/digest.h"
#include "core/image/image.h"
#include "core/light_field/folder/opened_folder.h"
#include "core/light_field/folder/view_images.h"
#include "render/photographs/pyramid_file.h"

namespace ulf::render {
namespace {

// Pyramid files are written while the disk has more free space than this. Guessed.
constexpr std::uint64_t kLeastFreeBytes = std::uint64_t{1} << 30;

namespace fs = std::filesystem;

cv::Mat ResizedInLight(const cv::Mat& srgb8, const cv::Size& size) {
  if (size == srgb8.size()) return srgb8;
  cv::Mat smaller;
  cv::resize(LinearFloat({.pixels = srgb8, .transfer = Transfer::kSrgb}), smaller, size, 0, 0,
             cv::INTER_AREA);
  return Srgb8FromLinear(smaller);
}

std::uint64_t NotFinite(const cv::Mat& light) {
  std::uint64_t count = 0;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const cv::Vec3f& pixel = light.at<cv::Vec3f>(y, x);
      count += !(std::isfinite(pixel[0]) && std::isfinite(pixel[1]) && std::isfinite(pixel[2]));
    }
  return count;
}

// Returns a number for a file's size and time of change; 0 if there is no such file.
std::uint64_t FileStamp(const fs::path& path) {
  struct stat file {};
  if (stat(path.c_str(), &file) != 0) return 0;
  const std::int64_t stamp[] = {file.st_size, file.st_mtim.tv_sec, file.st_mtim.tv_nsec};
  return FastChecksumOf({reinterpret_cast<const char*>(stamp), sizeof stamp});
}

// Removes temporary files of killed programs.
void RemoveOldTemporaries(const fs::path& folder) {
  std::error_code refused;
  for (fs::directory_iterator entry(folder, refused), end; !refused && entry != end;
       entry.increment(refused)) {
    std::error_code gone;
    if (IsLeftTemporary(*entry)) fs::remove(entry->path(), gone);
  }
}

}  // namespace

struct PhotographStore::State {
  using Key = std::pair<std::size_t, int>;  // photograph, level
  struct Held {
    cv::Mat pixels;
    std::list<Key>::iterator use;
  };

  LightField light_field;
  PhotographStoreOptions options;
  std::string made_from;      // what pixels depend on apart from their view
  std::deque<Mutex> reading;  // by photograph: one thread reads it while others wait

  Mutex mutex;
  std::map<Key, Held> held ULF_GUARDED_BY(mutex);
  std::list<Key> by_use ULF_GUARDED_BY(mutex);  // most recently used first
  bool keeps_files ULF_GUARDED_BY(mutex) = false;
  std::map<std::size_t, PixelCounts> counted ULF_GUARDED_BY(mutex);  // by photograph that was read
  Counts counts ULF_GUARDED_BY(mutex);

  State(const LightField& the_light_field, const PhotographStoreOptions& the_options);
  ~State();
  cv::Mat Level(const Photograph& photograph, std::size_t index, int level);
  std::uint64_t ContentDigest(std::size_t index) const;
  bool MasksClipped(std::size_t index) const {
    return options.linear && index < options.masks_clipped.size() && options.masks_clipped[index];
  }

 private:
  const View& ViewAt(std::size_t index) const { return light_field.views[index]; }
  fs::path FileOf(std::size_t index) const;
  std::uint64_t FileKey(std::size_t index) const;
  cv::Mat FindHeld(const Key& key);
  void Hold(const Key& key, const cv::Mat& pixels);
  cv::Mat FromFile(const Photograph& photograph, std::size_t index, int level);
  ViewPyramid Decode(const Photograph& photograph, std::size_t index);
  void Keep(std::size_t index, const ViewPyramid& pyramid, std::uint64_t key);
  void KeepNoFiles(const std::string& why);
};

class PhotographStore::Stored : public Photograph {
 public:
  Stored(std::shared_ptr<State> state, std::size_t index, const cv::Size& size)
      : Photograph(size, state->options.linear), state_(std::move(state)), index_(index) {}
  cv::Mat Level(int level) const override { return state_->Level(*this, index_, level); }
  std::uint64_t ContentDigest() const override { return state_->ContentDigest(index_); }

 private:
  std::shared_ptr<State> state_;
  std::size_t index_;
};

PhotographStore::State::State(const LightField& the_light_field, const PhotographStoreOptions& the_options)
    : light_field(the_light_field), options(the_options), reading(the_light_field.views.size()) {
  light_field.points.clear();
  for (const auto& [camera, flat_field] : light_field.flat_fields)
    made_from += fmt::format("{}:{} ", camera, JsonText(FlatFieldToJson(flat_field)));
  for (const auto& [camera, profile] : light_field.color_profiles)
    made_from += fmt::format("{}:{} ", camera, JsonText(ColorProfileToJson(profile)));
  keeps_files =
      options.size_limit_px == 0 && !options.masks && fs::exists(light_field.root / "journal.jsonl");
  if (keeps_files) RemoveOldTemporaries(light_field.root / kPyramidFolder);
}

PhotographStore::State::~State() {
  std::uint64_t gap_px = 0;
  std::size_t with_gaps = 0;
  for (const auto& [index, of_photograph] : counted) {
    gap_px += of_photograph.gaps;
    with_gaps += of_photograph.gaps > 0;
  }
  if (gap_px > 0)
    spdlog::warn("{} of {} are infinite or not a number and get no weight", Counted(gap_px, "pixel"),
                 Counted(with_gaps, "photograph"));
}

fs::path PhotographStore::State::FileOf(std::size_t index) const {
  return light_field.root / kPyramidFolder /
         fmt::format("{:06}{}.pyramid", ViewAt(index).id, options.linear ? ".linear" : "");
}

std::uint64_t PhotographStore::State::FileKey(std::size_t index) const {
  const View& view = ViewAt(index);
  const fs::path& root = light_field.root;
  return FastChecksumOf(
      fmt::format("{} {} {} {:x} {:x} {:a}", view.camera, view.image_path, view.master_path,
                  FileStamp(root / view.image_path),
                  view.master_path.empty() ? 0 : FileStamp(root / view.master_path), view.black_level) +
      (view.mask_path.empty() ? ""
                              : fmt::format("{} {:x} ", view.mask_path, FileStamp(root / view.mask_path))) +
      (view.merged ? fmt::format("{} {:x} ", view.merged->path, FileStamp(root / view.merged->path)) : "") +
      (MasksClipped(index) ? "clipped " : "") + made_from);
}

std::uint64_t PhotographStore::State::ContentDigest(std::size_t index) const {
  const View& view = ViewAt(index);
  std::uint64_t digest = FastChecksumOf(fmt::format("{} {} {:a} {} {}", options.linear, options.masks,
                                                    view.black_level, MasksClipped(index), made_from));
  const auto add = [&](const std::string& name) {
    const fs::path path = light_field.root / name;
    const bool is_there = !name.empty() && fs::is_regular_file(path);
    digest = FastChecksumOf(is_there ? ReadWholeFile(path) : std::string(), digest + is_there);
    return is_there;
  };
  add(view.mask_path);
  // If a picture is damaged or missing, its source replaces it.
  const bool has_image = add(view.image_path);
  if (options.linear || !has_image) {
    add(view.master_path);
    add(view.merged ? view.merged->path : std::string());
  }
  return digest;
}

cv::Mat PhotographStore::State::FindHeld(const Key& key) {
  const MutexLock lock(mutex);
  const auto found = held.find(key);
  if (found == held.end()) return {};
  by_use.splice(by_use.begin(), by_use, found->second.use);
  return found->second.pixels;
}

void PhotographStore::State::Hold(const Key& key, const cv::Mat& pixels) {
  const auto bytes_of = [](const cv::Mat& mat) { return mat.total() * mat.elemSize(); };
  const auto limit = static_cast<std::size_t>(1e6 * options.memory_limit_mb);
  const MutexLock lock(mutex);
  if (held.contains(key) || bytes_of(pixels) > limit) return;
  while (counts.held_bytes + bytes_of(pixels) > limit) {
    const auto last = held.find(by_use.back());
    counts.held_bytes -= bytes_of(last->second.pixels);
    held.erase(last);
    by_use.pop_back();
  }
  by_use.push_front(key);
  held[key] = {pixels, by_use.begin()};
  counts.held_bytes += bytes_of(pixels);
  counts.most_held_bytes = std::max(counts.most_held_bytes, counts.held_bytes);
}

cv::Mat PhotographStore::State::Level(const Photograph& photograph, std::size_t index, int level) {
  const Key key{index, level};
  if (const cv::Mat pixels = FindHeld(key); !pixels.empty()) return pixels;
  const MutexLock lock(reading[index]);
  if (const cv::Mat pixels = FindHeld(key); !pixels.empty()) return pixels;
  if (const cv::Mat pixels = FromFile(photograph, index, level); !pixels.empty()) {
    Hold(key, pixels);
    return pixels;
  }
  const ViewPyramid pyramid = Decode(photograph, index);
  // The requested level is cached last, so that it is evicted last.
  for (int n = static_cast<int>(pyramid.size()) - 1; n >= 0; --n)
    if (n != level) Hold({index, n}, pyramid[static_cast<std::size_t>(n)]);
  Hold(key, pyramid[At(level)]);
  return pyramid[At(level)];
}

cv::Mat PhotographStore::State::FromFile(const Photograph& photograph, std::size_t index, int level) {
  if (options.size_limit_px > 0 || options.masks) return {};
  const fs::path file = FileOf(index);
  if (!fs::exists(file)) return {};
  const auto found = ReadPyramidFile(file, FileKey(index), photograph, level);
  const MutexLock lock(mutex);
  if (!found) {
    ++counts.files_refused;
    return {};
  }
  ++counts.levels_read;
  counted.emplace(index, found->counts);
  return found->pixels;
}

ViewPyramid PhotographStore::State::Decode(const Photograph& photograph, std::size_t index) {
  const View& view = ViewAt(index);
  // Computed before reading, so that a change during reading shows the next time.
  const std::uint64_t key = FileKey(index);
  ViewPyramid pyramid;
  PixelCounts found;
  cv::Mat clipped;
  if (options.masks) {
    cv::Mat mask = ReadViewMask(light_field, view), white;
    const CameraModel& camera = light_field.CameraOf(view);
    if (mask.empty()) mask = cv::Mat(camera.height, camera.width, CV_8UC1, cv::Scalar(255));
    cv::cvtColor(mask > 0, white, cv::COLOR_GRAY2BGR);
    pyramid = MakePyramid(ResizedInLight(white, photograph.size()));
  } else if (options.linear) {
    cv::Mat light = LinearFloat(ReadViewLight(light_field, view, &clipped));
    found.gaps = NotFinite(light);
    if (const cv::Mat mask = ReadViewMask(light_field, view); !mask.empty())
      light.setTo(cv::Scalar::all(std::numeric_limits<double>::quiet_NaN()), mask == 0);
    pyramid = MakeLinearPyramid(light, photograph.size(), MasksClipped(index) ? clipped : cv::Mat());
  } else {
    pyramid =
        MakePyramid(ResizedInLight(Srgb8(ReadViewImage(light_field, view, &clipped)), photograph.size()));
  }
  if (!clipped.empty()) found.clipped = static_cast<std::uint64_t>(cv::countNonZero(clipped));
  for (cv::Mat& level : pyramid)
    if (!level.isContinuous()) level = level.clone();
  {
    const MutexLock lock(mutex);
    ++counts.decoded;
    counted.emplace(index, found);
  }
  Keep(index, pyramid, key);
  return pyramid;
}

void PhotographStore::State::Keep(std::size_t index, const ViewPyramid& pyramid, std::uint64_t key) {
  PixelCounts found;
  {
    const MutexLock lock(mutex);
    if (!keeps_files) return;
    found = counted.at(index);
  }
  const fs::path folder = light_field.root / kPyramidFolder;
  try {
    MakeFolderIn(light_field.root, kPyramidFolder);
    if (FreeBytes(folder) < kLeastFreeBytes)
      return KeepNoFiles(
          fmt::format("{}: less than {} GB of disk space are free", folder.string(), kLeastFreeBytes >> 30));
    WritePyramidFile(FileOf(index), key, pyramid, found);
    const MutexLock lock(mutex);
    ++counts.files_written;
  } catch (const Error& error) {
    KeepNoFiles(error.what());
  }
}

void PhotographStore::State::KeepNoFiles(const std::string& why) {
  {
    const MutexLock lock(mutex);
    if (!std::exchange(keeps_files, false)) return;
  }
  spdlog::warn("{}; without {}/ this light field takes longer to open; nothing else changes", why,
               kPyramidFolder);
}

PhotographStore::PhotographStore(const LightField& light_field, const PhotographStoreOptions& options)
    : state_(std::make_shared<State>(light_field, options)) {}

PhotographStore::~PhotographStore() = default;

std::shared_ptr<const Photograph> PhotographStore::PhotographOf(std::size_t index) const {
  const CameraModel& camera = state_->light_field.CameraOf(state_->light_field.views[index]);
  const int limit_px = state_->options.size_limit_px;
  const CameraModel loaded = limit_px > 0 ? Within(camera, limit_px) : camera;
  return std::make_shared<Stored>(state_, index, cv::Size(loaded.width, loaded.height));
}

PhotographStore::Counts PhotographStore::counts() const {
  const MutexLock lock(state_->mutex);
  Counts counts = state_->counts;
  for (const auto& [index, found] : state_->counted) {
    const CameraModel& camera = state_->light_field.CameraOf(state_->light_field.views[index]);
    counts.pixels += static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
    counts.clipped_px += found.clipped;
    if (state_->MasksClipped(index)) counts.masked_px += found.clipped;
    ++counts.photographs;
  }
  return counts;
}

}  // namespace ulf::render

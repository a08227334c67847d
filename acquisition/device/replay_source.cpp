#include "acquisition/device/replay_source.h"

#include <fnmatch.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/name_order.h"
#include "core/base/shell_word.h"
#include "core/image/files/exif.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_end.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_folder.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/raw_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "core/video/video_reader.h"

namespace ulf::acquisition {
namespace {

namespace fs = std::filesystem;

constexpr double kDefaultFps = 30;

bool IsJpegName(const fs::path& path) {
  const auto header = ReadImageHeader(path.string());
  return header && header->kind == "JPEG";
}

EncodedImage JpegFile(const fs::path& path) {
  return {".jpg", std::make_shared<const std::string>(ReadWholeFile(path))};
}

// Returns a photograph's time as text that sorts by time; empty if the file does not say.
std::string TimeTaken(const fs::path& file) {
  return IsRawFile(file) ? ReadRawFacts(file.string()).exif.taken : ReadExifOfFile(file).taken;
}

// A camera that counts to 9999 and goes on with 1 puts its last photographs first: where the order of the
// names differs from that of the times by such a step alone, the photographs are put into the order of their
// times.
void PutInOrderOfTimes(const std::string& uri, std::vector<fs::path>& files) {
  std::vector<std::string> times;
  for (const fs::path& file : files) {
    times.push_back(TimeTaken(file));
    if (times.back().empty()) return;
  }
  std::vector<std::size_t> steps_back;
  for (std::size_t i = 1; i < times.size(); ++i)
    if (times[i] < times[i - 1]) steps_back.push_back(i);
  if (steps_back.empty()) return;
  if (steps_back.size() > 1 || times.back() > times.front()) {
    spdlog::info(
        "{}: the photographs' names and their times are in different orders; they are played by name", uri);
    return;
  }
  const auto first = files.begin() + static_cast<std::ptrdiff_t>(steps_back.front());
  spdlog::info(
      "{}: the photographs' numbers begin again at {}; they are played in the order of their times, from {} "
      "to {}",
      uri, files.front().filename().string(), first->filename().string(),
      std::prev(first)->filename().string());
  std::rotate(files.begin(), first, files.end());
}

std::vector<fs::path> ImagesOfGlob(const ReplayOptions& options) {
  std::vector<fs::path> files;
  std::size_t others = 0;
  for (const auto& entry : fs::directory_iterator(options.path)) {
    if (!entry.is_regular_file()) continue;
    if (fnmatch(options.glob->c_str(), entry.path().filename().c_str(), 0) == 0)
      files.push_back(entry.path());
    else
      ++others;
  }
  if (files.empty())
    throw Error("{}: none of the {} files in the folder matches '{}'; correct ?glob= or leave it out",
                options.uri, others, *options.glob);
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return NameOrder(a.filename().string(), b.filename().string());
  });
  return files;
}

std::vector<fs::path> ImagesOf(const ReplayOptions& options) {
  std::vector<fs::path> files;
  if (options.glob) {
    files = ImagesOfGlob(options);
  } else {
    PictureFolder folder = PicturesIn(options.path);
    if (folder.pictures.empty()) RefuseWithoutPictures(options.uri, folder);
    for (const std::string& line : folder.left_out) spdlog::warn("{}: left out: {}", options.uri, line);
    files = std::move(folder.pictures);
  }
  PutInOrderOfTimes(options.uri, files);
  return files;
}

// With the file itself, which becomes the view's master.
void Develop(const fs::path& file, Frame& frame) {
  auto bytes = std::make_shared<const std::string>(ReadWholeFile(file));
  const RawPhotograph photograph = DecodeRaw(*bytes, file.string(), RawQuality::kQuick);
  frame.image = {photograph.light, Transfer::kLinear};
  frame.raw = EncodedImage{Lowercase(file.extension().string()), std::move(bytes)};
  const ExifFacts& exif = photograph.facts.exif;
  frame.exposure_s = exif.exposure_s.value_or(0);
  frame.gain = exif.iso.value_or(100) / 100;
  frame.f_number = exif.f_number;
  frame.focal_mm = exif.focal_mm;
  frame.lens = exif.lens;
}

class FolderSource : public ReplaySource {
 public:
  explicit FolderSource(const ReplayOptions& options) : options_(options), files_(ImagesOf(options)) {
    std::vector<std::string> kinds;
    for (const fs::path& file : files_) {
      if (!ImageFileIsWhole(file.string()))
        throw Error("{}: the image is truncated; copy it again from its source, or remove it", file.string());
      const auto header = ReadImageHeader(file.string());
      kinds.push_back(header ? header->Text() : "another kind of file");
    }
    if (const auto odd = FirstMismatch(kinds)) ThrowMixed(*odd, kinds);
    header_ = ReadImageHeader(files_.front().string());
    first_ = Read(files_.front());
    for (const auto& [kind, line] : said_)
      remark_ +=
          fmt::format("{}{}: {}", remark_.empty() ? "" : "; ", files_.front().filename().string(), line);
    if (!options.fps && files_.size() > 1)
      spdlog::info(
          "{}: images of a folder have no times; they are taken for {:g} a second, ?fps= says otherwise",
          options_.uri, kDefaultFps);
  }

  FrameSource Source() const override { return FrameSource::kPhotographs; }
  std::string Describe() const override {
    return fmt::format("{}{}, {}x{}", Counted(files_.size(), "image"),
                       header_ ? " (" + header_->kind + ")" : "", first_.cols, first_.rows);
  }
  RecordingHeader Header() const override {
    RecordingHeader header = ReplaySource::Header();
    header.device.remark = remark_;
    return header;
  }
  void Rewind() override { next_ = 0; }
  double Length() const override { return static_cast<double>(files_.size()); }

  std::optional<Frame> Next() override {
    if (next_ >= files_.size()) return std::nullopt;
    const fs::path& file = files_[next_];
    Frame frame;
    if (IsRawFile(file))
      Develop(file, frame);
    else
      frame.image.pixels = next_ == 0 ? first_.clone() : Read(file);
    const cv::Mat& pixels = frame.image.pixels;
    if (pixels.size() != first_.size() || pixels.type() != first_.type()) ThrowMixedPixels(pixels);
    if (!frame.raw) frame.image.transfer = options_.TransferOf(pixels);
    frame.id = next_;
    frame.device_time_s = options_.TimeOf(next_);
    if (header_ && header_->kind == "JPEG") frame.encoded = JpegFile(file);
    ++next_;
    return frame;
  }

 private:
  // What was converted, and what was not understood, is said once for the folder.
  cv::Mat Read(const fs::path& file) {
    if (IsRawFile(file)) return ReadImageFile(file.string());
    StoredPicture picture = ReadPicture(file.string());
    const auto say = [&](const std::string& line, spdlog::level::level_enum level) {
      if (said_.emplace(WithoutNumbers(line), line).second) spdlog::log(level, "{}: {}", file.string(), line);
    };
    for (const PictureNote& note : picture.notes) say(note.Words(), spdlog::level::info);
    for (const std::string& remark : picture.remarks) say(remark, spdlog::level::info);
    for (const std::string& warning : picture.warnings) say(warning, spdlog::level::warn);
    return picture.pixels;
  }
  static std::string KindOf(const cv::Mat& pixels) {
    return fmt::format("{}x{}, {} of {} bits", pixels.cols, pixels.rows,
                       Counted(static_cast<std::size_t>(pixels.channels()), "channel"),
                       8 * pixels.elemSize1());
  }
  // All pictures before this one are like the first.
  [[noreturn]] void ThrowMixedPixels(const cv::Mat& pixels) {
    constexpr std::size_t kLookedAt = 30;  // which kind is the usual one needs no more of them
    std::vector<std::string> kinds(next_, KindOf(first_));
    kinds.push_back(KindOf(pixels));
    for (std::size_t i = next_ + 1; i < std::min(files_.size(), kLookedAt); ++i) try {
        kinds.push_back(KindOf(Read(files_[i])));
      } catch (const Error&) {
        break;  // its own damage is said once the sizes agree
      }
    if (const auto odd = FirstMismatch(kinds)) ThrowMixed(*odd, kinds);
    throw Error("{}: mixed images", options_.uri);
  }
  [[noreturn]] void ThrowMixed(const Mismatch& odd, const std::vector<std::string>& kinds) const {
    throw Error(
        "{}: mixed images: {} is {}, but {}{} {}; choose one kind with ?glob=, or have single photographs "
        "posed (ulf import {} {} -o DIR)",
        options_.uri, files_[odd.odd].string(), kinds[odd.odd], files_[odd.usual].string(),
        odd.usual_count == 1 ? " is" : fmt::format(" and {} more are", odd.usual_count - 1), kinds[odd.usual],
        ShellWord(options_.path.string()), Parameter("pose"));
  }

  ReplayOptions options_;
  std::vector<fs::path> files_;
  std::optional<ImageHeader> header_;
  cv::Mat first_;
  std::map<std::string, std::string> said_;  // by their kind
  std::string remark_;                       // what was said of the first picture
  std::size_t next_ = 0;
};

class VideoSource : public ReplaySource {
 public:
  explicit VideoSource(const ReplayOptions& options) : options_(options) {
    Rewind();
    const VideoFacts& facts = reader_->Facts();
    for (const std::string& note : facts.notes) spdlog::info("{}: {}", options_.uri, note);
    for (const std::string& warning : facts.warnings) spdlog::warn("{}: {}", options_.uri, warning);
  }

  FrameSource Source() const override { return FrameSource::kRecording; }
  std::string Describe() const override {
    const VideoFacts& facts = reader_->Facts();
    return fmt::format("video, {}x{} at {:.4g} fps", facts.width, facts.height,
                       options_.fps.value_or(facts.frame_rate));
  }
  RecordingHeader Header() const override {
    RecordingHeader header = ReplaySource::Header();
    header.device.pixel_aspect = reader_->Facts().pixel_aspect;
    for (const auto* lines : {&reader_->Facts().notes, &reader_->Facts().warnings})
      for (const std::string& line : *lines)
        header.device.remark += (header.device.remark.empty() ? "" : "; ") + line;
    return header;
  }
  double Length() const override { return reader_->Facts().frames; }
  void Rewind() override {
    reader_ = std::make_unique<VideoReader>(options_.path);
    next_ = 0;
  }

  std::optional<Frame> Next() override {
    std::optional<VideoPicture> picture = reader_->Next();
    if (!picture) {
      if (const std::string problem = reader_->Problem(); !problem.empty())
        spdlog::warn("{}: {}", options_.uri, problem);
      return std::nullopt;
    }
    Frame frame;
    frame.image = std::move(picture->image);
    if (options_.transfer) frame.image.transfer = *options_.transfer;
    frame.id = next_;
    frame.device_time_s = options_.fps ? options_.TimeOf(next_) : picture->time_s;
    ++next_;
    return frame;
  }

 private:
  ReplayOptions options_;
  std::unique_ptr<VideoReader> reader_;
  std::size_t next_ = 0;
};

class LightFieldSource : public ReplaySource {
 public:
  explicit LightFieldSource(const ReplayOptions& options)
      : options_(options), light_field_(ReadLightField(options.path)) {
    const auto& views = light_field_.views;
    if (views.empty()) throw Error("{}: the light field has no views to replay", options_.uri);
    for (const View& view : views)
      if (!(light_field_.CameraOf(view) == light_field_.CameraOf(views.front())))
        throw Error(
            "{}: views {} and {} have different cameras, but a device has one; replay its images folder with "
            "{} instead",
            options_.uri, views.front().id, view.id, Parameter("calibration"));
    const auto not_later = [](const View& a, const View& b) { return !(b.device_time_s > a.device_time_s); };
    has_own_times_ =
        !options_.fps && std::adjacent_find(views.begin(), views.end(), not_later) == views.end();
  }

  FrameSource Source() const override { return FrameSource::kPhotographs; }
  std::string Describe() const override {
    const CameraModel& camera = light_field_.CameraOf(light_field_.views.front());
    return fmt::format("light field of {}, {}x{}", Counted(light_field_.views.size(), "view"), camera.width,
                       camera.height);
  }
  RecordingHeader Header() const override {
    RecordingHeader header = ReplaySource::Header();
    header.device.serial = light_field_.device_serial;
    header.device.maker = light_field_.device_maker;
    header.device.model = light_field_.device_model;
    header.window = light_field_.window;
    header.camera = light_field_.CameraOf(light_field_.views.front());
    const auto flat_field = light_field_.flat_fields.find(light_field_.views.front().camera);
    if (flat_field != light_field_.flat_fields.end()) header.flat_field = flat_field->second;
    const auto profile = light_field_.color_profiles.find(light_field_.views.front().camera);
    if (profile != light_field_.color_profiles.end()) header.color_profile = profile->second;
    return header;
  }
  void Rewind() override { next_ = 0; }
  double Length() const override { return static_cast<double>(light_field_.views.size()); }

  std::optional<Frame> Next() override {
    if (next_ >= light_field_.views.size()) return std::nullopt;
    const View& view = light_field_.views[next_];
    Frame frame;
    frame.image = ReadRecordedImage(light_field_, view);
    if (options_.transfer) frame.image.transfer = *options_.transfer;
    frame.id = static_cast<std::uint64_t>(view.id);
    frame.device_time_s = has_own_times_ ? view.device_time_s : options_.TimeOf(next_);
    frame.host_time_s = view.host_time_s;
    frame.exposure_s = view.exposure_s;
    frame.gain = view.gain;
    frame.black_level = view.black_level;
    frame.told_id = view.frame_id;
    frame.line_status = view.line_status;
    frame.on_shared_clock = view.on_shared_clock;
    const fs::path file = light_field_.root / view.image_path;
    if (IsJpegName(file)) frame.encoded = JpegFile(file);
    frame.known_cam_from_world = view.cam_from_world;
    ++next_;
    return frame;
  }

 private:
  ReplayOptions options_;
  LightField light_field_;
  bool has_own_times_ = true;
  std::size_t next_ = 0;
};

// All frames as they were recorded. `fps` replaces their times: a photograph gets the time of the last live
// frame before it.
class RecordedSource : public ReplaySource {
 public:
  explicit RecordedSource(const ReplayOptions& options)
      : options_(options), recording_(ReadFrameRecording(options.path)) {
    if (options_.fps) SpaceEvenly();
    for (const auto& entry : recording_.entries) requested_ += entry.frame.requested_s.has_value();
  }

  FrameSource Source() const override { return FrameSource::kRecording; }
  std::string Describe() const override {
    return fmt::format("recording of {} from {}", Counted(recording_.entries.size(), "frame"),
                       recording_.header.device.uri);
  }
  bool HasLiveFrames() const override {
    return std::ranges::any_of(recording_.entries,
                               [](const auto& entry) { return entry.frame.kind == FrameKind::kLive; });
  }
  RecordingHeader Header() const override { return recording_.header; }
  bool HasRequestedPhotographs() const override { return delivered_ < requested_; }
  void Rewind() override { next_ = delivered_ = 0; }
  double Length() const override { return static_cast<double>(recording_.entries.size()); }

  std::optional<Frame> Next() override {
    if (next_ >= recording_.entries.size()) return std::nullopt;
    Frame frame = ReadRecordedFrame(recording_.entries[next_]);
    if (options_.transfer) frame.image.transfer = *options_.transfer;
    delivered_ += frame.requested_s.has_value();
    ++next_;
    return frame;
  }

 private:
  void SpaceEvenly() {
    std::vector<std::pair<double, double>> live;  // recorded time, new time
    for (const auto& entry : recording_.entries)
      if (entry.frame.kind == FrameKind::kLive)
        live.emplace_back(entry.frame.device_time_s, options_.TimeOf(live.size()));
    const auto new_time = [&](double time_s) {
      const auto after = std::upper_bound(live.begin(), live.end(), std::pair(time_s, HUGE_VAL));
      return after == live.begin() ? 0.0 : std::prev(after)->second;
    };
    std::size_t index = 0;
    for (auto& [frame, file, raw_file] : recording_.entries) {
      frame.device_time_s =
          frame.kind == FrameKind::kLive ? live[index++].second : new_time(frame.device_time_s);
      if (frame.requested_s) frame.requested_s = new_time(*frame.requested_s);
    }
  }

  ReplayOptions options_;
  FrameRecording recording_;
  std::size_t next_ = 0;
  std::size_t requested_ = 0, delivered_ = 0;  // photographs that the session requested
};

bool IsLightField(const fs::path& folder) {
  return fs::exists(folder / "journal.jsonl") || fs::exists(folder / "transforms.json");
}

}  // namespace

double ReplayOptions::TimeOf(std::size_t index) const {
  return static_cast<double>(index) / fps.value_or(kDefaultFps);
}

std::unique_ptr<ReplaySource> OpenReplaySource(const ReplayOptions& options) {
  if (!fs::exists(options.path))
    throw Error("{}: there is no file or folder '{}'; check the path", options.uri, options.path.string());
  if (!fs::is_directory(options.path)) {
    if (options.glob)
      throw Refused(options.uri, "glob chooses files of a folder, but this is a file", "leave it out");
    return std::make_unique<VideoSource>(options);
  }
  if (!options.glob && IsFrameRecording(options.path)) return std::make_unique<RecordedSource>(options);
  if (!options.glob && IsLightField(options.path)) return std::make_unique<LightFieldSource>(options);
  return std::make_unique<FolderSource>(options);
}

}  // namespace ulf::acquisition

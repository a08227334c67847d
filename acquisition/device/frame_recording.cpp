#include "acquisition/device/frame_recording.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <deque>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/file_descriptor.h"
#include "core/base/host_time.h"
#include "core/base/json_fields.h"
#include "core/base/json_text.h"
#include "core/base/mutex.h"
#include "core/base/output_path.h"
#include "core/geometry/camera_json.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/raw_file.h"
#include "core/image/files/tiff_file.h"

namespace ulf::acquisition {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr const char* kIndex = "frames.jsonl";
constexpr const char* kFolder = "frames";
// A batch ends after so many bytes or seconds: a kill loses at most this, each batch costs one wait for the
// disk. Guessed.
constexpr std::size_t kBatchBytes = 64 << 20;
constexpr double kBatchS = 0.5;
constexpr std::uint64_t kIndexReserveBytes =
    1 << 20;  // left free on the disk, so that written frames can be named
constexpr std::chrono::milliseconds kBatchCheck(100);  // the writer checks so often whether a batch is due

class OpenFile {
 public:
  OpenFile(const fs::path& path, int flags)
      : path_(path), file_(open(path.c_str(), flags | O_CLOEXEC, 0644)) {
    if (!file_.IsOpen()) ThrowDiskError(errno, path.string() + ": cannot be written");
  }
  void Write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t written = write(file_.Number(), bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) ThrowDiskError(errno, path_.string() + ": writing failed");
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  void Sync() {
    if (fsync(file_.Number()) != 0) ThrowDiskError(errno, path_.string() + ": syncing to disk failed");
  }
  off_t Size() { return lseek(file_.Number(), 0, SEEK_END); }
  void CutAt(off_t size) {
    if (ftruncate(file_.Number(), size) == 0) fsync(file_.Number());
  }

 private:
  fs::path path_;
  FileDescriptor file_;
};

bool IsJpeg(const std::string& extension) { return extension == ".jpg" || extension == ".jpeg"; }

struct FrameFile {
  std::string extension;
  FileContent content;
};

// Returns none for a photograph that has only a raw file: it is developed again.
std::optional<FrameFile> ImageFile(const Frame& frame) {
  if (frame.encoded && IsJpeg(frame.encoded->extension))
    return FrameFile{frame.encoded->extension, ContentOf(*frame.encoded->bytes)};
  if (frame.image.empty() || frame.raw) return std::nullopt;
  return FrameFile{".tif", TiffContent(frame.image.pixels)};
}

std::size_t BytesOf(const Frame& frame) {
  return frame.image.pixels.total() * frame.image.pixels.elemSize() +
         (frame.encoded ? frame.encoded->bytes->size() : 0) + (frame.raw ? frame.raw->bytes->size() : 0);
}

constexpr int kRecordingVersion = 2;  // version 1 has no photographs' files, sensor and flat field

void AddCalibration(json& header, const std::string& prefix, const std::optional<CameraModel>& camera,
                    const std::optional<FlatField>& flat_field, const std::optional<ColorProfile>& profile) {
  if (camera) header[prefix + "camera"] = CameraToJson(*camera);
  if (flat_field) header[prefix + "flat_field"] = FlatFieldToJson(*flat_field);
  if (profile) header[prefix + "color_profile"] = ColorProfileToJson(*profile);
}

void ReadCalibration(const JsonPlace& line, const std::string& prefix, std::optional<CameraModel>& camera,
                     std::optional<FlatField>& flat_field, std::optional<ColorProfile>& profile) {
  const std::string camera_key = prefix + "camera", flat_field_key = prefix + "flat_field",
                    profile_key = prefix + "color_profile";
  if (line.Has(camera_key.c_str()))
    camera = CameraFromJson({line.Raw(camera_key.c_str()), line.where + ", " + camera_key});
  if (line.Has(flat_field_key.c_str()))
    flat_field = FlatFieldFromJson(line.Raw(flat_field_key.c_str()), line.where + ", " + flat_field_key);
  if (line.Has(profile_key.c_str()))
    profile = ColorProfileFromJson(line.Raw(profile_key.c_str()), line.where);
}

json RecordingHeaderToJson(const RecordingHeader& header) {
  const DeviceInfo& device = header.device;
  json line = {{"event", "header"},
               {"version", kRecordingVersion},
               {"device",
                {{"uri", device.uri},
                 {"maker", device.maker},
                 {"model", device.model},
                 {"serial", device.serial},
                 {"bus", device.bus},
                 {"pixel_aspect", device.pixel_aspect}}},
               {"takes_stills", header.takes_stills}};
  if (!device.remark.empty()) line["device"]["remark"] = device.remark;
  if (header.window) line["sensor"] = WindowToJson(*header.window);
  AddCalibration(line, "", header.camera, header.flat_field, header.color_profile);
  AddCalibration(line, "still_", header.still_camera, header.still_flat_field, header.still_color_profile);
  return line;
}

// Throws Error for a recording of a newer version.
RecordingHeader RecordingHeaderFromJson(const JsonPlace& line) {
  if (line.Integer("version") > kRecordingVersion)
    throw Error("{}: a recording of a newer version; use a newer ulf", line.where);
  const JsonPlace device{line.Raw("device"), line.where + ", device"};
  RecordingHeader header;
  header.device = {.uri = device.Text("uri", ""),
                   .maker = device.Text("maker", ""),
                   .model = device.Text("model", ""),
                   .serial = device.Text("serial", ""),
                   .bus = device.Text("bus", "files"),
                   .problem = "",
                   .remark = device.Text("remark", "")};
  if (device.Has("pixel_aspect")) header.device.pixel_aspect = device.Positive("pixel_aspect");
  if (line.Has("sensor")) header.window = WindowFromJson({line.Raw("sensor"), line.where + ", sensor"});
  header.takes_stills = line.Has("takes_stills") && line.Raw("takes_stills") == true;
  ReadCalibration(line, "", header.camera, header.flat_field, header.color_profile);
  ReadCalibration(line, "still_", header.still_camera, header.still_flat_field, header.still_color_profile);
  return header;
}

// `file` and `raw_file` are relative to the recording; empty: there is none.
json FrameToJson(const Frame& frame, const std::string& file, const std::string& raw_file) {
  json line = {{"event", "frame"},
               {"id", frame.id},
               {"device_time_s", frame.device_time_s},
               {"host_time_s", frame.host_time_s},
               {"exposure_s", frame.exposure_s},
               {"gain", frame.gain},
               {"black_level", frame.black_level},
               {"transfer", frame.image.transfer == Transfer::kLinear ? "linear" : "srgb"}};
  if (frame.told_id) line["told_id"] = *frame.told_id;
  if (frame.line_status) line["line_status"] = *frame.line_status;
  if (frame.on_shared_clock) line["on_shared_clock"] = true;
  if (!file.empty()) line["file"] = file;
  if (!raw_file.empty()) line["raw"] = raw_file;
  if (frame.f_number) line["f_number"] = *frame.f_number;
  if (frame.focal_mm) line["focal_mm"] = *frame.focal_mm;
  if (!frame.lens.empty()) line["lens"] = frame.lens;
  if (frame.kind == FrameKind::kStill) line["still"] = true;
  if (frame.requested_s) line["requested_s"] = *frame.requested_s;
  if (frame.status == FrameStatus::kIncomplete) line["incomplete"] = true;
  if (frame.image.mosaic != Mosaic::kNone) line["mosaic"] = Name(frame.image.mosaic);
  if (frame.known_cam_from_world) {
    const Eigen::Quaterniond& q = frame.known_cam_from_world->rotation;
    const Eigen::Vector3d& t = frame.known_cam_from_world->translation;
    line["known_cam_from_world"] = {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
  }
  return line;
}

// Reads a frame without its pixels.
Frame FrameFromJson(const JsonPlace& line) {
  Frame frame;
  frame.id = static_cast<std::uint64_t>(line.Number("id"));
  frame.device_time_s = line.Number("device_time_s");
  frame.host_time_s = line.Number("host_time_s", 0);
  frame.exposure_s = line.Number("exposure_s", 0);
  frame.gain = line.Number("gain", 1);
  frame.black_level = line.Number("black_level", 0);
  if (line.Has("told_id")) frame.told_id = static_cast<std::uint64_t>(line.Number("told_id"));
  if (line.Has("line_status")) frame.line_status = static_cast<std::uint64_t>(line.Number("line_status"));
  frame.on_shared_clock = line.Has("on_shared_clock");
  if (line.Has("f_number")) frame.f_number = line.Number("f_number");
  if (line.Has("focal_mm")) frame.focal_mm = line.Number("focal_mm");
  frame.lens = line.Text("lens", "");
  if (line.Has("still")) frame.kind = FrameKind::kStill;
  if (line.Has("requested_s")) frame.requested_s = line.Number("requested_s");
  if (line.Has("incomplete")) frame.status = FrameStatus::kIncomplete;
  frame.image.transfer = line.Text("transfer", "srgb") == "linear" ? Transfer::kLinear : Transfer::kSrgb;
  if (line.Has("mosaic")) {
    const auto mosaic = MosaicByName(line.Text("mosaic"));
    if (!mosaic) throw Error("{}: there is no mosaic '{}'", line.where, line.Text("mosaic"));
    frame.image.mosaic = *mosaic;
  }
  if (line.Has("known_cam_from_world")) {
    const std::vector<double> n = line.Numbers("known_cam_from_world", 7);
    frame.known_cam_from_world =
        Rigid3{Eigen::Quaterniond(n[0], n[1], n[2], n[3]), Eigen::Vector3d(n[4], n[5], n[6])};
  }
  return frame;
}

}  // namespace

struct FrameRecorder::State {
  State(const fs::path& folder, const FrameRecorderOptions& o) : dir(folder), options(o) {}

  const fs::path dir;
  const FrameRecorderOptions options;
  std::optional<OpenFile> index;

  mutable Mutex mutex;
  ConditionVariable changed;
  struct Item {
    std::optional<Frame> frame;
    std::string note;
  };
  std::deque<Item> waiting ULF_GUARDED_BY(mutex);
  std::size_t bytes ULF_GUARDED_BY(mutex) = 0;
  bool finishing ULF_GUARDED_BY(mutex) = false;
  std::string pause ULF_GUARDED_BY(mutex);
  FrameRecorderSummary summary ULF_GUARDED_BY(mutex);

  // Used by the writing thread alone.
  FileBatch files;
  std::string lines;
  std::uint64_t frames_in_batch = 0, bytes_in_batch = 0, next_name = 1;
  Clock::time_point batch_began;
  std::thread thread;

  void Loop();
  void Write(Item item);
  void EndBatch();
  void LeaveOut(std::uint64_t frames, const Error& error);
};

void FrameRecorder::State::Loop() {
  MutexLock lock(mutex);
  for (;;) {
    changed.wait_for(lock, kBatchCheck,
                     [this]() ULF_REQUIRES(mutex) { return finishing || !waiting.empty(); });
    if (!waiting.empty()) {
      Item item = std::move(waiting.front());
      waiting.pop_front();
      lock.unlock();
      const std::size_t item_bytes = item.frame ? BytesOf(*item.frame) : 0;
      Write(std::move(item));
      lock.lock();
      bytes -= item_bytes;
    }
    const bool due = !lines.empty() &&
                     (bytes_in_batch >= kBatchBytes || SecondsSince(batch_began) >= kBatchS || finishing);
    if (due && (!finishing || waiting.empty() || bytes_in_batch >= kBatchBytes)) {
      lock.unlock();
      EndBatch();
      lock.lock();
    }
    if (finishing && waiting.empty() && lines.empty()) return;
  }
}

void FrameRecorder::State::Write(Item item) {
  if (lines.empty()) batch_began = Clock::now();
  if (!item.frame) {
    lines += JsonText(json{{"event", "note"}, {"text", item.note}}) + "\n";
    return;
  }
  const auto start = Clock::now();
  const Frame& frame = *item.frame;
  std::string image_name, raw_name;
  std::uint64_t needed = 0;
  try {
    std::vector<std::pair<fs::path, FileContent>> wanted;
    const auto want = [&](const std::string& extension, FileContent content) {
      std::string name = fmt::format("{}/{:08}{}", kFolder, next_name, extension);
      needed += content.size;
      wanted.emplace_back(dir / name, std::move(content));
      return name;
    };
    if (auto image = ImageFile(frame)) image_name = want(image->extension, std::move(image->content));
    if (frame.raw) raw_name = want(frame.raw->extension, ContentOf(*frame.raw->bytes));
    if (FreeBytes(dir) < needed + kIndexReserveBytes)
      ThrowDiskError(ENOSPC, fmt::format("{}: frame {} is not written", dir.string(), frame.id));
    files.Write(wanted);
    const MutexLock lock(mutex);
    summary.disk_s += SecondsSince(start);
  } catch (const Error& error) {
    LeaveOut(1, error);
    return;
  } catch (const std::exception& error) {  // no memory left
    LeaveOut(1, Error("frame {}: cannot be recorded: {}", frame.id, error.what()));
    return;
  }
  ++next_name;
  ++frames_in_batch;
  bytes_in_batch += needed;
  lines += JsonText(FrameToJson(frame, image_name, raw_name)) + "\n";
}

void FrameRecorder::State::EndBatch() {
  const auto start = Clock::now();
  const off_t before = index->Size();
  try {
    files.Commit();
    index->Write(lines);
    index->Sync();
    const MutexLock lock(mutex);
    summary.written += frames_in_batch;
    summary.bytes += bytes_in_batch;
    summary.disk_s += SecondsSince(start);
    pause.clear();
  } catch (const Error& error) {
    index->CutAt(before);
    files.TakeBack();  // no file may remain that the index does not name
    LeaveOut(frames_in_batch, error);
  }
  lines.clear();
  frames_in_batch = bytes_in_batch = 0;
}

void FrameRecorder::State::LeaveOut(std::uint64_t frames, const Error& error) {
  const MutexLock lock(mutex);
  summary.left_out += frames;
  summary.problem = pause = error.what();
}

void RequireNewRecording(const fs::path& dir) {
  std::error_code unknown;
  if (fs::exists(dir, unknown) && !(fs::is_directory(dir, unknown) && fs::is_empty(dir, unknown)))
    throw Error("{}: exists already; name a new folder for the recording", dir.string());
  RequireWritableFolder(dir.string());
}

RecordingHeader RecordingHeader::Of(const Device& device) {
  const auto copy_of = [](const auto& known) { return known ? std::optional(*known) : std::nullopt; };
  return {.device = device.Info(),
          .window = device.Window(),
          .takes_stills = device.TakesStills(),
          .camera = device.Camera(),
          .still_camera = device.StillCamera(),
          .flat_field = copy_of(device.KnownFlatField(FrameKind::kLive)),
          .still_flat_field = copy_of(device.KnownFlatField(FrameKind::kStill)),
          .color_profile = copy_of(device.KnownColorProfile(FrameKind::kLive)),
          .still_color_profile = copy_of(device.KnownColorProfile(FrameKind::kStill))};
}

FrameRecorder::FrameRecorder(const fs::path& dir, const RecordingHeader& header,
                             const FrameRecorderOptions& options)
    : state_(std::make_unique<State>(dir, options)) {
  RequireNewRecording(dir);
  MakeFolder(dir / kFolder);
  state_->index.emplace(dir / kIndex, O_WRONLY | O_CREAT | O_APPEND);
  state_->index->Write(JsonText(RecordingHeaderToJson(header)) + "\n");
  state_->index->Sync();
  SyncFolder(dir);
  state_->thread = std::thread([state = state_.get()] { state->Loop(); });
}

FrameRecorder::~FrameRecorder() {
  if (state_->thread.joinable()) Finish();
}

bool FrameRecorder::TryAdd(const Frame& frame) {
  Frame kept = frame;
  if (frame.kind == FrameKind::kStill && frame.encoded)
    kept.image.pixels.release();  // only its file is written
  else if (!kept.image.pixels.u)
    kept.image.pixels = frame.image.pixels.clone();  // the pixels are not the frame's own
  const std::size_t bytes = BytesOf(kept);
  {
    const MutexLock lock(state_->mutex);
    // An empty queue takes a frame of any size, and every queue takes photographs.
    if (frame.kind == FrameKind::kLive && !state_->waiting.empty() &&
        state_->bytes + bytes > state_->options.waiting_bytes) {
      ++state_->summary.left_out;
      if (state_->pause.empty()) {
        state_->pause = fmt::format("{}: disk slow ({} to be written)", state_->dir.string(),
                                    Counted(state_->waiting.size(), "frame"));
        state_->summary.problem = state_->pause;
      }
      return false;
    }
    state_->waiting.push_back({std::move(kept), ""});
    state_->bytes += bytes;
  }
  state_->changed.notify_one();
  return true;
}

void FrameRecorder::Note(const std::string& text) {
  {
    const MutexLock lock(state_->mutex);
    state_->waiting.push_back({std::nullopt, text});
  }
  state_->changed.notify_one();
}

std::optional<std::string> FrameRecorder::Pause() const {
  const MutexLock lock(state_->mutex);
  if (state_->pause.empty()) return std::nullopt;
  return state_->pause;
}

FrameRecorderSummary FrameRecorder::Finish() {
  {
    const MutexLock lock(state_->mutex);
    state_->finishing = true;
  }
  state_->changed.notify_one();
  if (state_->thread.joinable()) state_->thread.join();
  const MutexLock lock(state_->mutex);
  return state_->summary;
}

bool IsFrameRecording(const fs::path& dir) {
  std::error_code unknown;
  return fs::is_regular_file(dir / kIndex, unknown);
}

FrameRecording ReadFrameRecording(const fs::path& dir) {
  FrameRecording recording;
  recording.dir = dir;
  const std::string bytes = ReadWholeFile(dir / kIndex);
  int line_number = 0;
  for (std::size_t begin = 0, end; (end = bytes.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const std::string where = fmt::format("{}, line {}", (dir / kIndex).string(), ++line_number);
    json object;
    try {
      object = JsonFromText(bytes.substr(begin, end - begin));
    } catch (const json::exception&) {
      if (end + 1 == bytes.size()) break;  // truncated
      throw Error("{}: is damaged; truncate the file before this line to keep the frames before it", where);
    }
    const JsonPlace line{object, where};
    const std::string event = line.Text("event");
    if (event == "header") {
      recording.header = RecordingHeaderFromJson(line);
    } else if (event == "frame") {
      const auto path_of = [&](const char* key) -> fs::path {
        const fs::path file = line.Text(key, "");
        if (file.is_absolute() || file.lexically_normal().string().starts_with(".."))
          throw Error("{}: '{}' lies outside the recording", where, file.string());
        return file.empty() ? file : dir / file;
      };
      recording.entries.push_back({FrameFromJson(line), path_of("file"), path_of("raw")});
      recording.header.takes_stills |= recording.entries.back().frame.kind == FrameKind::kStill;
    }
  }
  if (recording.entries.empty())
    throw Error("{}: the recording contains no frames; record it again", dir.string());
  return recording;
}

Frame ReadRecordedFrame(const FrameRecording::Entry& entry) {
  const auto encoded = [](const fs::path& file) {
    return EncodedImage{file.extension().string(), std::make_shared<const std::string>(ReadWholeFile(file))};
  };
  Frame frame = entry.frame;
  if (!entry.raw_file.empty()) frame.raw = encoded(entry.raw_file);
  if (entry.file.empty()) {
    if (frame.raw && frame.status == FrameStatus::kComplete)
      frame.image = {DecodeRaw(*frame.raw->bytes, entry.raw_file.string(), RawQuality::kQuick).light,
                     Transfer::kLinear};
    return frame;
  }
  if (IsJpeg(entry.file.extension())) frame.encoded = encoded(entry.file);
  if (frame.status == FrameStatus::kIncomplete) return frame;
  // Decodes a photograph as the camera's driver does.
  if (frame.kind == FrameKind::kStill && frame.encoded)
    frame.image.pixels = DecodeJpeg(*frame.encoded->bytes);
  else
    frame.image.pixels = ReadImageFile(entry.file.string());
  if (frame.image.empty())
    throw Error("{}: the photograph is damaged; copy it again from its source, or remove its line in {}",
                entry.file.string(), kIndex);
  return frame;
}

}  // namespace ulf::acquisition

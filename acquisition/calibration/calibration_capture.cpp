#include "acquisition/calibration/calibration_capture.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "acquisition/calibration/other_board.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_folder.h"

namespace ulf::acquisition {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

class Streaming {
 public:
  explicit Streaming(Device& device) : device_(device) { device_.Start(); }
  ~Streaming() {
    try {
      device_.Stop();
    } catch (const std::exception&) {
      // The collected views are still good.
    }
  }
  Streaming(const Streaming&) = delete;
  Streaming& operator=(const Streaming&) = delete;

 private:
  Device& device_;
};

constexpr double kStillTimeout_s = 30;   // from the request for a photograph to its arrival; guessed
constexpr milliseconds kFrameWait(200);  // before the loop looks at `stop` again; guessed

// Returns the next frame; none if it is incomplete, or did not come in time.
std::optional<Frame> NextComplete(Device& device) {
  auto frame = device.Next(kFrameWait);
  if (device.State() == DeviceState::kLost)
    throw Error("{}: lost during calibration ({}); connect it and start again", device.Info().uri,
                device.Info().problem);
  if (!frame || frame->status != FrameStatus::kComplete || frame->image.empty()) return std::nullopt;
  return frame;
}

void RequireSize(CollectedViews& collected, const cv::Mat& gray, const std::string& name) {
  if (collected.width == 0) {
    collected.width = gray.cols;
    collected.height = gray.rows;
  }
  if (gray.cols != collected.width || gray.rows != collected.height)
    throw Error(
        "{}: is {}x{}, the others are {}x{}: intrinsics belong to one size; calibrate each size separately",
        name, gray.cols, gray.rows, collected.width, collected.height);
}

[[noreturn]] void ThrowSizes(const std::vector<std::string>& files) {
  std::vector<std::string> sizes;
  for (const std::string& file : files) {
    const cv::Size size = ReadImageSize(file);
    sizes.push_back(fmt::format("{}x{}", size.width, size.height));
  }
  const Mismatch odd = FirstMismatch(sizes).value_or(Mismatch{});
  throw Error("{}: is {}, {} of {} are {}: intrinsics belong to one size; calibrate each size separately",
              files[odd.odd], sizes[odd.odd], odd.usual_count, sizes.size(), sizes[odd.usual]);
}

// Requested photographs that have not arrived.
struct PendingStills {
  int count = 0;
  Clock::time_point last;
  bool Overdue() const { return count > 0 && SecondsSince(last) > kStillTimeout_s; }
};

// Notices early that another board is held before the camera than was said.
class OtherBoardWatch {
 public:
  explicit OtherBoardWatch(const Board& said) : said_(said), points_(said.Points()) {}

  // Looked at are the first ones of a while, then fewer and fewer.
  void NotSeen(const cv::Mat& gray, bool is_photograph) {
    Keep(gray);
    if (is_photograph) ThrowIfOther({gray});
    if (unseen_ < next_) return;
    next_ *= 4;
    ThrowIfOther({gray});
  }
  // Returns some of the pictures without the board, spread over the time.
  std::vector<cv::Mat> TakeUnseen() { return std::move(unseen_pictures_); }
  // The views so far: the first ones are looked at where their corners do not lie in a plane.
  void Taken(const std::vector<BoardView>& views, const std::vector<cv::Mat>& pictures) {
    constexpr std::size_t kFirst = 4;
    constexpr double kBent = 0.03;  // no lens bends a board so far; guessed
    if (views.size() != kFirst) return;
    if (std::ranges::any_of(views, [&](const BoardView& view) { return PlaneMisfit(points_, view) > kBent; }))
      ThrowIfOther(pictures);
  }

 private:
  void Keep(const cv::Mat& gray) {
    constexpr std::size_t kMost = 12;
    if (unseen_++ % apart_ != 0) return;
    if (unseen_pictures_.size() == kMost) {
      for (std::size_t i = 1; i < kMost / 2; ++i) std::swap(unseen_pictures_[i], unseen_pictures_[2 * i]);
      unseen_pictures_.resize(kMost / 2);
      apart_ *= 2;
    }
    unseen_pictures_.push_back(gray.clone());
  }
  void ThrowIfOther(const std::vector<cv::Mat>& pictures) const {
    if (const auto other = BoardInPictures(said_, pictures))
      throw Error("no calibration: {}", DescribeOtherBoard(said_, *other));
  }
  Board said_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<cv::Mat> unseen_pictures_;
  int unseen_ = 0, apart_ = 1, next_ = 30;  // frames; guessed
};

// Tells the photographer what a photograph showed.
std::string Finding(ViewVerdict verdict, const CalibrationGuide& guide) {
  const std::string corners = guide.last() ? Counted(guide.last()->ids.size(), "corner") : "";
  switch (verdict) {
    case ViewVerdict::kNotSeen:
      return "the board is not in it, or too little of it";
    case ViewVerdict::kBlurred:
      return corners + ", blurred: take it again, with a shorter exposure or from a tripod";
    case ViewVerdict::kNothingNew:
      return corners + ", nothing new: the board was there before";
    default:
      return corners + ", taken";
  }
}

bool WantsStills(const Device& device, const CalibrationCaptureOptions& options) {
  if (options.mode != "still") return false;
  if (!device.TakesStills())
    throw Refused(device.Info().uri, "takes no photographs besides its live frames",
                  fmt::format("leave {} still out", Parameter("mode")));
  return true;
}

}  // namespace

CollectedViews CollectViews(Device& device, const Board& board, const CalibrationCaptureOptions& options) {
  const bool stills = WantsStills(device, options);
  CollectedViews collected;
  std::optional<CalibrationGuide> guide, photographs;  // of live frames; of photographs
  int photograph = 0;
  PendingStills pending;
  OtherBoardWatch watch(board);
  const auto ask = [&] {
    if (device.RequestStill() != StillRequest::kAsked) return;
    ++pending.count;
    pending.last = Clock::now();
  };
  const auto show_picture = [&](const cv::Mat& gray, const CalibrationGuide& of, ViewVerdict verdict) {
    if (options.show_picture) options.show_picture(gray, of, verdict);
  };
  const Streaming streaming(device);
  if (stills)
    options.say(
        "photograph 1: hold the board still in the middle of the image, then press the camera's release, or "
        "Enter here; with live view it is released by itself");
  for (;;) {
    if (options.stop()) {
      collected.end = ViewsEnd::kStopped;
      break;
    }
    if (stills && pending.count == 0 && options.release()) ask();
    auto frame = NextComplete(device);
    if (!frame) {
      if (!stills) RequireLiveFrames(device);
      if (device.State() == DeviceState::kEnded) {
        collected.end = ViewsEnd::kDeviceEnded;
        break;
      }
      if (pending.Overdue()) {
        collected.end = ViewsEnd::kNoPhotograph;
        break;
      }
      continue;
    }
    const cv::Mat gray = GrayForTracking(frame->image);
    const std::string name = fmt::format("frame {}", frame->id);
    if (stills && frame->kind == FrameKind::kStill) {
      pending.count = std::max(0, pending.count - 1);
      RequireSize(collected, gray, name);
      if (!photographs) photographs.emplace(board, gray.cols, gray.rows, options.least_views);
      const ViewVerdict verdict =
          photographs->JudgePhotograph(gray, fmt::format("photograph {}", ++photograph));
      if (verdict == ViewVerdict::kNotSeen) {
        watch.NotSeen(gray, true);
      } else {
        collected.views.push_back(*photographs->last());
        collected.pictures.push_back(gray);
        watch.Taken(collected.views, collected.pictures);
      }
      // What live frames showed there is not to be had: it is still wanted.
      if (guide && verdict != ViewVerdict::kTaken) guide->RemoveLast();
      options.say(fmt::format("photograph {}: {}; {}", photograph, Finding(verdict, *photographs),
                              photographs->Enough() ? "these are enough"
                                                    : fmt::format("{} next: {}", photographs->Map(),
                                                                  photographs->NextInstruction())));
      show_picture(gray, *photographs, verdict);
    } else if (frame->kind == FrameKind::kLive) {
      if (!guide) guide.emplace(board, gray.cols, gray.rows, options.least_views);
      // Ignores live frames until the requested photograph arrives, because the board must stay until then.
      if (stills && pending.count > 0) {
        if (pending.Overdue()) {
          collected.end = ViewsEnd::kNoPhotograph;
          break;
        }
        continue;
      }
      if (!stills) RequireSize(collected, gray, name);
      const ViewVerdict verdict = guide->JudgeFrame(gray, name);
      if (verdict == ViewVerdict::kNotSeen) watch.NotSeen(gray, false);
      if (verdict == ViewVerdict::kMoving) ++collected.moving;
      if (verdict == ViewVerdict::kTaken) {
        if (stills) {
          ask();
        } else {
          collected.pictures.push_back(gray);
          watch.Taken(guide->views(), collected.pictures);
        }
      }
      const bool is_taken = IsTaken(device.Source());
      options.show({guide->Share(),
                    fmt::format("{}, {}{}; seen {}{}", Counted(guide->views().size(), "view"), Name(verdict),
                                verdict == ViewVerdict::kMoving && !is_taken ? ": hold still" : "",
                                guide->Map(), is_taken ? "" : "; " + guide->NextInstruction())});
      show_picture(gray, *guide, verdict);
    }
    const auto& judged = stills ? photographs : guide;
    if (judged && judged->Enough() && pending.count == 0) break;
  }
  if (!stills && guide) collected.views = guide->views();
  collected.unseen = watch.TakeUnseen();
  return collected;
}

CollectedViews CollectViews(const std::vector<std::string>& files, const Board& board,
                            const CalibrationCaptureOptions& options) {
  if (files.empty()) throw Error("no images to calibrate from; give a folder or image files");
  CollectedViews collected;
  for (std::size_t i = 0; i < files.size() && !options.stop(); ++i) {
    const Image image{ReadImageFile(files[i]), TransferOfFile(files[i])};
    const cv::Mat gray = GrayForTracking(image);
    if (i > 0 && gray.size() != cv::Size(collected.width, collected.height)) ThrowSizes(files);
    RequireSize(collected, gray, files[i]);
    BoardView view = DetectBoard(board, gray);
    view.name = fs::path(files[i]).filename().string();
    collected.views.push_back(std::move(view));
    options.show({static_cast<double>(i + 1) / static_cast<double>(files.size()), files[i]});
  }
  return collected;
}

std::vector<Frame> CollectFrames(Device& device, int count, const CalibrationCaptureOptions& options) {
  const bool stills = WantsStills(device, options);
  const FrameKind wanted = stills ? FrameKind::kStill : FrameKind::kLive;
  std::vector<Frame> frames;
  PendingStills pending;
  const Streaming streaming(device);
  while (static_cast<int>(frames.size()) < count && !options.stop() &&
         device.State() != DeviceState::kEnded) {
    if (stills && pending.count == 0 && device.RequestStill() == StillRequest::kAsked)
      pending = {1, Clock::now()};
    if (pending.Overdue())
      throw Error("{}: a photograph did not arrive within {:g} s; check the camera, and set it to JPEG",
                  device.Info().uri, kStillTimeout_s);
    auto frame = NextComplete(device);
    if (!frame && !stills) RequireLiveFrames(device);
    options.show({static_cast<double>(frames.size()) / count, Counted(frames.size(), "frame")});
    if (!frame || frame->kind != wanted) continue;
    pending.count = 0;
    frames.push_back(std::move(*frame));
  }
  return frames;
}

std::vector<std::string> ImagesIn(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    if (fs::is_regular_file(path)) {
      files.push_back(path);
      continue;
    }
    if (!fs::is_directory(path)) throw Error("{}: there is no such file or folder", path);
    const PictureFolder folder = PicturesIn(path);
    if (folder.pictures.empty()) RefuseWithoutPictures(path, folder);
    for (const std::string& line : folder.left_out) spdlog::warn("{}: left out: {}", path, line);
    for (const fs::path& file : folder.pictures) files.push_back(file.string());
  }
  return files;
}

}  // namespace ulf::acquisition

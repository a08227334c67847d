#include "coverage/session/record/bracket_capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/lowercase.h"

namespace ulf::coverage {
namespace {

// Guessed.
constexpr double kBracketPatience_s = 3;        // without a frame of the bracket,
constexpr double kBracketStillPatience_s = 60;  // and without a photograph
constexpr double kBracketSameExposure = 0.05;   // by this share exposures may differ that count as one

constexpr int kMostExposures = 9;
constexpr double kLeastStops = 1.0 / 3, kMostStops = 5;

}  // namespace

ExposureBracket ExposureBracket::Parse(const std::string& text) {
  ExposureBracket bracket;
  const char* const end = text.data() + text.size();
  const auto [after_count, no_count] = std::from_chars(text.data(), end, bracket.exposures);
  const bool has_x = no_count == std::errc() && after_count != end && *after_count == 'x';
  const auto [unit, no_stops] = std::from_chars(has_x ? after_count + 1 : end, end, bracket.stops);
  if (!has_x || no_stops != std::errc() || Lowercase(std::string(unit, end)) != "ev")
    throw Refusal(Parameter("bracket"), text,
                  "give the number of exposures of a view and the stops between them, such as 3x2EV", "");
  if (bracket.exposures < 2 || bracket.exposures > kMostExposures)
    throw Refusal(Parameter("bracket"), text,
                  fmt::format("{} exposures of a view are not possible", bracket.exposures),
                  fmt::format("from 2 to {}, such as 3x2EV", kMostExposures));
  if (!(bracket.stops > kLeastStops - 0.01 && bracket.stops <= kMostStops))
    throw Refusal(Parameter("bracket"), text,
                  fmt::format("{:g} stops from one exposure to the next are not possible", bracket.stops),
                  fmt::format("from 0.33 to {:g}, such as 3x2EV", kMostStops));
  return bracket;
}

std::string ExposureBracket::Text() const { return fmt::format("{}x{:g}EV", exposures, stops); }

std::vector<double> ExposureBracket::StopsBesideOwn() const {
  std::vector<double> beside;
  for (int i = 1; i < exposures; ++i) beside.push_back((i % 2 == 1 ? -1 : 1) * ((i + 1) / 2) * stops);
  return beside;
}

Frame AsExposed(const Frame& frame, double exposure_s, double gain) {
  if (frame.exposure_s <= 0 || exposure_s <= 0 || frame.image.empty()) return frame;
  const double factor = exposure_s * gain / (frame.exposure_s * frame.gain);
  Frame shown = frame;  // shares the pixels, which are not to be written into
  cv::Mat pixels;
  if (frame.image.transfer == Transfer::kLinear) {
    const double black = frame.black_level * FullScale(frame.image.pixels.depth());
    frame.image.pixels.convertTo(pixels, -1, factor, black * (1 - factor));
  } else {
    pixels = Srgb8FromLinear(LinearFloat(frame.image) * factor +
                             cv::Scalar::all(frame.black_level * (1 - factor)));
  }
  shown.image = {.pixels = pixels,
                 .transfer = frame.image.transfer,
                 .mosaic = pixels.channels() == 1 ? frame.image.mosaic : Mosaic::kNone};
  shown.encoded.reset();
  return shown;
}

BracketCapture::BracketCapture(acquisition::Device& device, const tracking::PoseSource& poses,
                               ViewSpool& spool, const ExposureBracket& bracket, bool deterministic,
                               std::function<void(const std::string&)> say)
    : device_(device),
      poses_(poses),
      spool_(spool),
      bracket_(bracket),
      deterministic_(deterministic),
      say_(std::move(say)) {}

void BracketCapture::Begin(int view_id, const Frame& frame, const tracking::Track& track) {
  running_ = Running{.view_id = view_id,
                     .view = track,
                     .asked = bracket_.StopsBesideOwn().size(),
                     .came = 0,
                     .is_asked = false,
                     .heard_s = frame.device_time_s};
  ++counts_.views;
  if (frame.kind == FrameKind::kLive) {
    exposure_s_ = frame.exposure_s;
    gain_ = frame.gain;
    last_ = TimedPose{frame.device_time_s, *track.cam_from_world};
  }
  RequestExposures();
}

void BracketCapture::RequestExposures() {
  running_->is_asked =
      device_.RequestExposures(bracket_.StopsBesideOwn()) == acquisition::StillRequest::kAsked;
}

bool BracketCapture::HasViewsExposure(const Frame& frame) const {
  return frame.exposure_s > 0 &&
         std::abs(std::log(frame.exposure_s * frame.gain / (exposure_s_ * gain_))) < kBracketSameExposure;
}

Frame BracketCapture::ForTracking(const Frame& frame) const {
  if (exposure_s_ <= 0 || frame.exposure_s <= 0 || HasViewsExposure(frame)) return frame;
  return AsExposed(frame, exposure_s_, gain_);
}

void BracketCapture::Record(int view_id, const Frame& frame, const Rigid3& exposure_from_view, bool between) {
  Frame kept = frame;  // shares the pixels
  if (deterministic_) kept.host_time_s = kept.device_time_s;
  spool_.AddExposure(view_id, kept, exposure_from_view, between);
  ++counts_.exposures;
  counts_.between += between;
}

// Between the last frame with a pose and this one; the hand moves evenly in so short a time.
void BracketCapture::PlaceWaiting(const TimedPose& after) {
  for (const Waiting& each : std::exchange(waiting_, {})) {
    const double span_s = last_ ? after.time_s - last_->time_s : 0;
    const double share =
        span_s > 0 ? std::clamp((each.frame.device_time_s - last_->time_s) / span_s, 0.0, 1.0) : 1;
    const Rigid3 cam_from_world =
        last_ ? Interpolated(last_->cam_from_world, after.cam_from_world, share) : after.cam_from_world;
    Record(each.view_id, each.frame, cam_from_world * each.view_from_world.Inverse(), true);
  }
}

void BracketCapture::EndIfOver(double now_s, double patience_s) {
  if (running_->came == running_->asked) {
    ended_s_ = now_s;
    return running_.reset();
  }
  if (now_s - running_->heard_s < patience_s) return;
  ++counts_.incomplete;
  say_(fmt::format("view {}: {} of its {} other exposures came within {:g} s; it keeps what there is{}",
                   running_->view_id, running_->came, running_->asked, patience_s,
                   running_->is_asked ? "" : " (the camera was busy)"));
  ended_s_ = now_s;
  running_.reset();
}

bool BracketCapture::Take(const Frame& frame, const tracking::Track& track) {
  std::optional<TimedPose> here;
  if (track.state == tracking::TrackState::kTracking)
    if (const auto now = poses_.PoseNow(track)) here = TimedPose{frame.device_time_s, *now};
  if (here) PlaceWaiting(*here);
  if (!running_) {
    if (here) last_ = here;
    const bool is_on_its_way = exposure_s_ > 0 && ended_s_ && !HasViewsExposure(frame) &&
                               frame.device_time_s < *ended_s_ + kBracketPatience_s;
    return frame.asked_stops || is_on_its_way;
  }
  if (!running_->is_asked) RequestExposures();
  if (frame.asked_stops) {
    const Rigid3 view_from_world = poses_.PoseNow(running_->view).value_or(*running_->view.cam_from_world);
    if (here)
      Record(running_->view_id, frame, here->cam_from_world * view_from_world.Inverse(), false);
    else
      waiting_.push_back({running_->view_id, view_from_world, frame});
    ++running_->came;
    running_->heard_s = frame.device_time_s;
  }
  if (here) last_ = here;
  EndIfOver(frame.device_time_s, device_.TakesStills() ? kBracketStillPatience_s : kBracketPatience_s);
  return true;
}

bool BracketCapture::TakeStill(const Frame& still, const std::optional<tracking::Track>& track) {
  if (!running_ || !still.asked_stops) return false;
  // A camera that brackets by itself takes the view's own exposure once more.
  if (*still.asked_stops != 0) ++running_->came;
  running_->heard_s = std::max(running_->heard_s, still.device_time_s);
  const int view_id = running_->view_id;
  const Rigid3 view_from_world = poses_.PoseNow(running_->view).value_or(*running_->view.cam_from_world);
  if (running_->came == running_->asked) running_.reset();
  if (!track || !track->cam_from_world) return false;
  Record(view_id, still, poses_.PoseNow(*track).value_or(*track->cam_from_world) * view_from_world.Inverse(),
         false);
  return true;
}

void BracketCapture::Finish() {
  if (last_ && !waiting_.empty()) PlaceWaiting(*last_);
  if (!running_) return;
  ++counts_.incomplete;
  running_.reset();
}

}  // namespace ulf::coverage

#include "acquisition/simulator/gige/simulated_gige_camera.h"

#include <fmt/core.h>
#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <optional>
#include <thread>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/simulator/gige/genicam_description.h"
#include "acquisition/simulator/gige/gige_address.h"
#include "acquisition/simulator/gige/gige_pictures.h"
#include "acquisition/simulator/gige/gige_registers.h"
#include "acquisition/simulator/gige/gvcp_server.h"
#include "acquisition/simulator/gige/pose_file.h"
#include "acquisition/simulator/gige/register_memory.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

using SystemClock = std::chrono::system_clock;

constexpr std::size_t kFramesAhead = 12;  // in the ring; guessed: they bridge a slow frame, but cost memory
constexpr int kMostInLoop = 10000;        // pictures; guessed
constexpr std::uint32_t kLine0 = 0;
constexpr double kPauseS = 1.0;  // after so long without a request for a frame the hand rests; guessed
constexpr std::chrono::milliseconds kRenderPatience(1500);  // wait for a frame, then none is sent; guessed
// The camera counts as started when it answers discovery: so many tries, each with this wait. Guessed.
constexpr int kAnswerTries = 10;
constexpr std::chrono::milliseconds kAnswerPatience(200);
constexpr std::chrono::milliseconds kStopCheck(100);  // so often it checks whether it is to stop; guessed
// The registers of frames and pulses accept no less. The camera looks for a software trigger as often.
constexpr std::uint32_t kShortestPeriodUs = 1000;
// Frames are numbered from 1 to 65535 again and again. The first number is a late one, so that a client that
// takes the overflow for a fault shows it early.
constexpr std::uint16_t kFirstFrameId = 65401;

std::int64_t MicrosecondsOf(SystemClock::time_point time) {
  return std::chrono::floor<std::chrono::microseconds>(time.time_since_epoch()).count();
}

// The part of a picture that the registers ask for. Where it lies beyond the sensor it is zero.
GvspFrame PartOf(const cv::Mat& pixels, std::uint32_t format_code, const RegisterMemory& memory) {
  GvspFrame part{.pixel_format = format_code,
                 .width = memory.Read(kWidthAt),
                 .height = memory.Read(kHeightAt),
                 .x = memory.Read(kOffsetXAt),
                 .y = memory.Read(kOffsetYAt),
                 .payload = {}};
  const cv::Rect wanted(static_cast<int>(part.x), static_cast<int>(part.y), static_cast<int>(part.width),
                        static_cast<int>(part.height));
  const PixelFormat format = PixelsOf(SensorFormatByCode(format_code).value_or(SensorFormat::kMono8));
  part.payload.resize(ImageBytes(format, wanted.width, wanted.height));
  PackImage(pixels, wanted & cv::Rect({}, pixels.size()), format, part.payload.data());
  // PayloadSize, which the client knows, is rounded down.
  part.payload.resize(std::size_t{part.width} * part.height * (format_code >> 16 & 0xFF) / 8);
  return part;
}

}  // namespace

struct SimulatedGigeCamera::State {
  explicit State(const GigeServerOptions& o)
      : options(o),
        pictures(o.simulation, o.board, static_cast<std::size_t>(std::clamp(o.loop, 0, kMostInLoop))),
        server(memory, WritableRegisters(o.simulation), [this](const GvcpAccess& request) {
          transport->BeforeRequest(request);
          sequencer.BeforeRequest(request);
        }) {}
  ~State();

  void Serve();
  std::string AddAddresses();
  void Run();
  bool Streams() const;
  bool Fires();
  SystemClock::time_point NextMoment() const;
  void TakeFrame();
  void Render();
  void PulseLine();
  void RunFaults();
  void FollowClock(std::int64_t moment, std::int64_t period_us, const GigeSettings& wanted, double now_s)
      ULF_REQUIRES(mutex);
  std::int64_t FramePeriodUs() const { return std::max(kShortestPeriodUs, memory.Read(kFramePeriodAt)); }
  bool IsTriggered() const { return memory.Read(kTriggerModeAt) != 0; }
  double HandTime(std::int64_t moment) const ULF_REQUIRES(mutex) {
    return origin_hand_s + 1e-6 * static_cast<double>((moment - origin_moment) * period_us);
  }

  GigeServerOptions options;
  GigePictures pictures;  // used only by the renderer while it runs
  std::optional<LoopbackAddress> public_address, hidden_address;
  std::unique_ptr<GigeRelay> relay;
  RegisterMemory memory{GenicamDescription()};
  std::unique_ptr<GigeTransport> transport;
  // Used by the thread that answers requests and takes frames.
  GigeSequencer sequencer{memory};
  GvcpServer server;
  std::optional<PoseFile> poses;
  std::uint16_t frame_id = kFirstFrameId - 1;

  // A moment is a number of frame periods since the epoch of the system clock.
  struct Ready {
    std::int64_t moment;
    double hand_s;
    Frame frame;
  };
  Mutex mutex;
  ConditionVariable asked, rendered, faults_due, line_due;
  std::deque<Ready> ring ULF_GUARDED_BY(mutex);
  GigeSettings settings ULF_GUARDED_BY(mutex);
  std::int64_t period_us ULF_GUARDED_BY(mutex) = 0;
  std::int64_t wanted_moment ULF_GUARDED_BY(mutex) = 0;
  std::int64_t rendered_moment ULF_GUARDED_BY(mutex) = 0;
  std::int64_t origin_moment ULF_GUARDED_BY(mutex) = 0;
  double origin_hand_s ULF_GUARDED_BY(mutex) = 0;
  double last_fill_s ULF_GUARDED_BY(mutex) = 0;
  // Changes when the frames in the ring become invalid.
  std::uint64_t epoch ULF_GUARDED_BY(mutex) = 0;
  bool streaming ULF_GUARDED_BY(mutex) = false;
  std::atomic<bool> stopping = false;  // set while mutex is held
  GigeServerStatistics statistics ULF_GUARDED_BY(mutex);
  double render_s ULF_GUARDED_BY(mutex) = 0;
  std::uint64_t renders ULF_GUARDED_BY(mutex) = 0;
  // Line0 is up for half of the time from pulse to pulse.
  std::chrono::steady_clock::time_point last_pulse ULF_GUARDED_BY(mutex);
  double pulse_period_s ULF_GUARDED_BY(mutex) = 0;
  std::optional<std::chrono::steady_clock::time_point> first_frame ULF_GUARDED_BY(mutex);
  std::thread server_thread, renderer, line, faults;
};

SimulatedGigeCamera::State::~State() {
  {
    const MutexLock lock(mutex);
    stopping = true;
  }
  for (ConditionVariable* waited : {&asked, &rendered, &faults_due, &line_due}) waited->notify_all();
  for (std::thread* thread : {&server_thread, &line, &faults, &renderer})
    if (thread->joinable()) thread->join();
}

// Adds the addresses and starts the relay if one is needed; returns the camera's own address.
std::string SimulatedGigeCamera::State::AddAddresses() {
  if (!options.simulation.faults.NeedRelay()) {
    public_address.emplace(options.interface);
    return options.interface;
  }
  const std::string hidden = HiddenGigeAddress(options.interface);
  public_address.emplace(options.interface);
  hidden_address.emplace(hidden);
  relay = std::make_unique<GigeRelay>(GigeRelayOptions{.camera = hidden,
                                                       .address = options.interface,
                                                       .faults = options.simulation.faults.link,
                                                       .resends = options.simulation.faults.resends,
                                                       .seed = options.simulation.seed});
  return hidden;
}

void SimulatedGigeCamera::State::Serve() {
  if (options.serial.empty() || options.serial.size() > 15)
    throw Refusal(Parameter("serial"), fmt::format("'{}'", options.serial),
                  "must have 1 to 15 characters, as GigE Vision allows", "");
  if (options.simulation.faults.incomplete > 0)
    throw Refusal("", "incomplete", "fault incomplete works with sim: only",
                  "over the network, lose packets with lost=0.005 and resend=0");
  if (options.simulation.faults.auto_exposure != AutoExposure::kOff)
    throw Refusal("", "auto_exposure", "fault auto_exposure works with sim: only",
                  "over the network, set ExposureTime while it streams");
  if (!(options.line_hz >= 0.1 && options.line_hz <= 200))
    throw Refusal(fmt::format("{:g} pulses a second on Line0", options.line_hz), "", "must be 0.1 to 200",
                  "");
  if (options.loop < 0 || options.loop > kMostInLoop)
    throw Refusal(fmt::format("a loop of {} pictures", options.loop), "", "must be at most 10000", "");
  if (options.loop > 0 && options.simulation.faults.ChangeWithTime())
    throw Refusal(
        "", "",
        "faults drift, bluer, flicker and hunting do not work with a loop, whose pictures are rendered once",
        "leave them or the loop out");
  const std::string address = AddAddresses();
  server.Listen(address);
  poses.emplace(options.poses, options.simulation.scene);
  pictures.RenderLoop();
  // Answers to broadcast discovery do not go through the relay, so they must give its address.
  WriteStartValues({options.interface, options.serial, options.line_hz}, options.simulation, memory);
  FileDescriptor stream = OpenUdpSocket(address, 0);
  memory.Write(kStreamSourcePortAt, std::uint32_t{PortOf(stream)});
  transport = std::make_unique<GigeTransport>(std::move(stream), memory, options.clock);
  server_thread = std::thread([this] { Run(); });
  renderer = std::thread([this] { Render(); });
  line = std::thread([this] { PulseLine(); });
  faults = std::thread([this] { RunFaults(); });

  for (int attempt = 0; attempt < kAnswerTries; ++attempt) {
    const auto answer = QueryGigeCamera(options.interface, kAnswerPatience);
    if (answer && answer->serial == options.serial) return;
  }
  throw Error("the camera '{}' does not answer at {}:{}; check the firewall, and for another camera there",
              options.serial, options.interface, kGvcpPort);
}

// Answers requests and takes frames, one after the other.
void SimulatedGigeCamera::State::Run() {
  prctl(PR_SET_TIMERSLACK, 1);  // frames begin at their moments
  while (!stopping) {
    const bool streams = Streams();
    const SystemClock::time_point due = streams ? NextMoment() : SystemClock::now() + kStopCheck;
    while (!stopping && Streams() == streams && SystemClock::now() < due)
      server.AnswerUntil(std::min(due, SystemClock::now() + kStopCheck));
    if (streams && Streams() && Fires()) TakeFrame();
  }
}

bool SimulatedGigeCamera::State::Streams() const {
  return server.IsControlled() && memory.Read(kAcquisitionAt) != 0 && memory.Read(kStreamPortAt) != 0;
}

// When the camera fires or, with a trigger, looks for one.
SystemClock::time_point SimulatedGigeCamera::State::NextMoment() const {
  const std::int64_t step_us = IsTriggered() ? kShortestPeriodUs : FramePeriodUs();
  return SystemClock::time_point(
      std::chrono::microseconds((MicrosecondsOf(SystemClock::now()) / step_us + 1) * step_us));
}

bool SimulatedGigeCamera::State::Fires() {
  if (!IsTriggered()) return true;
  if (memory.Read(kTriggerSoftwareAt) == 0) return false;
  memory.Write(kTriggerSoftwareAt, 0u);
  return true;
}

// Sends pulses on the simulated input line, also while no client waits for them.
void SimulatedGigeCamera::State::PulseLine() {
  auto next = std::chrono::steady_clock::now();
  MutexLock lock(mutex);
  while (true) {
    const std::uint32_t chosen = memory.Read(kTriggerSourceAt), line_us = memory.Read(kLinePeriodAt);
    next = std::max(next + std::chrono::microseconds(line_us), std::chrono::steady_clock::now());
    if (line_due.wait_until(lock, next, [this]() ULF_REQUIRES(mutex) { return stopping.load(); })) return;
    last_pulse = std::chrono::steady_clock::now();
    pulse_period_s = 1e-6 * line_us;
    if (chosen == kLine0) memory.Write(kTriggerSoftwareAt, 1u);
  }
}

// Opens and closes the relay's channels, and takes the clock's master away, at the times of the faults.
void SimulatedGigeCamera::State::RunFaults() {
  const SimulatedFaults& given = options.simulation.faults;
  std::vector<double> changes;
  for (const auto& spans : {given.freezes, given.disconnects, given.masters_lost})
    for (const FaultSpan& span : spans) {
      changes.push_back(span.at_s);
      changes.push_back(span.at_s + span.for_s);
    }
  std::sort(changes.begin(), changes.end());
  MutexLock lock(mutex);
  faults_due.wait(lock, [this]() ULF_REQUIRES(mutex) { return stopping || first_frame; });
  for (const double t_s : changes) {
    const auto due = *first_frame + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                        std::chrono::duration<double>(t_s));
    if (faults_due.wait_until(lock, due, [this]() ULF_REQUIRES(mutex) { return stopping.load(); })) return;
    transport->HearMaster(options.clock.ptp_lock_s >= 0 && !given.MasterLost(t_s));
    if (!relay) continue;
    const bool connected = !given.Disconnected(t_s);
    relay->PassControl(connected);
    relay->PassStream(connected && !given.Frozen(t_s));
  }
}

// Takes over the moment at which the camera fires now: restarts the hand after a pause or with a new frame
// period, and empties the ring when settings changed.
void SimulatedGigeCamera::State::FollowClock(std::int64_t moment, std::int64_t new_period_us,
                                             const GigeSettings& wanted, double now_s) {
  const bool paused =
      !IsTriggered() && now_s - last_fill_s > std::max(kPauseS, 5e-6 * static_cast<double>(period_us));
  if (!streaming || paused || new_period_us != period_us) {
    // The hand continues from its place at the last frame.
    const double hand_s = streaming ? statistics.hand_s + 1e-6 * static_cast<double>(new_period_us) : 0;
    origin_hand_s = hand_s;
    origin_moment = moment;
    period_us = new_period_us;
    streaming = true;
    settings = {};
  }
  if (!(settings == wanted)) {
    settings = wanted;
    ring.clear();
    rendered_moment = moment - 1;
    ++epoch;
  }
  last_fill_s = now_s;
  wanted_moment = moment;
  while (!ring.empty() && ring.front().moment < moment) ring.pop_front();
}

void SimulatedGigeCamera::State::TakeFrame() {
  const std::int64_t host_us = MicrosecondsOf(SystemClock::now()), new_period_us = FramePeriodUs();
  const std::uint64_t device_ns = transport->ClockNs(1000 * static_cast<std::uint64_t>(host_us));
  const std::int64_t moment = host_us / new_period_us;
  const GigeSettings wanted{sequencer.NextExposureUs(memory.Read(kExposureAt)), memory.Read(kGainAt),
                            memory.Read(kPixelFormatAt)};
  frame_id = frame_id == 0xFFFF ? 1 : frame_id + 1;
  transport->WaitUntilSent(kRenderPatience);

  MutexLock lock(mutex);
  FollowClock(moment, new_period_us, wanted, 1e-6 * static_cast<double>(host_us));
  const bool late = ring.empty();
  asked.notify_one();
  // Requests wait meanwhile; rendering a frame takes much less than a client's heartbeat time-out.
  rendered.wait_for(lock, kRenderPatience,
                    [this]() ULF_REQUIRES(mutex) { return stopping || !ring.empty(); });
  if (stopping || ring.empty()) return;
  const Ready ready = std::move(ring.front());
  ring.pop_front();
  asked.notify_one();
  const std::uint64_t number = ++statistics.served;
  if (late) ++statistics.late;
  statistics.hand_s = HandTime(ready.moment);
  if (!first_frame) {
    first_frame = std::chrono::steady_clock::now();
    faults_due.notify_all();
  }
  const std::uint32_t lines = SecondsSince(last_pulse) < 0.5 * pulse_period_s ? 1u << kLine0 : 0;
  lock.unlock();

  GvspFrame sent = PartOf(ready.frame.image.pixels, wanted.format, memory);
  sent.id = frame_id;
  sent.timestamp_ns = device_ns;
  const std::array<std::uint32_t, 5> last{frame_id, static_cast<std::uint32_t>(number), wanted.exposure_us,
                                          wanted.gain_tenths_db,
                                          static_cast<std::uint32_t>(std::llround(1e3 * ready.hand_s))};
  for (std::uint32_t i = 0; i < last.size(); ++i) memory.Write(kLastFrameAt + 4 * i, last[i]);
  memory.Write(kLineStatusAt, lines);
  if (!poses->Write(frame_id, device_ns, ready.frame, ready.hand_s)) {
    lock.lock();
    ++statistics.unwritten_poses;
    lock.unlock();
  }
  transport->Send(std::move(sent), {.exposure_us = static_cast<double>(wanted.exposure_us),
                                    .gain_db = 0.1 * wanted.gain_tenths_db,
                                    .frame_id = number,
                                    .lines = lines});
}

void SimulatedGigeCamera::State::Render() {
  MutexLock lock(mutex);
  while (true) {
    asked.wait(
        lock, [this]() ULF_REQUIRES(mutex) { return stopping || (streaming && ring.size() < kFramesAhead); });
    if (stopping) return;
    const std::int64_t moment = std::max(rendered_moment + 1, wanted_moment);
    const GigeSettings now = settings;
    const std::uint64_t now_epoch = epoch;
    const double hand_s = HandTime(moment);
    lock.unlock();
    const auto begin = std::chrono::steady_clock::now();
    Frame frame = pictures.At(hand_s, now);
    const double took_s = SecondsSince(begin);
    lock.lock();
    render_s += took_s;
    ++renders;
    if (epoch != now_epoch) continue;
    rendered_moment = moment;
    if (moment < wanted_moment && !ring.empty()) continue;
    // Keeps the frame although its moment may have passed, because a late frame is better than none. A frame
    // of the loop is of another time of the hand than `hand_s`.
    const double seen_s = frame.device_time_s - 0.5 * frame.exposure_s;
    ring.push_back({moment, seen_s, std::move(frame)});
    rendered.notify_one();
  }
}

SimulatedGigeCamera::SimulatedGigeCamera(const GigeServerOptions& options)
    : state_(std::make_unique<State>(options)) {
  state_->Serve();
}
SimulatedGigeCamera::~SimulatedGigeCamera() = default;

std::string SimulatedGigeCamera::DeviceId() const { return "ULF-" + state_->options.serial; }
const SimulatedCamera& SimulatedGigeCamera::camera() const { return state_->pictures.camera(); }
CameraModel SimulatedGigeCamera::StoredCamera() const { return state_->pictures.StoredCamera(); }
GigeRelay* SimulatedGigeCamera::relay() { return state_->relay.get(); }
void SimulatedGigeCamera::HearMaster(bool heard) { state_->transport->HearMaster(heard); }

GigeServerStatistics SimulatedGigeCamera::Statistics() const {
  const MutexLock lock(state_->mutex);
  GigeServerStatistics statistics = state_->statistics;
  statistics.refused = state_->server.Refused();
  if (state_->renders > 0)
    statistics.render_ms_mean = 1e3 * state_->render_s / static_cast<double>(state_->renders);
  return statistics;
}

}  // namespace ulf::acquisition

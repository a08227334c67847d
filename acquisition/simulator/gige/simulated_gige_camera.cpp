#include "acquisition/simulator/gige/simulated_gige_camera.h"

#include <arpa/inet.h>
#include <arv.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <optional>
#include <thread>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/simulator/gige/genicam_description.h"
#include "acquisition/simulator/gige/gige_address.h"
#include "acquisition/simulator/gige/gige_pictures.h"
#include "acquisition/simulator/gige/gige_registers.h"
#include "acquisition/simulator/gige/gvcp_filter.h"
#include "acquisition/simulator/gige/pose_file.h"
#include "acquisition/simulator/gige/taken_sockets.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

constexpr char kVendor[] = "ULF", kModel[] = "HandheldSimulator", kInfo[] = "ulf simulate: ray-cast scenes";
constexpr guint32 kVendorAt = 0x48, kModelAt = 0x68, kInfoAt = 0xa8;
constexpr std::size_t kFramesAhead = 12;  // in the ring; guessed: they bridge a slow frame, but cost memory
constexpr int kMostInLoop = 10000;        // pictures; guessed
constexpr guint32 kLine0 = 0;
constexpr double kPauseS = 1.0;  // after so long without a request for a frame the hand rests; guessed
constexpr std::chrono::milliseconds kRenderPatience(1500);  // wait for a frame, then none is sent; guessed
// The camera counts as started when it answers discovery: so many tries, each with this wait. Guessed.
constexpr int kAnswerTries = 10;
constexpr std::chrono::milliseconds kAnswerPatience(200);
constexpr guint32 kShortestPeriodUs = 1000;  // of frames and pulses: guards against a register of 0

}  // namespace

struct SimulatedGigeCamera::State {
  explicit State(const GigeServerOptions& o)
      : options(o),
        pictures(o.simulation, o.board, static_cast<std::size_t>(std::clamp(o.loop, 0, kMostInLoop))) {}
  ~State();

  void Serve();
  std::string AddAddresses();
  void InsertFilter(const std::vector<BoundSocket>& before, const std::string& address);
  void WriteRegisters();
  void Render();
  void PulseLine();
  void RunFaults();
  void DescribeFrame(ArvBuffer* buffer, const GigeSettings& wanted, std::uint64_t number, double hand_s);
  void Fill(ArvBuffer* buffer, const GigeSettings& wanted);
  void FollowClock(std::int64_t moment, std::int64_t period_us, const GigeSettings& wanted, double now_s)
      ULF_REQUIRES(mutex);
  double HandTime(std::int64_t moment) const ULF_REQUIRES(mutex) {
    return origin_hand_s + 1e-6 * static_cast<double>((moment - origin_moment) * period_us);
  }
  static void OnFill(ArvBuffer* buffer, void* self, guint32 exposure_us, guint32 gain,
                     ArvPixelFormat format) {
    auto* state = static_cast<State*>(self);
    if (!state->serves) return;
    state->Fill(buffer, {state->sequencer->NextExposureUs(exposure_us), gain, format});
  }

  GigeServerOptions options;
  GigePictures pictures;  // used only by the renderer while it runs
  std::optional<LoopbackAddress> public_address, hidden_address;
  std::unique_ptr<GigeRelay> relay;
  std::unique_ptr<GigeTransport> transport;
  std::unique_ptr<GigeSequencer> sequencer;
  std::unique_ptr<GvcpFilter> filter;
  std::atomic<bool> serves = false;  // all above is there: Aravis orders its threads unseen by sanitizers
  ArvGvFakeCamera* server = nullptr;
  ArvFakeCamera* registers = nullptr;
  std::optional<PoseFile> poses;

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
  bool stopping ULF_GUARDED_BY(mutex) = false;
  GigeServerStatistics statistics ULF_GUARDED_BY(mutex);
  double render_s ULF_GUARDED_BY(mutex) = 0;
  std::uint64_t renders ULF_GUARDED_BY(mutex) = 0;
  // Line0 is up for half of the time from pulse to pulse.
  std::chrono::steady_clock::time_point last_pulse ULF_GUARDED_BY(mutex);
  double pulse_period_s ULF_GUARDED_BY(mutex) = 0;
  std::optional<std::chrono::steady_clock::time_point> first_frame ULF_GUARDED_BY(mutex);
  std::thread renderer, line, faults;
};

SimulatedGigeCamera::State::~State() {
  {
    const MutexLock lock(mutex);
    stopping = true;
  }
  for (ConditionVariable* waited : {&asked, &rendered, &faults_due, &line_due}) waited->notify_all();
  for (std::thread* thread : {&line, &faults, &renderer})
    if (thread->joinable()) thread->join();
  relay.reset();
  filter.reset();
  if (server) g_object_unref(server);  // joins the thread that calls Fill
}

// Adds the addresses and starts the relay if one is needed; returns the address for Aravis's camera.
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
  RequireFreeGigeAddress(address);  // Aravis does not report when it cannot bind
  poses.emplace(options.poses, options.simulation.scene);
  pictures.RenderLoop();
  const std::vector<BoundSocket> before = BoundUdpSockets();
  {
    const GenicamDescriptionFile description;
    server = arv_gv_fake_camera_new_full(address.c_str(), options.serial.c_str(), description.path());
  }
  if (!server || !arv_gv_fake_camera_is_running(server))
    throw Error("no GigE Vision camera could be started at {}; check that it is an address of this machine",
                address);
  registers = arv_gv_fake_camera_get_fake_camera(server);
  InsertFilter(before, address);
  WriteRegisters();
  arv_fake_camera_set_trigger_frequency(registers, 1000);
  serves = true;
  arv_fake_camera_set_fill_pattern(registers, OnFill, this);
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

void SimulatedGigeCamera::State::InsertFilter(const std::vector<BoundSocket>& before,
                                              const std::string& address) {
  const TakenSockets taken = TakeControlSockets(before, address);
  if (taken.unicast < 0)
    throw Error("{}:{} cannot be opened; check for another camera there", address, kGvcpPort);
  if (taken.stream < 0) throw Error("{}: Aravis's stream socket was not found", address);
  arv_fake_camera_write_register(registers, kStreamSourcePortAt, static_cast<guint32>(taken.stream_port));
  const RegisterAccess access{
      .read =
          [this](std::uint32_t at) {
            guint32 value = 0;
            arv_fake_camera_read_register(registers, at, &value);
            return value;
          },
      .write = [this](std::uint32_t at,
                      std::uint32_t value) { arv_fake_camera_write_register(registers, at, value); }};
  transport = std::make_unique<GigeTransport>(taken.stream, address, access, options.clock);
  sequencer = std::make_unique<GigeSequencer>(access);
  filter = std::make_unique<GvcpFilter>(GvcpFilterOptions{
      .unicast = taken.unicast,
      .broadcasts = taken.broadcasts,
      .camera = taken.to_library,
      .memory_bytes =
          static_cast<std::uint32_t>(ARV_FAKE_CAMERA_MEMORY_SIZE + (GenicamDescription().size() + 3) / 4 * 4),
      .writable = WritableRegisters(options.simulation),
      .privilege = [this] { return arv_fake_camera_get_control_channel_privilege(registers); },
      .before =
          [this](const GvcpAccess& request) {
            transport->BeforeRequest(request);
            sequencer->BeforeRequest(request);
          }});
}

void SimulatedGigeCamera::State::WriteRegisters() {
  const auto name = [&](guint32 at, const char* text) {
    char field[32] = {};
    std::strncpy(field, text, sizeof(field) - 1);
    arv_fake_camera_write_memory(registers, at, sizeof(field), field);
  };
  name(kVendorAt, kVendor);
  name(kModelAt, kModel);
  name(kInfoAt, kInfo);
  const auto set = [&](guint32 at, double value) {
    arv_fake_camera_write_register(registers, at, static_cast<guint32>(std::lround(value)));
  };
  const SimulationOptions& simulation = options.simulation;
  set(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, simulation.width);
  set(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, simulation.height);
  set(ARV_FAKE_CAMERA_REGISTER_WIDTH, simulation.width);
  set(ARV_FAKE_CAMERA_REGISTER_HEIGHT, simulation.height);
  set(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, 1e6 / simulation.fps);
  set(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US, 1e6 * simulation.exposure_s);
  set(ARV_FAKE_CAMERA_REGISTER_GAIN_RAW, 10 * simulation.gain_db);
  set(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT, PixelsOf(simulation.format).code);
  // Aravis's camera has software triggers only; the register at kTriggerSourceAt holds the client's choice.
  set(ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE, 1);
  set(kTriggerSourceAt, 1);
  set(kLinePeriodAt, 1e6 / options.line_hz);
  set(kThroughputLimitAt, 125e6);  // gigabit Ethernet
  set(kTickFrequencyAt + 4, 1e9);  // the lower half: the clock counts nanoseconds
  if (!relay) return;
  // The camera's answers to broadcast discovery do not go through the relay, so they must give its address.
  in_addr public_bytes{};
  inet_pton(AF_INET, options.interface.c_str(), &public_bytes);
  arv_fake_camera_write_memory(registers, kCurrentAddressAt, sizeof(public_bytes), &public_bytes);
}

// Sends pulses on the simulated input line, also while no client waits for them.
void SimulatedGigeCamera::State::PulseLine() {
  auto next = std::chrono::steady_clock::now();
  MutexLock lock(mutex);
  while (true) {
    guint32 chosen = 0, line_us = 0;
    arv_fake_camera_read_register(registers, kTriggerSourceAt, &chosen);
    arv_fake_camera_read_register(registers, kLinePeriodAt, &line_us);
    next = std::max(next + std::chrono::microseconds(std::max(kShortestPeriodUs, line_us)),
                    std::chrono::steady_clock::now());
    if (line_due.wait_until(lock, next, [this]() ULF_REQUIRES(mutex) { return stopping; })) return;
    last_pulse = std::chrono::steady_clock::now();
    pulse_period_s = 1e-6 * line_us;
    if (chosen == kLine0)
      arv_fake_camera_write_register(registers, ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOFTWARE, 1);
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
    if (faults_due.wait_until(lock, due, [this]() ULF_REQUIRES(mutex) { return stopping; })) return;
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
  const bool free_running = arv_fake_camera_is_in_free_running_mode(registers);
  const bool paused =
      free_running && now_s - last_fill_s > std::max(kPauseS, 5e-6 * static_cast<double>(period_us));
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

void SimulatedGigeCamera::State::Fill(ArvBuffer* buffer, const GigeSettings& wanted) {
  transport->WaitUntilSent(kRenderPatience);
  const std::uint64_t host_ns = arv_buffer_get_timestamp(buffer), device_ns = transport->ClockNs(host_ns);
  guint32 register_us = 0;
  arv_fake_camera_read_register(registers, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                                &register_us);
  const std::int64_t new_period_us = std::max(kShortestPeriodUs, register_us);
  const auto moment = static_cast<std::int64_t>(host_ns / 1000) / new_period_us;

  MutexLock lock(mutex);
  FollowClock(moment, new_period_us, wanted, 1e-9 * static_cast<double>(host_ns));
  const bool late = ring.empty();
  asked.notify_one();
  // Control requests wait meanwhile; rendering a frame takes much less than a client's heartbeat time-out.
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
  const guint32 lines = SecondsSince(last_pulse) < 0.5 * pulse_period_s ? 1u << kLine0 : 0;
  lock.unlock();

  std::size_t received = 0;
  auto* out = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &received)));
  const cv::Mat& pixels = ready.frame.image.pixels;
  const cv::Rect part = cv::Rect(arv_buffer_get_image_x(buffer), arv_buffer_get_image_y(buffer),
                                 arv_buffer_get_image_width(buffer), arv_buffer_get_image_height(buffer)) &
                        cv::Rect(0, 0, pixels.cols, pixels.rows);
  if (const auto format = SensorFormatByCode(wanted.format)) PackImage(pixels, part, PixelsOf(*format), out);
  DescribeFrame(buffer, wanted, number, ready.hand_s);
  arv_fake_camera_write_register(registers, kLineStatusAt, lines);
  if (!poses->Write(arv_buffer_get_frame_id(buffer), device_ns, ready.frame, ready.hand_s)) {
    lock.lock();
    ++statistics.unwritten_poses;
    lock.unlock();
  }
  if (!transport->Sends()) return;
  GvspFrame sent{.id = static_cast<std::uint16_t>(arv_buffer_get_frame_id(buffer)),
                 .timestamp_ns = device_ns,
                 .pixel_format = wanted.format,
                 .width = static_cast<std::uint32_t>(part.width),
                 .height = static_cast<std::uint32_t>(part.height),
                 .x = static_cast<std::uint32_t>(part.x),
                 .y = static_cast<std::uint32_t>(part.y),
                 .payload = {}};
  if (const auto format = SensorFormatByCode(wanted.format))
    sent.payload.assign(out, out + ImageBytes(PixelsOf(*format), part.width, part.height));
  transport->Send(std::move(sent), {.exposure_us = static_cast<double>(wanted.exposure_us),
                                    .gain_db = 0.1 * wanted.gain_tenths_db,
                                    .frame_id = number,
                                    .lines = lines});
}

// This thread also answers requests, so that registers that are read in one request describe one frame.
void SimulatedGigeCamera::State::DescribeFrame(ArvBuffer* buffer, const GigeSettings& wanted,
                                               std::uint64_t number, double hand_s) {
  const std::array<guint32, 5> values{static_cast<guint32>(arv_buffer_get_frame_id(buffer)),
                                      static_cast<guint32>(number), wanted.exposure_us, wanted.gain_tenths_db,
                                      static_cast<guint32>(std::llround(1e3 * hand_s))};
  for (std::size_t i = 0; i < values.size(); ++i)
    arv_fake_camera_write_register(registers, kLastFrameAt + 4 * static_cast<guint32>(i), values[i]);
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

std::string SimulatedGigeCamera::DeviceId() const {
  return std::string(kVendor) + "-" + state_->options.serial;
}
const SimulatedCamera& SimulatedGigeCamera::camera() const { return state_->pictures.camera(); }
CameraModel SimulatedGigeCamera::StoredCamera() const { return state_->pictures.StoredCamera(); }
GigeRelay* SimulatedGigeCamera::relay() { return state_->relay.get(); }
void SimulatedGigeCamera::HearMaster(bool heard) { state_->transport->HearMaster(heard); }

GigeServerStatistics SimulatedGigeCamera::Statistics() const {
  const MutexLock lock(state_->mutex);
  GigeServerStatistics statistics = state_->statistics;
  statistics.refused = state_->filter->Refused();
  if (state_->renders > 0)
    statistics.render_ms_mean = 1e3 * state_->render_s / static_cast<double>(state_->renders);
  return statistics;
}

}  // namespace ulf::acquisition

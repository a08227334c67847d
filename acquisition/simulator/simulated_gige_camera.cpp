#include "acquisition/simulator/simulated_gige_camera.h"

#include <arpa/inet.h>
#include <arv.h>
#include <fmt/core.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <fstream>
#include <mutex>
#include <thread>

#include "acquisition/aravis/gige_vision_probe.h"
#include "acquisition/error.h"
#include "acquisition/simulator/genicam_description.h"

namespace ulf {
namespace {

constexpr char kVendor[] = "ULF", kModel[] = "HandheldSimulator", kInfo[] = "ulf simulate: ray-cast scenes";
constexpr guint32 kVendorAt = 0x48, kModelAt = 0x68, kInfoAt = 0xa8;
constexpr std::size_t kFramesAhead = 12;
constexpr double kPauseS = 1.0;  // without a frame for so long: nobody streams, the hand rests

struct Settings {
  guint32 exposure_us = 0, gain_tenths_db = 0;
  ArvPixelFormat format = 0;
  bool operator==(const Settings&) const = default;
};

std::optional<SensorFormat> FormatFrom(ArvPixelFormat format) {
  switch (format) {
    case ARV_PIXEL_FORMAT_MONO_8:
      return SensorFormat::kMono8;
    case ARV_PIXEL_FORMAT_BAYER_RG_8:
      return SensorFormat::kBayerRg8;
    case ARV_PIXEL_FORMAT_RGB_8_PACKED:
      return SensorFormat::kRgb8;
    default:
      return std::nullopt;
  }
}

ArvPixelFormat CodeOf(SensorFormat format) {
  return format == SensorFormat::kMono8      ? ARV_PIXEL_FORMAT_MONO_8
         : format == SensorFormat::kBayerRg8 ? ARV_PIXEL_FORMAT_BAYER_RG_8
                                             : ARV_PIXEL_FORMAT_RGB_8_PACKED;
}

// Aravis does not say when it fails to bind: find out before.
void RequireFree(const std::string& address) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(kGvcpPort);
  if (inet_pton(AF_INET, address.c_str(), &at.sin_addr) != 1)
    throw UsageError("--interface {}: not an IPv4 address such as 127.0.0.1", address);
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const int failed = bind(socket_fd, reinterpret_cast<const sockaddr*>(&at), sizeof(at)) == 0 ? 0 : errno;
  close(socket_fd);
  if (failed == EADDRNOTAVAIL)
    throw Error(
        "{} is not an address of this machine; give one of its own (ip addr), or add it to the loopback: "
        "ip addr add {}/8 dev lo",
        address, address);
  if (failed == EADDRINUSE) {
    const auto camera = AskGigeCamera(address);
    throw Error("{}:{} is taken by {}; stop it, or serve on another address (ip addr add 127.0.0.2/8 dev lo)",
                address, kGvcpPort,
                camera ? "a GigE Vision camera with serial '" + camera->serial + "'" : "another program");
  }
  if (failed != 0) throw Error("{}:{} cannot be opened: {}", address, kGvcpPort, std::strerror(failed));
}

// A GenICam description has to come from a file; Aravis maps it, so its name is needed only while the camera
// is made.
class DescriptionFile {
 public:
  DescriptionFile() {
    path_ = (std::filesystem::temp_directory_path() / "ulf_genicam_XXXXXX").string();
    const int file = mkstemp(path_.data());
    const auto size = static_cast<ssize_t>(std::strlen(kGenicamDescription));
    const bool whole = file >= 0 && write(file, kGenicamDescription, static_cast<std::size_t>(size)) == size;
    if (file >= 0) close(file);
    if (!whole) throw Error("{}: cannot be written: {}; free some space there", path_, std::strerror(errno));
  }
  ~DescriptionFile() { unlink(path_.c_str()); }
  DescriptionFile(const DescriptionFile&) = delete;
  DescriptionFile& operator=(const DescriptionFile&) = delete;
  const char* path() const { return path_.c_str(); }

 private:
  std::string path_;
};

}  // namespace

struct SimulatedGigeCamera::State {
  explicit State(const GigeServerOptions& o) : options(o), camera(o.simulation) {}
  ~State();

  void Serve();
  void OpenPoses();
  void Render();
  void Fill(ArvBuffer* buffer, const Settings& wanted);
  void FollowClock(std::int64_t moment, std::int64_t period_us, const Settings& wanted, double now_s);
  double HandTime(std::int64_t moment) const {
    return origin_hand_s + 1e-6 * static_cast<double>((moment - origin_moment) * period_us);
  }
  void WritePose(std::uint64_t frame_id, std::uint64_t device_ns, const Frame& frame, double hand_s);
  static void OnFill(ArvBuffer* buffer, void* self, guint32 exposure_us, guint32 gain,
                     ArvPixelFormat format) {
    static_cast<State*>(self)->Fill(buffer, {exposure_us, gain, format});
  }

  GigeServerOptions options;
  SimulatedCamera camera;
  ArvGvFakeCamera* server = nullptr;
  ArvFakeCamera* registers = nullptr;
  std::FILE* poses = nullptr;

  // A moment is a number of frame periods since the epoch of the system clock.
  struct Ready {
    std::int64_t moment;
    Frame frame;
  };
  std::mutex mutex;
  std::condition_variable asked, rendered;
  std::deque<Ready> ring;
  Settings settings;
  std::int64_t period_us = 0, wanted_moment = 0, rendered_moment = 0, origin_moment = 0;
  double origin_hand_s = 0, last_fill_s = 0;
  std::uint64_t epoch = 0;  // changes whenever what is in the ring has become worthless
  bool streaming = false, stopping = false;
  GigeServerStatistics statistics;
  double render_s = 0;
  std::uint64_t renders = 0;
  std::thread renderer;
};

SimulatedGigeCamera::State::~State() {
  {
    const std::lock_guard lock(mutex);
    stopping = true;
  }
  asked.notify_all();
  rendered.notify_all();
  if (server) g_object_unref(server);  // joins the thread that calls Fill
  if (renderer.joinable()) renderer.join();
  if (poses) std::fclose(poses);
}

void SimulatedGigeCamera::State::OpenPoses() {
  if (options.poses.empty()) return;
  poses = std::fopen(options.poses.c_str(), "w");
  if (!poses) throw Error("{}: cannot be written: {}", options.poses.string(), std::strerror(errno));
  fmt::print(poses,
             "# ulf simulate, scene {}: camera-to-world poses in TUM's format, metres\n"
             "# timestamp[s, device clock, start of exposure] tx ty tz qx qy qz qw (middle of exposure)\n",
             options.simulation.scene);
  std::fflush(poses);
}

void SimulatedGigeCamera::State::Serve() {
  if (options.serial.empty() || options.serial.size() > 15)
    throw UsageError("--serial '{}': must have 1 to 15 characters, as GigE Vision allows", options.serial);
  RequireFree(options.interface);
  OpenPoses();
  {
    const DescriptionFile description;
    server =
        arv_gv_fake_camera_new_full(options.interface.c_str(), options.serial.c_str(), description.path());
  }
  if (!server || !arv_gv_fake_camera_is_running(server))
    throw Error("no GigE Vision camera could be started at {}; is the address one of this machine's?",
                options.interface);
  registers = arv_gv_fake_camera_get_fake_camera(server);
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
  set(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT, CodeOf(simulation.format));
  set(ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE, 1);
  arv_fake_camera_set_trigger_frequency(registers, 1000);
  arv_fake_camera_set_fill_pattern(registers, OnFill, this);
  renderer = std::thread([this] { Render(); });

  for (int attempt = 0; attempt < 10; ++attempt) {
    const auto camera = AskGigeCamera(options.interface, std::chrono::milliseconds(200));
    if (camera && camera->serial == options.serial) return;
  }
  throw Error("the camera '{}' does not answer at {}:{}; a firewall, or another camera there?",
              options.serial, options.interface, kGvcpPort);
}

// The moment that the camera fires at now, and what changed since the last one. Under the lock.
void SimulatedGigeCamera::State::FollowClock(std::int64_t moment, std::int64_t new_period_us,
                                             const Settings& wanted, double now_s) {
  const bool free_running = arv_fake_camera_is_in_free_running_mode(registers);
  const bool paused =
      free_running && now_s - last_fill_s > std::max(kPauseS, 5e-6 * static_cast<double>(period_us));
  if (!streaming || paused || new_period_us != period_us) {
    // The hand goes on from where it was when the last frame was taken.
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

void SimulatedGigeCamera::State::Fill(ArvBuffer* buffer, const Settings& wanted) {
  const std::uint64_t device_ns = arv_buffer_get_timestamp(buffer);
  guint32 register_us = 0;
  arv_fake_camera_read_register(registers, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                                &register_us);
  const std::int64_t new_period_us = std::max<guint32>(1000, register_us);
  const auto moment = static_cast<std::int64_t>(device_ns / 1000) / new_period_us;

  std::unique_lock lock(mutex);
  FollowClock(moment, new_period_us, wanted, 1e-9 * static_cast<double>(device_ns));
  const bool late = ring.empty();
  asked.notify_one();
  // Rendering one frame takes far less than the heartbeat of a client's control channel, which waits behind
  // us.
  rendered.wait_for(lock, std::chrono::milliseconds(1500), [&] { return stopping || !ring.empty(); });
  if (stopping || ring.empty()) return;
  const Ready ready = std::move(ring.front());
  ring.pop_front();
  asked.notify_one();
  ++statistics.served;
  if (late) ++statistics.late;
  statistics.hand_s = HandTime(ready.moment);
  const double hand_s = statistics.hand_s;
  lock.unlock();

  std::size_t received = 0;
  auto* out = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &received)));
  const cv::Mat& pixels = ready.frame.image.pixels;
  const cv::Rect part = cv::Rect(arv_buffer_get_image_x(buffer), arv_buffer_get_image_y(buffer),
                                 arv_buffer_get_image_width(buffer), arv_buffer_get_image_height(buffer)) &
                        cv::Rect(0, 0, pixels.cols, pixels.rows);
  const std::size_t row_bytes =
      pixels.elemSize() * static_cast<std::size_t>(arv_buffer_get_image_width(buffer));
  for (int y = 0; y < part.height; ++y) {
    const std::uint8_t* in =
        pixels.ptr<std::uint8_t>(part.y + y) + pixels.elemSize() * static_cast<std::size_t>(part.x);
    std::uint8_t* row = out + static_cast<std::size_t>(y) * row_bytes;
    if (pixels.channels() == 1) {
      std::memcpy(row, in, static_cast<std::size_t>(part.width));
      continue;
    }
    for (int x = 0; x < part.width; ++x) {  // R, G, B on the wire
      row[3 * x] = in[3 * x + 2];
      row[3 * x + 1] = in[3 * x + 1];
      row[3 * x + 2] = in[3 * x];
    }
  }
  WritePose(arv_buffer_get_frame_id(buffer), device_ns, ready.frame, hand_s);
}

void SimulatedGigeCamera::State::WritePose(std::uint64_t frame_id, std::uint64_t device_ns,
                                           const Frame& frame, double hand_s) {
  if (!poses) return;
  const Rigid3 world_from_cam = frame.known_cam_from_world->Inverse();
  const Eigen::Vector3d& t = world_from_cam.translation;
  const Eigen::Quaterniond& q = world_from_cam.rotation;
  fmt::print(poses, "# frame {} hand_s {:.6f}\n{}.{:09d} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
             frame_id, hand_s, device_ns / 1000000000u, device_ns % 1000000000u, t.x(), t.y(), t.z(), q.x(),
             q.y(), q.z(), q.w());
  std::fflush(poses);
}

void SimulatedGigeCamera::State::Render() {
  std::unique_lock lock(mutex);
  while (true) {
    asked.wait(lock, [&] { return stopping || (streaming && ring.size() < kFramesAhead); });
    if (stopping) return;
    const std::int64_t moment = std::max(rendered_moment + 1, wanted_moment);
    const Settings now = settings;
    const std::uint64_t now_epoch = epoch;
    const double hand_s = HandTime(moment);
    lock.unlock();
    const auto format = FormatFrom(now.format);
    const auto begin = std::chrono::steady_clock::now();
    Frame frame = camera.Capture({.open_s = hand_s,
                                  .exposure_s = 1e-6 * std::max(10u, now.exposure_us),
                                  .gain = std::pow(10, now.gain_tenths_db / 200.0),
                                  .format = format.value_or(SensorFormat::kMono8),
                                  .id = static_cast<std::uint64_t>(std::llround(hand_s * 1e6))});
    const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    lock.lock();
    render_s += took_s;
    ++renders;
    if (epoch != now_epoch) continue;
    rendered_moment = moment;
    if (moment < wanted_moment && !ring.empty()) continue;
    // Even when its moment has passed: better the latest picture that there is than none.
    ring.push_back({moment, std::move(frame)});
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
const SimulatedCamera& SimulatedGigeCamera::camera() const { return state_->camera; }

GigeServerStatistics SimulatedGigeCamera::Statistics() const {
  const std::lock_guard lock(state_->mutex);
  GigeServerStatistics statistics = state_->statistics;
  if (state_->renders > 0)
    statistics.render_ms_mean = 1e3 * state_->render_s / static_cast<double>(state_->renders);
  return statistics;
}

}  // namespace ulf

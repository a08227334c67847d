#include "tests/support/v4l2_camera.h"
#include "core/light_field/formats/set_format.h"
#include "tests/support/floors.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/mman.h>
#include <time.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace ulf::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kMostBuffers = 4;

void CopyText(const std::string& text, unsigned char* to, std::size_t size) {
  std::memset(to, 0, size);
  std::memcpy(to, text.data(), std::min(text.size(), size - 1));
}

std::string Taken(GError* error) {
  const std::string text = error ? error->message : "unknown";
  g_clear_error(&error);
  return text;
}

}  // namespace

std::optional<std::string> NoV4l2Emulation() {
  const char* preloaded = std::getenv("LD_PRELOAD");
  if (!preloaded || !std::strstr(preloaded, "libumockdev-preload"))
    return "no emulated video device: this process does not run under umockdev-wrapper";
  return std::nullopt;
}

std::vector<EmulatedControl> UsualControls() {
  return {{.id = V4L2_CID_BRIGHTNESS, .title = "Brightness", .min = -64, .max = 64, .value = 0},
          {.id = V4L2_CID_AUTO_WHITE_BALANCE,
           .title = "White Balance, Automatic",
           .type = V4L2_CTRL_TYPE_BOOLEAN,
           .max = 1,
           .value = 1},
          {.id = V4L2_CID_GAIN, .title = "Gain", .max = 255, .value = 16},
          {.id = V4L2_CID_WHITE_BALANCE_TEMPERATURE,
           .title = "White Balance Temperature",
           .min = 2800,
           .max = 6500,
           .step = 10,
           .value = 4600},
          {.id = V4L2_CID_EXPOSURE_AUTO,
           .title = "Auto Exposure",
           .type = V4L2_CTRL_TYPE_MENU,
           .max = 3,
           .value = V4L2_EXPOSURE_APERTURE_PRIORITY,
           .menu = {{1, "Manual Mode"}, {3, "Aperture Priority Mode"}}},
          {.id = V4L2_CID_EXPOSURE_ABSOLUTE,
           .title = "Exposure Time, Absolute",
           .min = 3,
           .max = 2047,
           .value = 100},
          {.id = V4L2_CID_FOCUS_ABSOLUTE, .title = "Focus, Absolute", .max = 1023, .step = 1, .value = 250},
          {.id = V4L2_CID_FOCUS_AUTO,
           .title = "Focus, Automatic Continuous",
           .type = V4L2_CTRL_TYPE_BOOLEAN,
           .max = 1,
           .value = 1}};
}

std::size_t EmulatedV4l2Camera::RowBytes(const EmulatedMode& mode) {
  switch (mode.fourcc) {
    case V4L2_PIX_FMT_YUYV:
    case V4L2_PIX_FMT_UYVY:
    case V4L2_PIX_FMT_Y16:
      return 2 * mode.width;
    case V4L2_PIX_FMT_RGB24:
      return 3 * mode.width;
    case V4L2_PIX_FMT_MJPEG:
      return 0;
    default:
      return mode.width;
  }
}

std::vector<std::uint8_t> EmulatedV4l2Camera::Ramp(const EmulatedMode& mode, std::uint32_t sequence) {
  const std::size_t row = RowBytes(mode);
  const std::size_t rows = mode.fourcc == V4L2_PIX_FMT_NV12 ? mode.height * 3 / 2 : mode.height;
  std::vector<std::uint8_t> bytes(row * rows);
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t x = 0; x < row; ++x)
      bytes[y * row + x] = static_cast<std::uint8_t>(3 * x + 5 * y + sequence);
  return bytes;
}

struct EmulatedV4l2Camera::State {
  explicit State(const V4l2CameraOptions& chosen) : options(chosen), mode(chosen.modes.front()) {
    testbed = umockdev_testbed_new();
    handler = umockdev_ioctl_base_new();
    g_signal_connect(handler, "handle-ioctl", G_CALLBACK(&State::OnIoctl), this);
    std::sort(options.controls.begin(), options.controls.end(),
              [](const EmulatedControl& a, const EmulatedControl& b) { return a.id < b.id; });
    PlugIn();
    pacer = std::thread([this] { Pace(); });
  }

  ~State() {
    {
      const std::lock_guard lock(mutex);
      quit = true;
    }
    changed.notify_all();
    pacer.join();
    if (plugged) umockdev_testbed_detach_ioctl(testbed, Node().c_str(), nullptr);
    g_object_unref(handler);
    g_object_unref(testbed);
    ReleaseMemory();
    if (file >= 0) close(file);
  }

  std::string Node() const { return "/dev/" + options.node; }
  std::string FileOfNode() const {
    char* root = umockdev_testbed_get_root_dir(testbed);
    const std::string path = root + Node();
    g_free(root);
    return path;
  }

  void PlugIn() {
    const std::string number = options.node.substr(5);
    const std::string usb =
        "/devices/pci0000:00/0000:00:14.0/usb1/1-" + std::to_string(1 + std::stoi(number));
    // A node with contents is a plain file, which can be mapped.
    const std::string serial = options.serial.empty() ? "" : fmt::format("A: serial={}\\n\n", options.serial);
    const std::string description = fmt::format(
        "P: {0}\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nA: idVendor=1d6b\\n\nA: idProduct=0104\\n\n"
        "A: manufacturer={1}\\n\nA: product={2}\\n\n{3}\n"
        "P: {0}/1-1:1.0/video4linux/{4}\nN: {4}=00\nE: DEVNAME=/dev/{4}\nE: MAJOR=81\nE: MINOR={5}\n"
        "E: SUBSYSTEM=video4linux\nA: name={2}\\n\nA: dev=81:{5}\\n\nA: index=0\\n\n",
        usb, options.maker, options.card, serial, options.node, number);
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(testbed, description.c_str(), &error))
      throw std::runtime_error("umockdev: " + Taken(error));
    syspaths = {"/sys" + usb + "/1-1:1.0/video4linux/" + options.node, "/sys" + usb};
    umockdev_testbed_disable(testbed);
    file = open(FileOfNode().c_str(), O_RDWR | O_CLOEXEC);
    umockdev_testbed_enable(testbed);
    if (file < 0) throw std::runtime_error("the emulated node cannot be opened");
    if (!umockdev_testbed_attach_ioctl(testbed, Node().c_str(), handler, &error))
      throw std::runtime_error("umockdev: " + Taken(error));
    const std::lock_guard lock(mutex);
    plugged = true;
  }

  void Unplug() {
    {
      const std::lock_guard lock(mutex);
      plugged = false;
      streaming = false;
    }
    umockdev_testbed_detach_ioctl(testbed, Node().c_str(), nullptr);
    for (const std::string& path : syspaths) umockdev_testbed_remove_device(testbed, path.c_str());
    umockdev_testbed_disable(testbed);
    unlink(FileOfNode().c_str());
    umockdev_testbed_enable(testbed);
    const std::lock_guard lock(mutex);
    ReleaseMemory();
    close(file);
    file = -1;
  }

  void ReleaseMemory() {
    if (memory_map) munmap(memory_map, memory_size);
    memory_map = nullptr;
  }

  // A frame in its time, from streaming's start to its end.
  void Pace() {
    std::unique_lock lock(mutex);
    while (!quit) {
      if (!streaming) {
        changed.wait(lock, [&] { return quit || streaming; });
        continue;
      }
      due += std::chrono::microseconds(1'000'000 / std::max<std::uint32_t>(fps, 1));
      if (changed.wait_until(lock, due, [&] { return quit || !streaming; })) continue;
      Expose();
    }
  }

  EmulatedControl* Find(std::uint32_t id) {
    for (EmulatedControl& control : options.controls)
      if (control.id == id) return &control;
    return nullptr;
  }

  bool AutoExposes() {
    const EmulatedControl* mode_control = Find(V4L2_CID_EXPOSURE_AUTO);
    return mode_control && mode_control->value != V4L2_EXPOSURE_MANUAL;
  }

  void Expose() {
    if (held_back) return;
    const std::uint32_t number = sequence++;
    if (AutoExposes())
      if (EmulatedControl* time = Find(V4L2_CID_EXPOSURE_ABSOLUTE))
        time->value = std::min(time->value + 1, time->max);
    const EmulatedFate fate = options.fate ? options.fate(number) : EmulatedFate::kArrives;
    if (skip > 0 || fate == EmulatedFate::kLost) {
      if (skip > 0) --skip;
      return;
    }
    if (queued.empty()) return;  // the program is slow: the kernel loses the frame
    v4l2_buffer buffer = queued.front();
    queued.pop_front();
    std::vector<std::uint8_t> pixels = Pixels(number);
    if (fate == EmulatedFate::kCut) pixels.resize(pixels.size() / 2);
    buffer.sequence = number;
    buffer.bytesused = static_cast<std::uint32_t>(pixels.size());
    buffer.field = V4L2_FIELD_NONE;
    buffer.flags = options.timestamp_flags;
    if (damage > 0 || fate == EmulatedFate::kDamaged) {
      if (damage > 0) --damage;
      buffer.flags |= V4L2_BUF_FLAG_ERROR;
    }
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    buffer.timestamp = {now.tv_sec, now.tv_nsec / 1000};
    if (buffer.memory == V4L2_MEMORY_MMAP) {
      std::memcpy(memory_map + buffer.index * Stride(), pixels.data(), std::min(pixels.size(), Stride()));
      buffer.m.offset = static_cast<std::uint32_t>(buffer.index * Stride());
    }
    done.push_back({buffer, pixels});
  }

  std::vector<std::uint8_t> Pixels(std::uint32_t number) const {
    const std::vector<std::uint8_t> dense =
        options.render ? options.render(mode, number) : Ramp(mode, number);
    const std::size_t row = RowBytes(mode);
    if (options.row_padding == 0 || row == 0) return dense;
    std::vector<std::uint8_t> padded;
    for (std::size_t at = 0; at < dense.size(); at += row) {
      padded.insert(padded.end(), dense.begin() + static_cast<std::ptrdiff_t>(at),
                    dense.begin() + static_cast<std::ptrdiff_t>(at + row));
      padded.insert(padded.end(), options.row_padding, 0xEE);
    }
    return padded;
  }

  std::size_t ImageBytes() const {
    if (mode.fourcc == V4L2_PIX_FMT_MJPEG) return 2 * mode.width * mode.height;
    const std::size_t rows = mode.fourcc == V4L2_PIX_FMT_NV12 ? mode.height * 3 / 2 : mode.height;
    return (RowBytes(mode) + options.row_padding) * rows;
  }
  std::size_t Stride() const { return (ImageBytes() + 4095) / 4096 * 4096; }

  static gboolean OnIoctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer self) {
    auto* state = static_cast<State*>(self);
    const std::lock_guard lock(state->mutex);
    int error = state->plugged ? ENOTTY : ENODEV;
    if (state->plugged) {
      try {
        error = state->Answer(client, umockdev_ioctl_client_get_request(client) & 0xFFFFFFFFu);
      } catch (const std::exception&) {
        error = EFAULT;
      }
    }
    umockdev_ioctl_client_complete(client, error == 0 ? 0 : -1, error);
    return TRUE;
  }

  // The caller's structure; what is changed in it goes back when the call is complete.
  template <typename T>
  static T& Argument(UMockdevIoctlClient* client, UMockdevIoctlData** whole = nullptr) {
    UMockdevIoctlData* pointer = umockdev_ioctl_client_get_arg(client);
    GError* error = nullptr;
    UMockdevIoctlData* data = umockdev_ioctl_data_resolve(pointer, 0, sizeof(T), &error);
    if (!data) throw std::runtime_error(Taken(error));
    if (whole) *whole = data;
    return *reinterpret_cast<T*>(data->data);  // lives as long as the call
  }

  int Answer(UMockdevIoctlClient* client, unsigned long request) {
    switch (request) {
      case VIDIOC_QUERYCAP:
        return Capability(Argument<v4l2_capability>(client));
      case VIDIOC_ENUM_FMT:
        return Format(Argument<v4l2_fmtdesc>(client));
      case VIDIOC_ENUM_FRAMESIZES:
        return FrameSize(Argument<v4l2_frmsizeenum>(client));
      case VIDIOC_ENUM_FRAMEINTERVALS:
        return Interval(Argument<v4l2_frmivalenum>(client));
      case VIDIOC_G_FMT:
        Describe(Argument<v4l2_format>(client).fmt.pix);
        return 0;
      case VIDIOC_S_FMT:
        return SetFormat(Argument<v4l2_format>(client));
      case VIDIOC_G_PARM:
      case VIDIOC_S_PARM:
        return Rate(Argument<v4l2_streamparm>(client), request == VIDIOC_S_PARM);
      case VIDIOC_QUERYCTRL:
        return QueryControl(Argument<v4l2_queryctrl>(client));
      case VIDIOC_QUERYMENU:
        return QueryMenu(Argument<v4l2_querymenu>(client));
      case VIDIOC_G_CTRL:
      case VIDIOC_S_CTRL:
        return AccessControl(Argument<v4l2_control>(client), request == VIDIOC_S_CTRL);
      case VIDIOC_REQBUFS:
        return RequestBuffers(Argument<v4l2_requestbuffers>(client));
      case VIDIOC_QUERYBUF: {
        auto& buffer = Argument<v4l2_buffer>(client);
        if (buffer.index >= buffers) return EINVAL;
        buffer.length = static_cast<std::uint32_t>(Stride());
        buffer.m.offset = static_cast<std::uint32_t>(buffer.index * Stride());
        return 0;
      }
      case VIDIOC_QBUF: {
        const auto& buffer = Argument<v4l2_buffer>(client);
        if (buffer.index >= buffers) return EINVAL;
        queued.push_back(buffer);
        return 0;
      }
      case VIDIOC_DQBUF:
        return Dequeue(client);
      case VIDIOC_STREAMON:
        streaming = true;
        due = Clock::now();
        changed.notify_all();
        return 0;
      case VIDIOC_STREAMOFF:
        streaming = false;
        queued.clear();
        done.clear();
        changed.notify_all();
        return 0;
      default:
        return ENOTTY;
    }
  }

  int Capability(v4l2_capability& capability) const {
    capability = {};
    CopyText("uvcvideo", capability.driver, sizeof capability.driver);
    CopyText(options.card, capability.card, sizeof capability.card);
    CopyText("usb-0000:00:14.0-" + std::to_string(1 + std::stoi(options.node.substr(5))), capability.bus_info,
             sizeof capability.bus_info);
    capability.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_EXT_PIX_FORMAT;
    capability.capabilities = capability.device_caps | V4L2_CAP_DEVICE_CAPS;
    return 0;
  }

  int Format(v4l2_fmtdesc& description) const {
    std::vector<std::uint32_t> formats;
    for (const EmulatedMode& one : options.modes)
      if (std::find(formats.begin(), formats.end(), one.fourcc) == formats.end())
        formats.push_back(one.fourcc);
    if (description.index >= formats.size()) return EINVAL;
    description.flags = 0;
    description.pixelformat = formats[description.index];
    return 0;
  }

  int FrameSize(v4l2_frmsizeenum& size) const {
    std::uint32_t index = 0;
    for (const EmulatedMode& one : options.modes) {
      if (one.fourcc != size.pixel_format || index++ != size.index) continue;
      size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
      size.discrete = {one.width, one.height};
      return 0;
    }
    return EINVAL;
  }

  int Interval(v4l2_frmivalenum& interval) const {
    for (const EmulatedMode& one : options.modes) {
      if (one.fourcc != interval.pixel_format || one.width != interval.width || one.height != interval.height)
        continue;
      if (interval.index >= one.fps.size()) return EINVAL;
      interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
      interval.discrete = {1, one.fps[interval.index]};
      return 0;
    }
    return EINVAL;
  }

  void Describe(v4l2_pix_format& pixels) const {
    pixels.width = mode.width;
    pixels.height = mode.height;
    pixels.pixelformat = mode.fourcc;
    pixels.field = V4L2_FIELD_NONE;
    pixels.bytesperline = mode.fourcc == V4L2_PIX_FMT_MJPEG
                              ? 0
                              : static_cast<std::uint32_t>(RowBytes(mode)) + options.row_padding;
    pixels.sizeimage = static_cast<std::uint32_t>(ImageBytes());
    pixels.colorspace = options.colorspace;
    pixels.quantization = options.quantization;
    pixels.ycbcr_enc = V4L2_YCBCR_ENC_DEFAULT;
    pixels.xfer_func = V4L2_XFER_FUNC_DEFAULT;
  }

  int SetFormat(v4l2_format& format) {
    if (busy || streaming) return EBUSY;
    for (const EmulatedMode& one : options.modes)
      if (one.fourcc == format.fmt.pix.pixelformat && one.width == format.fmt.pix.width &&
          one.height == format.fmt.pix.height)
        mode = one;
    fps = mode.fps.front();
    Describe(format.fmt.pix);
    return 0;
  }

  int Rate(v4l2_streamparm& rate, bool set) {
    const v4l2_fract wanted = rate.parm.capture.timeperframe;
    if (set && wanted.numerator > 0) {
      const double wanted_fps = static_cast<double>(wanted.denominator) / wanted.numerator;
      for (const std::uint32_t offered : mode.fps)
        if (std::abs(offered - wanted_fps) < std::abs(fps - wanted_fps)) fps = offered;
    }
    rate.parm = {};
    rate.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
    rate.parm.capture.timeperframe = {1, fps};
    return 0;
  }

  int QueryControl(v4l2_queryctrl& query) {
    const bool next = query.id & V4L2_CTRL_FLAG_NEXT_CTRL;
    const std::uint32_t id = query.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
    for (const EmulatedControl& control : options.controls) {
      if (next ? control.id <= id : control.id != id) continue;
      query = {};
      query.id = control.id;
      query.type = control.type;
      CopyText(control.title, query.name, sizeof query.name);
      query.minimum = control.min;
      query.maximum = control.max;
      query.step = control.step;
      query.default_value = control.value;
      if (control.id == V4L2_CID_EXPOSURE_ABSOLUTE && AutoExposes()) query.flags |= V4L2_CTRL_FLAG_INACTIVE;
      return 0;
    }
    return EINVAL;
  }

  int QueryMenu(v4l2_querymenu& query) {
    const EmulatedControl* control = Find(query.id);
    if (!control) return EINVAL;
    const auto entry = control->menu.find(static_cast<int>(query.index));
    if (entry == control->menu.end()) return EINVAL;
    CopyText(entry->second, query.name, sizeof query.name);
    return 0;
  }

  int AccessControl(v4l2_control& asked, bool set) {
    EmulatedControl* control = Find(asked.id);
    if (!control) return EINVAL;
    if (!set) {
      asked.value = control->value;
      return 0;
    }
    if (control->refuses) return control->refuses;
    if (control->id == V4L2_CID_EXPOSURE_ABSOLUTE && AutoExposes()) return EACCES;
    if (asked.value < control->min || asked.value > control->max) return ERANGE;
    control->value = asked.value;
    return 0;
  }

  int RequestBuffers(v4l2_requestbuffers& request) {
    if (busy) return EBUSY;
    if (request.memory != V4L2_MEMORY_MMAP &&
        !(request.memory == V4L2_MEMORY_USERPTR && options.takes_user_pointers))
      return EINVAL;
    request.count = std::min(request.count, kMostBuffers);
    buffers = request.count;
    if (buffers > 0) memory = request.memory;
    queued.clear();
    done.clear();
    ReleaseMemory();
    if (request.memory != V4L2_MEMORY_MMAP || buffers == 0) return 0;
    memory_size = Stride() * buffers;
    if (ftruncate(file, static_cast<off_t>(memory_size)) != 0) return ENOMEM;
    void* mapped = mmap(nullptr, memory_size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (mapped == MAP_FAILED) return ENOMEM;
    memory_map = static_cast<std::uint8_t*>(mapped);
    return 0;
  }

  int Dequeue(UMockdevIoctlClient* client) {
    if (!streaming) return EINVAL;
    if (done.empty()) return EAGAIN;
    UMockdevIoctlData* whole = nullptr;
    auto& header = Argument<v4l2_buffer>(client, &whole);
    const auto [buffer, pixels] = std::move(done.front());
    done.pop_front();
    header = buffer;
    if (buffer.memory != V4L2_MEMORY_USERPTR) return 0;
    GError* error = nullptr;
    UMockdevIoctlData* memory_of_client =
        umockdev_ioctl_data_resolve(whole, G_STRUCT_OFFSET(v4l2_buffer, m), pixels.size(), &error);
    if (!memory_of_client) throw std::runtime_error(Taken(error));
    std::memcpy(memory_of_client->data, pixels.data(), pixels.size());
    return 0;
  }

  struct Done {
    v4l2_buffer buffer;
    std::vector<std::uint8_t> pixels;
  };

  V4l2CameraOptions options;
  EmulatedMode mode;
  std::uint32_t fps = 30;
  UMockdevTestbed* testbed = nullptr;
  UMockdevIoctlBase* handler = nullptr;
  std::vector<std::string> syspaths;
  int file = -1;
  std::thread pacer;

  mutable std::mutex mutex;
  std::condition_variable changed;
  bool quit = false, plugged = false, streaming = false, busy = false, held_back = false;
  std::uint32_t sequence = 0, skip = 0, damage = 0, buffers = 0, memory = 0;
  std::uint8_t* memory_map = nullptr;
  std::size_t memory_size = 0;
  std::deque<v4l2_buffer> queued;
  std::deque<Done> done;
  Clock::time_point due;
};

EmulatedV4l2Camera::EmulatedV4l2Camera(const V4l2CameraOptions& options)
    : state_(std::make_unique<State>(options)) {}
EmulatedV4l2Camera::~EmulatedV4l2Camera() = default;

void EmulatedV4l2Camera::Unplug() { state_->Unplug(); }
void EmulatedV4l2Camera::PlugIn() { state_->PlugIn(); }

void EmulatedV4l2Camera::SkipFrames(std::uint32_t count) {
  const std::lock_guard lock(state_->mutex);
  state_->skip += count;
}
void EmulatedV4l2Camera::DamageFrames(std::uint32_t count) {
  const std::lock_guard lock(state_->mutex);
  state_->damage += count;
}
void EmulatedV4l2Camera::HoldBack(bool hold) {
  const std::lock_guard lock(state_->mutex);
  state_->held_back = hold;
}
void EmulatedV4l2Camera::SetBusy(bool busy) {
  const std::lock_guard lock(state_->mutex);
  state_->busy = busy;
}
int EmulatedV4l2Camera::Control(std::uint32_t id) const {
  const std::lock_guard lock(state_->mutex);
  const EmulatedControl* control = state_->Find(id);
  return control ? control->value : -1;
}
bool EmulatedV4l2Camera::IsStreaming() const {
  const std::lock_guard lock(state_->mutex);
  return state_->streaming;
}
std::uint32_t EmulatedV4l2Camera::Memory() const {
  const std::lock_guard lock(state_->mutex);
  return state_->memory;
}

}  // namespace ulf::test

#include "tests/support/usb/u3v_camera.h"

#include <fmt/core.h>
#include <time.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <fstream>
#include <iterator>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

namespace ulf::test {
namespace {

using Clock = std::chrono::steady_clock;

// ---- bytes ----

template <typename T>
void Put(Bytes& bytes, T value) {
  const auto* from = reinterpret_cast<const std::uint8_t*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof value);
}
template <typename T>
void PutAt(Bytes& bytes, std::size_t at, T value) {
  if (bytes.size() < at + sizeof value) bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}
template <typename T>
T GetAt(const Bytes& bytes, std::size_t at) {
  T value{};
  if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}
void PutText(Bytes& bytes, std::size_t at, const std::string& text) {
  if (bytes.size() < at + 64) bytes.resize(at + 64);
  std::memcpy(bytes.data() + at, text.data(), std::min<std::size_t>(text.size(), 63));
}

// An archive of one deflated file, as cameras store their description.
Bytes Zipped(const std::string& name, const std::string& text) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib");
  Bytes packed(deflateBound(&stream, static_cast<uLong>(text.size())));
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = packed.data();
  stream.avail_out = static_cast<uInt>(packed.size());
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) throw std::runtime_error("zlib");
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  const auto check = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size())));
  const auto common = [&](Bytes& to) {  // version, flags, method, time, date, check, sizes, lengths
    for (const std::uint16_t half : {20, 0, 8, 0, 0x21}) Put(to, half);
    Put(to, check);
    Put(to, static_cast<std::uint32_t>(packed.size()));
    Put(to, static_cast<std::uint32_t>(text.size()));
    Put(to, static_cast<std::uint16_t>(name.size()));
    Put(to, std::uint16_t{0});
  };
  Bytes zip;
  Put(zip, std::uint32_t{0x04034b50});
  common(zip);
  zip.insert(zip.end(), name.begin(), name.end());
  zip.insert(zip.end(), packed.begin(), packed.end());
  const auto directory_at = static_cast<std::uint32_t>(zip.size());
  Put(zip, std::uint32_t{0x02014b50});
  Put(zip, std::uint16_t{20});
  common(zip);
  for (const std::uint16_t half : {0, 0, 0}) Put(zip, half);  // comment, disk, attributes
  Put(zip, std::uint32_t{0});
  Put(zip, std::uint32_t{0});  // where the file begins
  zip.insert(zip.end(), name.begin(), name.end());
  const auto directory_bytes = static_cast<std::uint32_t>(zip.size()) - directory_at;
  Put(zip, std::uint32_t{0x06054b50});
  for (const std::uint16_t half : {0, 0, 1, 1}) Put(zip, half);
  Put(zip, directory_bytes);
  Put(zip, directory_at);
  Put(zip, std::uint16_t{0});
  return zip;
}

// ---- what a USB3 Vision camera is on the bus ----

constexpr std::uint8_t kMiscellaneous = 0xEF, kVision = 0x05;
constexpr std::uint8_t kEventIn = 0x82;

Bytes Descriptors(const U3vOptions& options) {
  const bool super = options.megabits >= 5000;
  Bytes device{18, 1};
  Put(device, static_cast<std::uint16_t>(super ? 0x0300 : 0x0210));
  for (const int byte : {0xEF, 0x02, 0x01, super ? 9 : 64}) device.push_back(static_cast<std::uint8_t>(byte));
  Put(device, std::uint16_t{0x2676});
  Put(device, std::uint16_t{0xba02});
  Put(device, std::uint16_t{0x0100});
  for (const std::uint8_t byte : {1, 2, 3, 1}) device.push_back(byte);  // strings; one configuration
  Bytes parts;
  int interfaces = 0;
  const auto interface = [&](std::uint8_t protocol, std::vector<std::uint8_t> endpoints) {
    for (const int byte : {9, 4, interfaces++, 0, static_cast<int>(endpoints.size()), int{kMiscellaneous},
                           int{kVision}, int{protocol}, 0})
      parts.push_back(static_cast<std::uint8_t>(byte));
    for (const std::uint8_t endpoint : endpoints) {
      for (const std::uint8_t byte : {std::uint8_t{7}, std::uint8_t{5}, endpoint, std::uint8_t{2}})
        parts.push_back(byte);
      Put(parts, static_cast<std::uint16_t>(super ? 1024 : 512));
      parts.push_back(0);
      if (super)
        for (const std::uint8_t byte : {6, 48, 15, 0, 0, 0}) parts.push_back(byte);
    }
  };
  for (const int byte : {8, 11, 0, options.event_interface ? 3 : 2, 0xEF, 5, 0, 0})  // belong together
    parts.push_back(static_cast<std::uint8_t>(byte));
  interface(0, {EmulatedU3vCamera::kControlIn, EmulatedU3vCamera::kControlOut});
  // What makes it a USB3 Vision camera: the versions of its protocols, the strings of its own number, maker,
  // model, family, version, maker's words, serial and user's name, and the speeds that it can.
  parts.insert(parts.begin() + 8 + 9, {20, 0x24, 1, 0, 0, 1, 0, 0, 0, 1, 0, 4, 1, 2, 0, 0, 0, 3, 0, 0x0C});
  if (options.event_interface) interface(1, {kEventIn});
  interface(2, {EmulatedU3vCamera::kStreamIn});
  Bytes configuration{9, 2};
  Put(configuration, static_cast<std::uint16_t>(9 + parts.size()));
  for (const int byte : {interfaces, 1, 0, 0x80, super ? 112 : 250})
    configuration.push_back(static_cast<std::uint8_t>(byte));
  device.insert(device.end(), configuration.begin(), configuration.end());
  device.insert(device.end(), parts.begin(), parts.end());
  return device;
}

UsbIdentity IdentityOf(const U3vOptions& options) {
  UsbIdentity identity{
      .maker = options.maker,
      .model = options.model,
      .serial = options.serial,
      .more_strings = {fmt::format("2676{:08X}", std::hash<std::string>{}(options.serial) & 0xFFFFFFFFu)},
      .vendor_id = 0x2676,
      .product_id = 0xba02,
      .port = options.port,
      .megabits = options.megabits,
      .klass = 0xEF,
      .subclass = 2,
      .protocol = 1,
      .interfaces = {},
      .descriptors = Descriptors(options)};
  for (const int protocol : {0, 1, 2})
    if (protocol != 1 || options.event_interface)
      identity.interfaces.push_back(
          {static_cast<int>(identity.interfaces.size()), kMiscellaneous, kVision, protocol});
  return identity;
}

// ---- registers ----

// Of the bootstrap maps: ABRM at 0, SBRM, SIRM, EIRM, and the manifest.
constexpr std::uint64_t kManifest = 0x400, kSbrm = 0x1000, kSirm = 0x1100, kEirm = 0x1200, kXml = 0x10000;
constexpr std::uint64_t kHeight = 0x2004, kOffsetX = 0x2008, kOffsetY = 0x200c, kPixelFormat = 0x2010,
                        kAcquisition = 0x2018, kTriggerSource = 0x2020, kChunkEnable = 0x2034,
                        kThroughputMode = 0x2078, kPayload = 0x2080, kSensorWidth = 0x2084,
                        kSensorHeight = 0x2088;
constexpr int kMostTransfer = 1024;       // of a command and an answer
constexpr double kHighSpeedBytes = 40e6;  // a second, what USB 2 really carries
// Frames that the camera itself can hold while the host does not ask.
constexpr std::size_t kOwnMemory = 2, kTransfersOfFrame = 3;

// ---- the control protocol ----

#pragma pack(push, 1)
struct Command {
  std::uint32_t magic;
  std::uint16_t flags, command, size, id;
};
#pragma pack(pop)
constexpr std::uint32_t kControlMagic = 0x43563355, kLeaderMagic = 0x4C563355, kTrailerMagic = 0x54563355;
constexpr std::uint16_t kReadMemory = 0x0800, kWriteMemory = 0x0802, kPendingAck = 0x0805;
constexpr std::uint16_t kSuccess = 0, kInvalidAddress = 0x8003, kAccessDenied = 0x8006;
constexpr std::uint16_t kDataOverrun = 0xA002;  // of a trailer: a frame that the camera could not hold
constexpr std::uint16_t kPendingMs = 300;

std::uint64_t Nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000u + static_cast<std::uint64_t>(now.tv_nsec);
}

int BitsOf(std::uint32_t pixel_format) { return static_cast<int>((pixel_format >> 16) & 0xFF); }

}  // namespace

std::size_t EmulatedU3vCamera::ImageBytes(const U3vFrame& frame) {
  return (std::size_t{frame.width} * frame.height * static_cast<std::size_t>(BitsOf(frame.pixel_format)) +
          7) /
         8;
}

Bytes EmulatedU3vCamera::Ramp(const U3vFrame& frame) {
  const int bits = BitsOf(frame.pixel_format);
  Bytes bytes(ImageBytes(frame));
  const std::uint32_t most = bits == 8 ? 0xFF : bits == 10 ? 0x3FF : 0xFFF;
  std::size_t at_bit = 0;
  for (std::uint32_t y = 0; y < frame.height; ++y)
    for (std::uint32_t x = 0; x < frame.width; ++x, at_bit += static_cast<std::size_t>(bits)) {
      const std::uint32_t value =
          (3 * (x + frame.x) + 5 * (y + frame.y) + static_cast<std::uint32_t>(frame.id)) & most;
      if (bits == 8) {
        bytes[at_bit / 8] = static_cast<std::uint8_t>(value);
        continue;
      }
      for (std::size_t byte = at_bit / 8, shifted = std::size_t{value} << (at_bit % 8); shifted > 0;
           ++byte, shifted >>= 8)
        bytes[byte] = static_cast<std::uint8_t>(bytes[byte] | (shifted & 0xFF));
    }
  return bytes;
}

struct EmulatedU3vCamera::State {
  explicit State(const U3vOptions& chosen) : options(chosen) {
    std::ifstream file(U3V_DESCRIPTION, std::ios::binary);
    std::string xml{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (xml.empty()) throw std::runtime_error("no description of the emulated camera");
    for (const auto& [from, to] : options.edits) {
      const std::size_t at = xml.find(from);
      if (at == std::string::npos) throw std::runtime_error("nothing to edit: " + from);
      xml.replace(at, from.size(), to);
    }
    description = options.zipped ? Zipped("u3v_camera.xml", xml) : Bytes(xml.begin(), xml.end());
    PowerUp();
    node = std::make_unique<UsbNode>(IdentityOf(options), [this](std::uint8_t endpoint, const Bytes& data) {
      if (endpoint == kControlOut) Obey(data);
    });
    worker = std::thread([this] { Work(); });
  }
  ~State() {
    {
      const std::lock_guard lock(mutex);
      quit = true;
    }
    changed.notify_all();
    worker.join();
    node.reset();
  }

  void PowerUp() {
    registers.assign(kXml, 0);
    PutAt(registers, 0x0000, std::uint32_t{0x00010000});
    PutText(registers, 0x0004, options.maker);
    PutText(registers, 0x0044, options.model);
    PutText(registers, 0x00c4, "1.0");
    PutText(registers, 0x0144, options.serial);
    PutAt(registers, 0x01c4, std::uint64_t{1});    // it has a name of its user
    PutAt(registers, 0x01cc, std::uint32_t{100});  // answers within so many ms
    PutAt(registers, 0x01d0, kManifest);
    PutAt(registers, 0x01d8, kSbrm);
    PutAt(registers, 0x01fc, std::uint64_t{1});
    PutAt(registers, kManifest, std::uint64_t{1});
    PutAt(registers, kManifest + 8, std::uint32_t{0x01000000});
    PutAt(registers, kManifest + 12, std::uint32_t{(options.zipped ? 1u << 10 : 0) | 1u << 24 | 1u << 16});
    PutAt(registers, kManifest + 16, kXml);
    PutAt(registers, kManifest + 24, std::uint64_t{description.size()});
    PutAt(registers, kSbrm, std::uint32_t{0x00010000});
    PutAt(registers, kSbrm + 0x04, std::uint64_t{options.event_interface ? 3u : 1u});
    PutAt(registers, kSbrm + 0x14, std::uint32_t{kMostTransfer});
    PutAt(registers, kSbrm + 0x18, std::uint32_t{kMostTransfer});
    PutAt(registers, kSbrm + 0x1c, std::uint32_t{1});
    PutAt(registers, kSbrm + 0x20, kSirm);
    PutAt(registers, kSbrm + 0x28, std::uint32_t{0x30});
    PutAt(registers, kSbrm + 0x2c, options.event_interface ? kEirm : std::uint64_t{0});
    PutAt(registers, kSbrm + 0x34, std::uint32_t{0x0c});
    PutAt(registers, kSpeed, std::uint32_t{options.megabits >= 5000 ? 8u : 4u});
    PutAt(registers, kSirm, static_cast<std::uint32_t>(options.alignment_bits) << 24);
    PutAt(registers, kSirm + 0x10, std::uint32_t{1024});
    PutAt(registers, kSirm + 0x14, std::uint32_t{1024});
    PutAt(registers, kSensorWidth, options.sensor_width);
    PutAt(registers, kSensorHeight, options.sensor_height);
    PutAt(registers, kWidth, options.sensor_width);
    PutAt(registers, kHeight, options.sensor_height);
    PutAt(registers, kPixelFormat, std::uint32_t{0x01080001});
    PutAt(registers, kTriggerSource, std::uint32_t{1});
    PutAt(registers, kExposure, 5000.0);
    PutAt(registers, kFrameRate, 100.0);
    PutAt(registers, kThroughputLimit, std::uint32_t{400'000'000});
    registers.insert(registers.end(), description.begin(), description.end());
    acquiring = false;
    triggers = 0;
    next_id = 0;
    CountPayload();
  }

  std::uint32_t Word(std::uint64_t address) const { return GetAt<std::uint32_t>(registers, address); }
  double Real(std::uint64_t address) const { return GetAt<double>(registers, address); }
  bool Streams() const { return acquiring && (Word(kStreamControl) & 1); }
  bool ChunkIsOn(std::size_t chunk) const {
    return Word(kChunkMode) != 0 && Word(kChunkEnable + 4 * chunk) != 0;
  }
  U3vFrame FrameNow() const {
    return {next_id, Word(kWidth), Word(kHeight), Word(kOffsetX), Word(kOffsetY), Word(kPixelFormat)};
  }
  void CountPayload() {
    std::size_t bytes = EmulatedU3vCamera::ImageBytes(FrameNow());
    if (Word(kChunkMode) != 0) bytes += 8;
    for (std::size_t chunk = 0; chunk < 4; ++chunk)
      if (ChunkIsOn(chunk)) bytes += 16;
    PutAt(registers, kPayload, static_cast<std::uint32_t>(bytes));
    PutAt(registers, kSirm + 0x08, std::uint64_t{bytes});
  }

  // ---- control ----

  void Obey(const Bytes& data) {
    const std::lock_guard lock(mutex);
    ++requests;
    if (data.size() < sizeof(Command) + 8) return;
    const auto command = GetAt<Command>(data, 0);
    const auto address = GetAt<std::uint64_t>(data, sizeof(Command));
    const bool write = command.command == kWriteMemory;
    if (command.magic != kControlMagic || (!write && command.command != kReadMemory)) return;
    U3vAnswer how = options.answer ? options.answer(address, write) : U3vAnswer::kAnswers;
    if (how == U3vAnswer::kSilent) return;
    Bytes payload;
    std::uint16_t status = how == U3vAnswer::kRefuses ? kAccessDenied : kSuccess;
    if (status == kSuccess && write) {
      const std::size_t bytes = data.size() - sizeof(Command) - 8;
      if (address + bytes > kXml)
        status = kInvalidAddress;
      else
        Write(address, data.data() + sizeof(Command) + 8, bytes);
      Put(payload, std::uint16_t{0});
      Put(payload, static_cast<std::uint16_t>(bytes));
    } else if (status == kSuccess) {
      const auto bytes = GetAt<std::uint16_t>(data, sizeof(Command) + 10);
      if (address + bytes > registers.size())
        status = kInvalidAddress;
      else
        payload.assign(registers.begin() + static_cast<std::ptrdiff_t>(address),
                       registers.begin() + static_cast<std::ptrdiff_t>(address + bytes));
    }
    if (status != kSuccess) payload.clear();
    const auto packet = [&](std::uint16_t result, std::uint16_t kind, std::uint16_t id, const Bytes& more) {
      Bytes bytes;
      Put(bytes, Command{kControlMagic, result, kind, static_cast<std::uint16_t>(more.size()), id});
      bytes.insert(bytes.end(), more.begin(), more.end());
      return bytes;
    };
    if (how == U3vAnswer::kOtherFirst)
      node->Send(kControlIn, packet(kSuccess, static_cast<std::uint16_t>(command.command + 1),
                                    static_cast<std::uint16_t>(command.id - 7), payload));
    Bytes answer = packet(status, static_cast<std::uint16_t>(command.command + 1), command.id, payload);
    if (how != U3vAnswer::kPending) return node->Send(kControlIn, std::move(answer));
    Bytes longer;
    Put(longer, std::uint16_t{0});
    Put(longer, std::uint16_t{2 * kPendingMs});
    node->Send(kControlIn, packet(kSuccess, kPendingAck, command.id, longer));
    later.emplace_back(Clock::now() + std::chrono::milliseconds(kPendingMs), std::move(answer));
    changed.notify_all();
  }

  void Write(std::uint64_t address, const std::uint8_t* from, std::size_t bytes) {
    std::memcpy(registers.data() + address, from, bytes);
    if (address == 0x01f8) PutAt(registers, 0x01f0, Nanoseconds());
    if (address == kAcquisition) {
      acquiring = Word(kAcquisition) != 0;
      next_id = acquiring ? 0 : next_id;
      due = Clock::now();
    }
    if (address == kStreamControl && !(Word(kStreamControl) & 1)) node->Forget(kStreamIn);
    if (address == kTriggerSoftware && Word(kTriggerMode) != 0 && Word(kTriggerSource) == 1) ++triggers;
    CountPayload();
    changed.notify_all();
  }

  // ---- streaming ----

  double PeriodS() const {
    const double payload = Word(kPayload);
    double period = std::max(1 / std::max(Real(kFrameRate), 0.1), 1e-6 * Real(kExposure));
    if (Word(kThroughputMode) != 0) period = std::max(period, payload / Word(kThroughputLimit));
    if (options.megabits < 5000) period = std::max(period, payload / kHighSpeedBytes);
    return period;
  }

  void Work() {
    std::unique_lock lock(mutex);
    while (!quit) {
      while (!later.empty() && later.front().first <= Clock::now()) {
        node->Send(kControlIn, std::move(later.front().second));
        later.pop_front();
      }
      const auto wake = later.empty() ? Clock::now() + std::chrono::seconds(1) : later.front().first;
      const bool triggered = Word(kTriggerMode) != 0;
      if (!Streams() || held_back || (triggered && triggers == 0)) {
        changed.wait_until(lock, wake);
        continue;
      }
      if (!triggered && Clock::now() < due) {
        changed.wait_until(lock, std::min(due, wake));
        continue;
      }
      if (!options.keeps_pace) {
        lock.unlock();
        const bool wanted = node->AwaitWanted(kStreamIn, 0.05);
        lock.lock();
        if (!wanted || !Streams()) continue;
      }
      if (triggered)
        --triggers;
      else
        due += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(PeriodS()));
      if (!options.keeps_pace) due = std::max(due, Clock::now());
      Expose();
    }
  }

  void Expose() {
    const U3vFrame frame = FrameNow();
    ++next_id;
    ++exposed;
    const U3vFate fate = options.fate ? options.fate(frame.id) : U3vFate::kArrives;
    if (fate == U3vFate::kLost || node->Unsent(kStreamIn) > kOwnMemory * kTransfersOfFrame) return;
    const std::uint64_t now = Nanoseconds();
    Bytes pixels = options.render ? options.render(frame) : Ramp(frame);
    const bool with_chunks = Word(kChunkMode) != 0 && fate != U3vFate::kNoChunks;
    if (with_chunks) AppendChunks(pixels, frame, now);
    if (fate != U3vFate::kNoLeader) node->Send(kStreamIn, Leader(frame, now, with_chunks));
    const auto payload = std::make_shared<const Bytes>(std::move(pixels));
    const std::size_t whole = payload->size();
    SendPayload(payload, fate == U3vFate::kCut ? whole / 2 : whole);
    if (fate == U3vFate::kNoTrailer) return;
    Bytes trailer = Trailer(frame, whole);
    if (fate == U3vFate::kShortTrailer) trailer.resize(4);
    if (fate == U3vFate::kBadTrailer) PutAt(trailer, 16, kDataOverrun);
    node->Send(kStreamIn, std::move(trailer));
  }

  // In transfers of the sizes that the host has set.
  void SendPayload(const std::shared_ptr<const Bytes>& payload, std::size_t bytes) {
    std::vector<std::size_t> sizes(Word(kSirm + 0x20), Word(kSirm + 0x1c));
    sizes.push_back(Word(kSirm + 0x24));
    sizes.push_back(Word(kSirm + 0x28));
    std::size_t from = 0;
    for (const std::size_t size : sizes) {
      const std::size_t part = std::min(size, bytes - from);
      if (part == 0) continue;
      node->Send(kStreamIn, payload, from, part);
      from += part;
    }
  }

  static Bytes Leader(const U3vFrame& frame, std::uint64_t now, bool with_chunks) {
    Bytes leader;
    Put(leader, kLeaderMagic);
    Put(leader, std::uint16_t{0});
    Put(leader, std::uint16_t{52});
    Put(leader, frame.id);
    Put(leader, std::uint16_t{0});
    Put(leader, static_cast<std::uint16_t>(with_chunks ? 0x4001 : 0x0001));
    Put(leader, now);
    for (const std::uint32_t word : {frame.pixel_format, frame.width, frame.height, frame.x, frame.y})
      Put(leader, word);
    Put(leader, std::uint32_t{0});
    return leader;
  }
  static Bytes Trailer(const U3vFrame& frame, std::size_t bytes) {
    Bytes trailer;
    Put(trailer, kTrailerMagic);
    Put(trailer, std::uint16_t{0});
    Put(trailer, std::uint16_t{32});
    Put(trailer, frame.id);
    Put(trailer, std::uint32_t{0});
    Put(trailer, std::uint64_t{bytes});
    Put(trailer, frame.height);
    return trailer;
  }

  // Each chunk is followed by its number and its length; the picture is the first.
  void AppendChunks(Bytes& bytes, const U3vFrame& frame, std::uint64_t now) const {
    Put(bytes, std::uint32_t{1});
    Put(bytes, static_cast<std::uint32_t>(ImageBytes(frame)));
    for (std::size_t chunk = 0; chunk < 4; ++chunk) {
      if (!ChunkIsOn(chunk)) continue;
      if (chunk == 0) Put(bytes, Real(kExposure) + static_cast<double>(frame.id));  // told per frame
      if (chunk == 1) Put(bytes, Real(kGain) + 0.5 * static_cast<double>(frame.id % 4));
      if (chunk == 2) Put(bytes, std::uint64_t{frame.id + 1000});
      if (chunk == 3) Put(bytes, now);
      Put(bytes, static_cast<std::uint32_t>(0x1001 + chunk));
      Put(bytes, std::uint32_t{8});
    }
  }

  U3vOptions options;
  Bytes description;
  std::unique_ptr<UsbNode> node;
  std::thread worker;

  mutable std::mutex mutex;
  std::condition_variable changed;
  bool quit = false, acquiring = false, held_back = false;
  Bytes registers;
  std::deque<std::pair<Clock::time_point, Bytes>> later;
  std::uint64_t next_id = 0, exposed = 0, requests = 0;
  std::size_t triggers = 0;
  Clock::time_point due;
};

EmulatedU3vCamera::EmulatedU3vCamera(const U3vOptions& options) : state_(std::make_unique<State>(options)) {}
EmulatedU3vCamera::~EmulatedU3vCamera() = default;

UsbNode& EmulatedU3vCamera::Node() const { return *state_->node; }
void EmulatedU3vCamera::Unplug() {
  state_->node->Unplug();
  const std::lock_guard lock(state_->mutex);
  state_->PowerUp();
}
void EmulatedU3vCamera::PlugIn() { state_->node->PlugIn(); }
void EmulatedU3vCamera::StallStream() { state_->node->Stall(kStreamIn); }
void EmulatedU3vCamera::HoldBack(bool hold) {
  const std::lock_guard lock(state_->mutex);
  state_->held_back = hold;
  state_->due = Clock::now();
  state_->changed.notify_all();
}
void EmulatedU3vCamera::Fate(std::function<U3vFate(std::uint64_t)> fate) {
  const std::lock_guard lock(state_->mutex);
  state_->options.fate = std::move(fate);
}
void EmulatedU3vCamera::Answer(std::function<U3vAnswer(std::uint64_t, bool)> answer) {
  const std::lock_guard lock(state_->mutex);
  state_->options.answer = std::move(answer);
}
bool EmulatedU3vCamera::IsAcquiring() const {
  const std::lock_guard lock(state_->mutex);
  return state_->Streams();
}
std::uint64_t EmulatedU3vCamera::Exposed() const {
  const std::lock_guard lock(state_->mutex);
  return state_->exposed;
}
std::uint64_t EmulatedU3vCamera::Requests() const {
  const std::lock_guard lock(state_->mutex);
  return state_->requests;
}
std::uint32_t EmulatedU3vCamera::Register(std::uint64_t address) const {
  const std::lock_guard lock(state_->mutex);
  return state_->Word(address);
}
double EmulatedU3vCamera::RealRegister(std::uint64_t address) const {
  const std::lock_guard lock(state_->mutex);
  return state_->Real(address);
}

}  // namespace ulf::test

#include "tracking/sources/pose_stream.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <span>
#include <utility>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/host_time.h"

namespace ulf::tracking {
namespace {

constexpr std::size_t kLongestLine = 1024;             // bytes: the documented limit
constexpr std::size_t kMostPoses = 100000;             // in the history: 100 s of a robot at 1 kHz
constexpr auto kPoll = std::chrono::milliseconds(50);  // how often a waiting frame asks whether to stop
constexpr std::size_t kShown = 60;                     // characters of a line in a message

FileDescriptor ListenOn(int port) {
  FileDescriptor listening(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int fd = listening.Number();
  const int yes = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(fd, 4) != 0)
    throw Error("tcp:{}: cannot listen for poses on 127.0.0.1: {}; choose another port", port,
                std::strerror(errno));
  return listening;
}

int PortOf(int fd) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

// Returns a line as messages show it: characters that cannot be printed become dots.
std::string Shown(const std::string& line) {
  std::string shown = line.substr(0, kShown);
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < 32 || c > 126; }, '.');
  return line.size() > shown.size() ? shown + "..." : shown;
}

}  // namespace

std::optional<SentLine> ReadSentLine(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  if (first == std::string::npos || line[first] == '#') return SentComment{};
  int used = 0;
  const auto all_read = [&] { return line.find_first_not_of(" \t\r", At(used)) == std::string::npos; };
  double value = 0;
  if (std::sscanf(line.c_str(), " sync %lf%n", &value, &used) == 1 && all_read() && std::isfinite(value))
    return SentSync{value};
  if (std::sscanf(line.c_str(), " offset %lf%n", &value, &used) == 1 && all_read() && std::isfinite(value))
    return SentOffset{value};
  double v[8];
  if (std::sscanf(line.c_str(), "%lf %lf %lf %lf %lf %lf %lf %lf%n", v, v + 1, v + 2, v + 3, v + 4, v + 5,
                  v + 6, v + 7, &used) != 8 ||
      !all_read() || !std::isfinite(v[0]))
    return std::nullopt;
  const auto pose = PoseFromNumbers(std::span<const double, 7>(v + 1, 7));
  if (!pose) return std::nullopt;
  return SentPose{v[0], *pose};
}

PoseStream::PoseStream(const PoseStreamOptions& options)
    : options_(options), history_(options.max_gap_s, kMostPoses) {
  listening_ = ListenOn(options.port);
  port_ = PortOf(listening_.Number());
  int ends[2];
  if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0)
    throw Error("tcp:{}: cannot make a pipe: {}", options.port, std::strerror(errno));
  wake_read_ = FileDescriptor(ends[0]);
  wake_write_ = FileDescriptor(ends[1]);
  thread_ = std::thread([this] { Serve(); });
}

PoseStream::~PoseStream() {
  {
    const MutexLock lock(mutex_);
    ending_ = true;
  }
  const char byte = 0;
  [[maybe_unused]] const auto written = write(wake_write_.Number(), &byte, 1);
  thread_.join();
}

void PoseStream::Serve() {
  FileDescriptor client;
  std::string pending;
  bool too_long = false;
  std::uint64_t lines = 0;
  const auto set_connected = [&](bool connected) {
    {
      const MutexLock lock(mutex_);
      connected_ = connected;
      timed_out_ = false;
      counts_.connections += connected;
      if (connected) {  // the new sender may have another clock
        sender_clock_ = {};
        given_offset_s_.reset();
        if (options_.clock == SenderClock::kOwn) history_ = PoseHistory(options_.max_gap_s, kMostPoses);
      }
    }
    changed_.notify_all();
  };
  while (true) {
    pollfd waited[] = {
        {wake_read_.Number(), POLLIN, 0}, {listening_.Number(), POLLIN, 0}, {client.Number(), POLLIN, 0}};
    if (poll(waited, client.IsOpen() ? 3 : 2, -1) < 0 && errno != EINTR) break;
    {
      const MutexLock lock(mutex_);
      if (ending_) break;
    }
    if (client.IsOpen() && waited[2].revents != 0) {
      char bytes[4096];
      const auto got = recv(client.Number(), bytes, sizeof bytes, 0);
      if (got <= 0 && !(got < 0 && (errno == EAGAIN || errno == EINTR))) {
        client = FileDescriptor();
        pending.clear();
        too_long = false;
        set_connected(false);
        spdlog::warn("the sender of poses has disconnected: frames get no pose until it connects again");
      }
      for (ssize_t i = 0; i < got; ++i) {
        if (bytes[i] != '\n') {
          if (pending.size() < kLongestLine)
            pending += bytes[i];
          else
            too_long = true;
          continue;
        }
        Take(too_long ? pending + "..." : pending, client.Number(), ++lines);
        pending.clear();
        too_long = false;
      }
    }
    if (waited[1].revents != 0) {
      FileDescriptor arrived(accept4(listening_.Number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      if (arrived.IsOpen() && client.IsOpen()) {
        const char busy[] = "# another sender is connected\n";
        [[maybe_unused]] const auto said = send(arrived.Number(), busy, sizeof busy - 1, MSG_NOSIGNAL);
        const MutexLock lock(mutex_);
        ++counts_.refused;
      } else if (arrived.IsOpen()) {
        const int yes = 1;
        setsockopt(arrived.Number(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
        client = std::move(arrived);
        set_connected(true);
      }
    }
  }
}

void PoseStream::Take(const std::string& line, int client, std::uint64_t number) {
  const auto sent = ReadSentLine(line);
  if (!sent) {
    const MutexLock lock(mutex_);
    if (counts_.malformed++ > 0) return;
    counts_.first_malformed = fmt::format("line {}: '{}'", number, Shown(line));
    spdlog::warn(
        "poses from outside: {} is not 'time tx ty tz qx qy qz qw'; such lines are skipped and counted",
        counts_.first_malformed);
  } else if (const auto* const pose = std::get_if<SentPose>(&*sent)) {
    TakePose(*pose);
  } else if (const auto* const sync = std::get_if<SentSync>(&*sent)) {
    const double now_s = EpochSeconds();
    {
      const MutexLock lock(mutex_);
      sender_clock_.Add(sync->sender_s, now_s);
    }
    const std::string answer = fmt::format("sync {:.9f} {:.9f}\n", sync->sender_s, now_s);
    [[maybe_unused]] const auto said = send(client, answer.data(), answer.size(), MSG_NOSIGNAL);
  } else if (const auto* const offset = std::get_if<SentOffset>(&*sent)) {
    const MutexLock lock(mutex_);
    given_offset_s_ = offset->offset_s;
  }
}

void PoseStream::TakePose(const SentPose& sent) {
  const double now_s = EpochSeconds();
  {
    const MutexLock lock(mutex_);
    counts_.out_of_order += !history_.empty() && sent.time_s < history_.NewestS();
    history_.Add(sent.time_s, sent.world_from_tool);
    sender_clock_.Add(sent.time_s, now_s);
    ++counts_.poses;
    timed_out_ = false;
  }
  changed_.notify_all();
}

std::optional<double> PoseStream::SenderTime(double device_time_s) const {
  if (options_.clock == SenderClock::kDevice) return device_time_s + options_.offset_s;
  const double host_s = device_time_s + device_clock_.OffsetS().value_or(0);
  if (options_.clock == SenderClock::kHost) return host_s + options_.offset_s;
  const auto offset_s = SenderOffset();
  if (!offset_s) return std::nullopt;
  return host_s - *offset_s + options_.offset_s;
}

std::optional<double> PoseStream::SenderOffset() const {
  return given_offset_s_ ? given_offset_s_ : sender_clock_.OffsetS();
}

std::optional<Rigid3> PoseStream::WorldFromTool(double device_time_s, double host_time_s) {
  using Clock = std::chrono::steady_clock;
  MutexLock lock(mutex_);
  device_clock_.Add(device_time_s, host_time_s);
  const bool first = counts_.found + counts_.before + counts_.in_gap + counts_.not_in_time == 0;
  const double patience_s = first && history_.empty() ? options_.connect_s : options_.wait_s;
  const auto until =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(patience_s));
  Rigid3 pose;
  while (true) {
    const auto time_s = SenderTime(device_time_s);
    const PoseLookup answer = time_s ? history_.At(*time_s, &pose) : PoseLookup::kAfter;
    if (answer == PoseLookup::kFound) {
      ++counts_.found;
      return pose;
    }
    const bool waited =
        Clock::now() >= until || timed_out_ || (!connected_ && !first) || (options_.stop && options_.stop());
    // A late pose may fill a gap just before the newest pose.
    const bool may_arrive = answer == PoseLookup::kAfter ||
                            (answer == PoseLookup::kGap && history_.NewestS() - *time_s < options_.wait_s);
    if (waited || !may_arrive) {
      if (answer == PoseLookup::kBefore)
        ++counts_.before;
      else if (answer == PoseLookup::kGap)
        ++counts_.in_gap;
      else
        ++counts_.not_in_time;
      timed_out_ = timed_out_ || (may_arrive && Clock::now() >= until);
      return std::nullopt;
    }
    changed_.wait_until(lock, std::min(until, Clock::now() + kPoll));
  }
}

PoseStream::Counts PoseStream::Statistics() const {
  const MutexLock lock(mutex_);
  Counts counts = counts_;
  counts.offset_s = SenderOffset();
  return counts;
}

bool PoseStream::Connected() const {
  const MutexLock lock(mutex_);
  return connected_;
}

}  // namespace ulf::tracking

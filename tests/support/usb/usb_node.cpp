#include "tests/support/usb/usb_node.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <linux/usb/ch9.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <sys/un.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tests/support/usb/usbfs_wire.h"

namespace ulf::test {
namespace {

// As much as the kernel grants the transfers of all programs together, by default (usbfs_memory_mb).
constexpr std::int64_t kMostMemory = 16 << 20;
constexpr std::uint32_t kCapabilities = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                        USBDEVFS_CAP_BULK_SCATTER_GATHER | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
constexpr std::size_t kSetup = sizeof(usb_ctrlrequest);

std::string Taken(GError* error) {
  const std::string text = error ? error->message : "unknown";
  g_clear_error(&error);
  return text;
}

// The process's sysfs and folder of nodes. Programs listen for changes of it from their first look on, so it
// stays the same from device to device.
class Surroundings {
 public:
  static Surroundings& Get() {
    static Surroundings one;
    return one;
  }
  UMockdevTestbed* Testbed() { return testbed_; }
  const std::string& Folder() const { return folder_; }
  int NextNumber() { return next_number_++; }
  // The hubs on the way to a device; they stay.
  void AddHubs(int bus, const std::string& port) {
    for (std::size_t end = port.find('.'); end != std::string::npos; end = port.find('.', end + 1)) {
      const std::string hub = fmt::format("{}-{}", bus, port.substr(0, end));
      if (!hubs_.insert(hub).second) continue;
      Add(fmt::format(
          "P: {}/{}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_hub\nA: bDeviceClass=09\\n\nA: speed=5000\\n\n\n",
          kRootHub, hub));
    }
  }

 private:
  // The hub that every device hangs on. Hubs are no usb_device, or libusb would open them, too.
  static constexpr const char* kRootHub = "/devices/pci0000:00/0000:00:14.0/usb2";

  void Add(const std::string& description) {
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(testbed_, description.c_str(), &error))
      throw std::runtime_error("umockdev: " + Taken(error));
  }
  Surroundings() : testbed_(umockdev_testbed_new()) {
    std::string pattern = "/tmp/ulf_usbfs_XXXXXX";
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no folder for emulated nodes");
    folder_ = pattern;
    setenv(usbfs::kFolderVariable, folder_.c_str(), 1);
    Add(fmt::format("P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_hub\n\n", kRootHub));
  }
  ~Surroundings() {
    rmdir(folder_.c_str());
    g_object_unref(testbed_);
  }

  UMockdevTestbed* testbed_;
  std::string folder_;
  int next_number_ = 3;
  std::set<std::string> hubs_;
};

Bytes StringDescriptor(const std::string& text) {
  Bytes bytes{static_cast<std::uint8_t>(2 + 2 * text.size()), USB_DT_STRING};
  for (const char letter : text) {
    bytes.push_back(static_cast<std::uint8_t>(letter));
    bytes.push_back(0);
  }
  return bytes;
}

}  // namespace

std::optional<std::string> NoUsbEmulation() {
  const char* preloaded = std::getenv("LD_PRELOAD");
  if (!preloaded || !std::strstr(preloaded, "libumockdev-preload") ||
      !std::strstr(preloaded, "ulf_usbfs_preload"))
    return "no emulated USB device: this process does not run under the preloaded libraries";
  return std::nullopt;
}

struct UsbNode::State {
  // An open file of the node, of this program or another.
  struct File {
    int control = -1;
    // The program has one end of a pair of sockets. While it is full, poll() waits.
    int theirs = -1, ours = -1;
    bool ready = false;
    struct Done {
      std::uint64_t urb = 0;
      int status = 0, actual = 0;
      std::size_t into_at = 0;
      std::shared_ptr<const Bytes> data;
      std::size_t from = 0, bytes = 0;
      std::int64_t memory = 0;
    };
    std::deque<Done> done;
    std::set<int> claimed;
    std::int64_t memory = 0;
    std::thread thread;
    bool gone = false;  // its device was unplugged; a new one in the same place is not its own
    bool over = false;
  };
  struct Wanted {
    File* file = nullptr;
    std::uint64_t urb = 0;
    std::size_t length = 0;
  };
  struct Unsent {
    std::shared_ptr<const Bytes> data;
    std::size_t from = 0, bytes = 0;
  };
  struct Endpoint {
    std::deque<Wanted> wanted;
    std::deque<Unsent> unsent;
    bool halted = false;
    std::size_t cleared = 0;
  };

  State(const UsbIdentity& wanted, OnData taker) : identity(wanted), on_data(std::move(taker)) { PlugIn(); }
  ~State() {
    if (plugged) Unplug();
    std::unique_lock lock(mutex);
    for (File& file : files) shutdown(file.control, SHUT_RDWR);
    lock.unlock();
    for (File& file : files) Join(file);
  }

  std::string SysPath() const {
    return fmt::format("/devices/pci0000:00/0000:00:14.0/usb2/{}-{}", identity.bus, identity.port);
  }
  std::string SocketPath() const {
    return fmt::format("{}/{:03}-{:03}", Surroundings::Get().Folder(), identity.bus, number);
  }

  std::string Description() const {
    std::string hex;
    for (const std::uint8_t byte : identity.descriptors) hex += fmt::format("{:02X}", byte);
    std::string text = fmt::format(
        "P: {0}\nE: BUSNUM={1:03}\nE: DEVNAME=/dev/bus/usb/{1:03}/{2:03}\nE: DEVNUM={2:03}\n"
        "E: DEVTYPE=usb_device\nE: DRIVER=usb\nE: MAJOR=189\nE: MINOR={3}\nE: PRODUCT={4:x}/{5:x}/100\n"
        "E: SUBSYSTEM=usb\nE: TYPE={6}/{7}/{8}\n"
        "A: bDeviceClass={6:02x}\\n\nA: bDeviceSubClass={7:02x}\\n\nA: bDeviceProtocol={8:02x}\\n\n"
        "A: idVendor={4:04x}\\n\nA: idProduct={5:04x}\\n\nA: busnum={1}\\n\nA: devnum={2}\\n\nA: "
        "speed={9}\\n\n"
        "A: bConfigurationValue=1\\n\nA: bNumConfigurations=1\\n\nA: manufacturer={10}\\n\n"
        "A: product={11}\\n\nA: serial={12}\\n\nH: descriptors={13}\n\n",
        SysPath(), identity.bus, number, (identity.bus - 1) * 128 + number - 1, identity.vendor_id,
        identity.product_id, identity.klass, identity.subclass, identity.protocol, identity.megabits,
        identity.maker, identity.model, identity.serial, hex);
    for (const UsbInterface& one : identity.interfaces)
      text += fmt::format(
          "P: {0}/{1}-{2}:1.{3}\nE: DEVTYPE=usb_interface\nE: SUBSYSTEM=usb\n"
          "A: bInterfaceNumber={3:02x}\\n\nA: bInterfaceClass={4:02x}\\n\nA: bInterfaceSubClass={5:02x}\\n\n"
          "A: bInterfaceProtocol={6:02x}\\n\n\n",
          SysPath(), identity.bus, identity.port, one.number, one.klass, one.subclass, one.protocol);
    return text;
  }

  void PlugIn() {
    Surroundings& around = Surroundings::Get();
    {
      const std::lock_guard lock(mutex);
      number = around.NextNumber();
      endpoints.clear();
      plugged = true;
    }
    listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, SocketPath().c_str(), sizeof address.sun_path - 1);
    if (listener < 0 || bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        listen(listener, 16) != 0)
      throw std::runtime_error("an emulated node cannot listen");
    acceptor = std::thread([this] { Accept(); });
    around.AddHubs(identity.bus, identity.port);
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(around.Testbed(), Description().c_str(), &error))
      throw std::runtime_error("umockdev: " + Taken(error));
    umockdev_testbed_uevent(around.Testbed(), ("/sys" + SysPath()).c_str(), "add");
  }

  void Unplug() {
    unlink(SocketPath().c_str());
    shutdown(listener, SHUT_RDWR);
    acceptor.join();
    close(listener);
    {
      const std::lock_guard lock(mutex);
      plugged = false;
      for (auto& [address, endpoint] : endpoints) {
        for (const Wanted& wanted : std::exchange(endpoint.wanted, {}))
          Complete(wanted, -ESHUTDOWN, nullptr, 0, 0);
        endpoint.unsent.clear();
      }
      for (File& file : files) {
        Break(file);
        file.claimed.clear();
        file.gone = true;
      }
    }
    changed.notify_all();
    Surroundings& around = Surroundings::Get();
    umockdev_testbed_uevent(around.Testbed(), ("/sys" + SysPath()).c_str(), "remove");
    for (const UsbInterface& one : identity.interfaces)
      umockdev_testbed_remove_device(
          around.Testbed(),
          fmt::format("/sys{}/{}-{}:1.{}", SysPath(), identity.bus, identity.port, one.number).c_str());
    umockdev_testbed_remove_device(around.Testbed(), ("/sys" + SysPath()).c_str());
  }

  // ---- files ----

  void Accept() {
    for (;;) {
      const int control = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
      if (control < 0 && (errno == EINTR || errno == ECONNABORTED)) continue;
      if (control < 0) return;
      const std::lock_guard lock(mutex);
      for (auto file = files.begin(); file != files.end();) {
        auto next = std::next(file);
        if (file->over) {
          Join(*file);
          files.erase(file);
        }
        file = next;
      }
      if (refusal != 0) {
        const usbfs::Reply reply{.result = -1, .error = refusal};
        usbfs::SendAll(control, &reply, sizeof reply);
        close(control);
        continue;
      }
      HandOut(control);
    }
  }

  static void Join(File& file) {
    if (file.thread.joinable()) file.thread.join();
  }

  void HandOut(int control) {
    std::array<int, 2> pair{-1, -1};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, pair.data()) != 0) {
      close(control);
      return;
    }
    const int least = 1, most = 8 << 20;  // the system bounds both
    setsockopt(pair[0], SOL_SOCKET, SO_SNDBUF, &least, sizeof least);
    if (setsockopt(control, SOL_SOCKET, SO_SNDBUFFORCE, &most, sizeof most) != 0)
      setsockopt(control, SOL_SOCKET, SO_SNDBUF, &most, sizeof most);
    File& file = files.emplace_back();
    file.control = control;
    file.theirs = pair[0];
    file.ours = pair[1];
    Fill(file);
    usbfs::Reply reply;
    iovec part{&reply, sizeof reply};
    alignas(cmsghdr) char room[CMSG_SPACE(sizeof(int))] = {};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = room;
    message.msg_controllen = sizeof room;
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(header), &file.theirs, sizeof(int));
    sendmsg(control, &message, MSG_NOSIGNAL);
    file.thread = std::thread([this, &file] { Serve(file); });
  }

  // poll() waits from here on, until Drain().
  static void Fill(File& file) {
    const std::array<char, 1024> nothing{};
    while (send(file.theirs, nothing.data(), nothing.size(), MSG_NOSIGNAL) > 0) continue;
    file.ready = false;
  }
  static void Drain(File& file) {
    std::array<char, 4096> nothing;
    while (recv(file.ours, nothing.data(), nothing.size(), 0) > 0) continue;
    file.ready = true;
  }
  // Closed with something unread in it, the pair reports POLLERR, as the kernel does for a
  // device that is gone.
  static void Break(File& file) {
    if (file.ours < 0) return;
    Fill(file);
    close(std::exchange(file.ours, -1));
  }

  void Serve(File& file) {
    usbfs::Request request;
    Bytes data;
    while (usbfs::ReceiveAll(file.control, &request, sizeof request)) {
      data.resize(request.bytes);
      if (!usbfs::ReceiveAll(file.control, data.data(), data.size())) break;
      std::shared_ptr<const Bytes> kept;
      std::size_t from = 0;
      usbfs::Reply reply;
      Take(file, request, data, reply, kept, from);
      if (reply.error != 0) reply.result = -1;
      if (!usbfs::SendAll(file.control, &reply, sizeof reply) ||
          (reply.bytes > 0 && !usbfs::SendAll(file.control, kept->data() + from, reply.bytes)))
        break;
    }
    const std::lock_guard lock(mutex);
    for (auto& [address, endpoint] : endpoints)
      std::erase_if(endpoint.wanted, [&](const Wanted& wanted) { return wanted.file == &file; });
    if (file.ours >= 0) close(std::exchange(file.ours, -1));
    close(std::exchange(file.theirs, -1));
    close(file.control);
    file.claimed.clear();
    file.over = true;
  }

  // ---- requests ----

  void Take(File& file, const usbfs::Request& request, const Bytes& data, usbfs::Reply& reply,
            std::shared_ptr<const Bytes>& kept, std::size_t& from) {
    std::unique_lock lock(mutex);
    if (request.number == static_cast<std::uint32_t>(USBDEVFS_REAPURBNDELAY)) {
      if (file.done.empty()) {
        reply.error = file.gone ? ENODEV : EAGAIN;
        return;
      }
      File::Done done = std::move(file.done.front());
      file.done.pop_front();
      file.memory -= done.memory;
      if (file.done.empty() && file.ready && !file.gone) Fill(file);
      reply.urb = done.urb;
      reply.status = done.status;
      reply.actual = done.actual;
      reply.bytes = static_cast<std::uint32_t>(done.bytes);
      reply.into_at = static_cast<std::uint32_t>(done.into_at);
      kept = std::move(done.data);
      from = done.from;
      return;
    }
    if (!plugged || file.gone) {
      reply.error = ENODEV;
      return;
    }
    switch (request.number) {
      case static_cast<std::uint32_t>(USBDEVFS_GET_CAPABILITIES):
        reply.urb = kCapabilities;
        return;
      case static_cast<std::uint32_t>(USBDEVFS_CLAIMINTERFACE):
      case static_cast<std::uint32_t>(USBDEVFS_DISCONNECT_CLAIM):
        for (const File& other : files)
          if (&other != &file && !other.over && other.claimed.contains(static_cast<int>(request.argument)))
            reply.error = EBUSY;
        if (reply.error == 0) file.claimed.insert(static_cast<int>(request.argument));
        return;
      case static_cast<std::uint32_t>(USBDEVFS_RELEASEINTERFACE):
        if (file.claimed.erase(static_cast<int>(request.argument)) == 0) reply.error = EINVAL;
        return;
      case static_cast<std::uint32_t>(USBDEVFS_GETDRIVER):
        reply.error = ENODATA;  // no driver of the kernel holds it
        return;
      case static_cast<std::uint32_t>(USBDEVFS_GET_SPEED):
        reply.result = identity.megabits >= 5000 ? USB_SPEED_SUPER : USB_SPEED_HIGH;
        return;
      case static_cast<std::uint32_t>(USBDEVFS_CLEAR_HALT):
      case static_cast<std::uint32_t>(USBDEVFS_RESETEP): {
        Endpoint& endpoint = endpoints[static_cast<std::uint8_t>(request.argument)];
        endpoint.halted = false;
        ++endpoint.cleared;
        return;
      }
      case static_cast<std::uint32_t>(USBDEVFS_RESET):
      case static_cast<std::uint32_t>(USBDEVFS_SETINTERFACE):
        return;
      case static_cast<std::uint32_t>(USBDEVFS_DISCARDURB):
        reply.error = Discard(file, request.argument) ? 0 : EINVAL;
        return;
      case static_cast<std::uint32_t>(USBDEVFS_SUBMITURB):
        reply.error = Submit(lock, file, request.argument, data);
        return;
      default:
        reply.error = ENOTTY;
    }
  }

  bool Discard(File& file, std::uint64_t urb) {
    for (auto& [address, endpoint] : endpoints)
      for (auto wanted = endpoint.wanted.begin(); wanted != endpoint.wanted.end(); ++wanted)
        if (wanted->file == &file && wanted->urb == urb) {
          const Wanted taken = *wanted;
          endpoint.wanted.erase(wanted);
          Complete(taken, -ENOENT, nullptr, 0, 0);
          return true;
        }
    return false;
  }

  int Submit(std::unique_lock<std::mutex>& lock, File& file, std::uint64_t address, const Bytes& data) {
    usbfs::Urb urb;
    if (data.size() < sizeof urb) return EINVAL;
    std::memcpy(&urb, data.data(), sizeof urb);
    if (urb.length < 0) return EINVAL;
    const Wanted wanted{&file, address, static_cast<std::size_t>(urb.length)};
    if (file.memory + urb.length > kMostMemory) return ENOMEM;
    file.memory += urb.length;
    most_memory = std::max(most_memory, file.memory);
    const Bytes out(data.begin() + sizeof urb, data.end());
    if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
      Control(wanted, out);
      return 0;
    }
    Endpoint& endpoint = endpoints[urb.endpoint];
    if (endpoint.halted) {
      Complete(wanted, -EPIPE, nullptr, 0, 0);
      return 0;
    }
    if (urb.endpoint & USB_DIR_IN) {
      endpoint.wanted.push_back(wanted);
      Match(endpoint);
      changed.notify_all();
      return 0;
    }
    Complete(wanted, 0, nullptr, 0, static_cast<int>(out.size()));
    lock.unlock();
    const std::lock_guard one_at_a_time(taking);
    on_data(urb.endpoint, out);
    return 0;
  }

  void Control(const Wanted& wanted, const Bytes& out) {
    usb_ctrlrequest setup{};
    if (out.size() < kSetup) return Complete(wanted, -EPIPE, nullptr, 0, 0);
    std::memcpy(&setup, out.data(), kSetup);
    const auto endpoint = static_cast<std::uint8_t>(setup.wIndex);
    if (setup.bRequestType == (USB_DIR_OUT | USB_RECIP_ENDPOINT) &&
        (setup.bRequest == USB_REQ_SET_FEATURE || setup.bRequest == USB_REQ_CLEAR_FEATURE)) {
      endpoints[endpoint].halted = setup.bRequest == USB_REQ_SET_FEATURE;
      return Complete(wanted, 0, nullptr, 0, 0);
    }
    if (setup.bRequestType != USB_DIR_IN || setup.bRequest != USB_REQ_GET_DESCRIPTOR ||
        setup.wValue >> 8 != USB_DT_STRING)
      return Complete(wanted, -EPIPE, nullptr, 0, 0);  // a request that it does not know
    Bytes answer;
    std::vector<std::string> strings{identity.maker, identity.model, identity.serial};
    strings.insert(strings.end(), identity.more_strings.begin(), identity.more_strings.end());
    const std::size_t index = setup.wValue & 0xFF;
    if (index > strings.size()) return Complete(wanted, -EPIPE, nullptr, 0, 0);
    if (index == 0)
      answer = {4, USB_DT_STRING, 0x09, 0x04};  // the languages
    else
      answer = StringDescriptor(strings[index - 1]);
    answer.resize(std::min<std::size_t>(answer.size(), setup.wLength));
    const std::size_t bytes = answer.size();
    Complete(wanted, 0, std::make_shared<const Bytes>(std::move(answer)), 0, static_cast<int>(bytes), bytes,
             kSetup);
  }

  void Complete(const Wanted& wanted, int status, std::shared_ptr<const Bytes> data, std::size_t from,
                int actual, std::size_t bytes = 0, std::size_t into_at = 0) {
    wanted.file->done.push_back({.urb = wanted.urb,
                                 .status = status,
                                 .actual = actual,
                                 .into_at = into_at,
                                 .data = std::move(data),
                                 .from = from,
                                 .bytes = bytes,
                                 .memory = static_cast<std::int64_t>(wanted.length)});
    if (!wanted.file->ready && !wanted.file->gone && plugged) Drain(*wanted.file);
  }

  std::size_t PacketBytes() const { return identity.megabits >= 5000 ? 1024 : 512; }

  // What the device has meets what the host wants. A transfer that is shorter than a request ends it; one
  // that is longer goes on in the next request, unless a packet does not fit in the rest.
  void Match(Endpoint& endpoint) {
    while (!endpoint.wanted.empty() && !endpoint.unsent.empty()) {
      const Wanted wanted = endpoint.wanted.front();
      endpoint.wanted.pop_front();
      Unsent& unsent = endpoint.unsent.front();
      const std::size_t bytes = std::min(wanted.length, unsent.bytes);
      const bool babbles = unsent.bytes > wanted.length && wanted.length % PacketBytes() != 0;
      Complete(wanted, babbles ? -EOVERFLOW : 0, unsent.data, unsent.from, static_cast<int>(bytes), bytes);
      const std::size_t gone = std::min(
          unsent.bytes, babbles ? (bytes + PacketBytes() - 1) / PacketBytes() * PacketBytes() : bytes);
      unsent.from += gone;
      unsent.bytes -= gone;
      if (unsent.bytes == 0) endpoint.unsent.pop_front();
    }
  }

  const UsbIdentity identity;
  const OnData on_data;
  std::mutex taking;  // while on_data runs
  int listener = -1;
  std::thread acceptor;

  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  std::map<std::uint8_t, Endpoint> endpoints;
  std::list<File> files;
  int number = 0, refusal = 0;
  std::int64_t most_memory = 0;
  bool plugged = false;
};

UsbNode::UsbNode(const UsbIdentity& identity, OnData on_data)
    : state_(std::make_unique<State>(identity, std::move(on_data))) {}
UsbNode::~UsbNode() = default;

void UsbNode::Send(std::uint8_t endpoint, std::shared_ptr<const Bytes> data, std::size_t from,
                   std::size_t bytes) {
  const std::lock_guard lock(state_->mutex);
  if (!state_->plugged) return;
  State::Endpoint& at = state_->endpoints[endpoint];
  at.unsent.push_back({std::move(data), from, bytes});
  state_->Match(at);
}
void UsbNode::Send(std::uint8_t endpoint, Bytes data) {
  const std::size_t bytes = data.size();
  Send(endpoint, std::make_shared<const Bytes>(std::move(data)), 0, bytes);
}
std::size_t UsbNode::Unsent(std::uint8_t endpoint) const {
  const std::lock_guard lock(state_->mutex);
  return state_->endpoints[endpoint].unsent.size();
}
std::size_t UsbNode::Wanted(std::uint8_t endpoint) const {
  const std::lock_guard lock(state_->mutex);
  return state_->endpoints[endpoint].wanted.size();
}
bool UsbNode::AwaitWanted(std::uint8_t endpoint, double seconds) const {
  std::unique_lock lock(state_->mutex);
  return state_->changed.wait_for(lock, std::chrono::duration<double>(seconds), [&] {
    const State::Endpoint& at = state_->endpoints[endpoint];
    return !at.wanted.empty() && at.unsent.empty();
  });
}
void UsbNode::Forget(std::uint8_t endpoint) {
  const std::lock_guard lock(state_->mutex);
  state_->endpoints[endpoint].unsent.clear();
}
void UsbNode::Stall(std::uint8_t endpoint) {
  const std::lock_guard lock(state_->mutex);
  State::Endpoint& at = state_->endpoints[endpoint];
  at.halted = true;
  at.unsent.clear();
  for (const State::Wanted& wanted : std::exchange(at.wanted, {}))
    state_->Complete(wanted, -EPIPE, nullptr, 0, 0);
}
std::size_t UsbNode::HaltsCleared(std::uint8_t endpoint) const {
  const std::lock_guard lock(state_->mutex);
  return state_->endpoints[endpoint].cleared;
}
void UsbNode::Refuse(int error) {
  const std::lock_guard lock(state_->mutex);
  state_->refusal = error;
}
void UsbNode::Unplug() { state_->Unplug(); }
void UsbNode::PlugIn() { state_->PlugIn(); }
bool UsbNode::IsPlugged() const {
  const std::lock_guard lock(state_->mutex);
  return state_->plugged;
}
bool UsbNode::IsClaimed(int interface) const {
  const std::lock_guard lock(state_->mutex);
  for (const State::File& file : state_->files)
    if (!file.over && file.claimed.contains(interface)) return true;
  return false;
}
std::int64_t UsbNode::MostMemory() const {
  const std::lock_guard lock(state_->mutex);
  return state_->most_memory;
}
std::size_t UsbNode::Opened() const {
  const std::lock_guard lock(state_->mutex);
  return static_cast<std::size_t>(std::count_if(state_->files.begin(), state_->files.end(),
                                                [](const State::File& file) { return !file.over; }));
}

}  // namespace ulf::test

// Emulates a USB device: what the kernel shows of it in sysfs and udev (through umockdev) and its node under
// /dev/bus/usb (through usbfs_preload.cpp), for programs over libusb that know nothing of the emulation, in
// this process and its children. Transfers wait in their queues as the kernel's do, complete in order, and
// end with the kernel's error numbers.
//
// The emulation works in a process that runs under both preloaded libraries; NoUsbEmulation() tells why it
// cannot.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ulf::test {

using Bytes = std::vector<std::uint8_t>;

// Returns why there can be no emulated device in this process; none: there can.
std::optional<std::string> NoUsbEmulation();

struct UsbInterface {
  int number = 0, klass = 0, subclass = 0, protocol = 0;
};

struct UsbIdentity {
  std::string maker, model, serial;       // its strings 1, 2, 3
  std::vector<std::string> more_strings;  // from 4 on
  std::uint16_t vendor_id = 0, product_id = 0;
  int bus = 2;
  std::string port = "1";  // "1.2": the second of a hub of 5000 Mbit/s at port 1
  int megabits = 5000;
  std::uint8_t klass = 0, subclass = 0, protocol = 0;
  std::vector<UsbInterface> interfaces;
  Bytes descriptors;  // of the device and of its configuration
};

class UsbNode {
 public:
  // Takes what is sent to an endpoint; called by one thread at a time.
  using OnData = std::function<void(std::uint8_t endpoint, const Bytes& data)>;

  UsbNode(const UsbIdentity& identity, OnData on_data);
  ~UsbNode();
  UsbNode(const UsbNode&) = delete;
  UsbNode& operator=(const UsbNode&) = delete;

  // Queues one transfer of the device for the host's requests at `endpoint` (with 0x80): it fills as many
  // requests as it is long, and ends the last of them. The first form sends a part of `data`.
  void Send(std::uint8_t endpoint, std::shared_ptr<const Bytes> data, std::size_t from, std::size_t bytes);
  void Send(std::uint8_t endpoint, Bytes data);
  // Return how many transfers wait for the host, and how many requests of the host wait for the device.
  std::size_t Unsent(std::uint8_t endpoint) const;
  std::size_t Wanted(std::uint8_t endpoint) const;
  // Waits until the host wants something from the endpoint and nothing is unsent, for so long at most.
  // Returns whether it is so.
  bool AwaitWanted(std::uint8_t endpoint, double seconds) const;
  void Forget(std::uint8_t endpoint);  // drops what is unsent

  // Stalls the endpoint: its next request fails, and so do all until the host clears that.
  void Stall(std::uint8_t endpoint);
  std::size_t HaltsCleared(std::uint8_t endpoint) const;
  void Refuse(int error);  // opening the node fails with this errno; 0: no longer
  void Unplug();           // as the kernel does it
  void PlugIn();           // with the device number that comes next
  bool IsPlugged() const;
  bool IsClaimed(int interface) const;
  std::size_t Opened() const;  // how many files are open now
  // Returns the most bytes that one program's requests held at once; the kernel grants 16 MB to all together.
  std::int64_t MostMemory() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::test

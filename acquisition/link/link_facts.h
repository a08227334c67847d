// Describes the link to a camera: what the system knows of the path, the camera's settings, and the losses so
// far. Each fact that is not in order names the command or setting that corrects it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/aravis/aravis_usb.h"
#include "acquisition/device/device.h"
#include "acquisition/link/host_link.h"

namespace ulf::acquisition {

// What this computer knows of the path to a camera, which does not change while the camera streams.
struct LinkPath {
  std::optional<NetworkLink> network;  // of a camera in a network
  std::optional<UsbCameraPlace> usb;   // of a USB3 Vision camera
  std::optional<int> usb_memory_mb;    // UsbMemoryMb(), for a USB3 Vision camera
  std::vector<UsbNeighbour> usb_neighbours = {};
  std::optional<double> most_buffer = {};  // MostSocketBuffer(), for a camera in a network
};
// Reads /proc and /sys.
LinkPath LinkPathTo(const DeviceInfo& camera);

inline constexpr const char* kRateFact = "rate";  // the name of the fact about the frame rate

// One fact about the link, for people.
struct LinkFact {
  std::string name, value;
  std::string advice = {};  // what would improve this; empty: nothing would, or nothing needs to
  bool in_order = true;     // false: this loses frames or slows them down, or will
};

struct LinkFacts {
  std::vector<LinkFact> facts;
  double payload_bytes = 0;        // of a frame; 0: not known
  std::optional<double> set_fps;   // the rate that is set; none: unknown, or the camera waits for triggers
  double exposure_s = 0;           // 0: not known
  double busy_share = 0;           // share of the time in which packets arrive; 0: unknown
  std::optional<double> most_fps;  // that the link's nominal speed allows; none: unknown
};
// `counted`: the statistics of a camera that streams or has streamed.
LinkFacts DescribeLink(const DeviceInfo& camera, const LinkPath& path, const DeviceStatistics& counted);
// Returns how many frames did not arrive whole; none if no frame came, or the camera is on another bus than
// GigE Vision and USB3 Vision.
std::optional<LinkFact> LostSoFar(const DeviceInfo& camera, const DeviceStatistics& counted);

// Returns why the camera itself, and not its link, sends fewer frames a second than requested or set; empty
// if there is no sign of that. `fps`: the rate that came, with no frame lost.
std::string CameraLimitText(double fps, const LinkFacts& facts);

// Returns the frame rate that fills a GigE Vision link, with headers and gaps between packets; 0 if the
// packets are too small for any pixels. `packet_size`: bytes, with the headers of IP and UDP.
double MostGigeFps(double link_bytes_per_s, double payload_bytes, int packet_size);
// Returns the number of packets that carry a frame's pixels; 0 if the packets are too small for any.
double GigePackets(double payload_bytes, double packet_size);
// Returns the DeviceLinkThroughputLimit, bytes a second, that lets `pixels_per_s` bytes of pixels through.
double ThroughputLimitFor(double pixels_per_s);

}  // namespace ulf::acquisition

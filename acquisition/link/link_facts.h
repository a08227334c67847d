// Describes the link to a camera without a trial: what the system knows of the path, the camera's settings,
// and the losses so far. Each fact that is not in order has the command or setting that corrects it.
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
  std::optional<int> usb_memory_mb;    // for a USB3 Vision camera
  std::vector<UsbNeighbour> usb_neighbours = {};
  std::optional<double> most_buffer = {};  // net.core.rmem_max, for a camera in a network
};
// Reads /proc and /sys.
LinkPath LinkPathTo(const DeviceInfo& camera);

inline constexpr const char* kRateFact = "rate";  // the name of the fact about the frame rate

// One fact about the link, for people.
struct LinkFact {
  std::string name, value;
  std::string advice = {};  // what would raise it; empty: nothing would, or nothing needs to
  bool in_order = true;     // false: frames are lost or held back by it, or will be
};

struct LinkFacts {
  std::vector<LinkFact> facts;
  double payload_bytes = 0;        // of a frame; 0: not known
  std::optional<double> set_fps;   // that the camera was set to; none: not known, or it waits for triggers
  double exposure_s = 0;           // 0: not known
  double busy_share = 0;           // of the time, in which packets of some frame come; 0: not known
  std::optional<double> most_fps;  // that the link's speed allows, by its own figures
};
// `counted`: of a camera that streams or has streamed.
LinkFacts DescribeLink(const DeviceInfo& camera, const LinkPath& path, const DeviceStatistics& counted);
// Returns how many frames did not arrive whole; none if no frame came, or the camera has no link (simulated).
std::optional<LinkFact> LostSoFar(const DeviceInfo& camera, const DeviceStatistics& counted);

// Returns why the camera itself, and not its link, sends fewer frames a second than it was asked for or set
// to; empty if nothing says so. `fps`: that came, with none lost.
std::string CameraLimitText(double fps, const LinkFacts& facts);

// Returns the highest rate that a GigE Vision link carries, with headers and gaps between packets.
double MostGigeFps(double link_bytes_per_s, double payload_bytes, int packet_size);
// Returns the number of packets with pixels in a frame; 0: they are too small for any.
double GigePackets(double payload_bytes, double packet_size);
// Returns the DeviceLinkThroughputLimit, in bytes a second, that lets so many bytes of pixels through.
double ThroughputLimitFor(double pixels_per_s);

}  // namespace ulf::acquisition

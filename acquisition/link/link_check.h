// Checks whether the link to a camera carries what its settings require: by what the system knows of the
// link, then by trials with the camera streaming. Where frames are lost, it tries smaller packets and then
// lower rates, until none is lost, and advises the setting that helped. Where a camera is slower than its
// link, it advises the rate that it reaches.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/link/link_facts.h"

namespace ulf::acquisition {

struct LinkCheckOptions {
  double seconds = 5;          // of each trial
  double confirmed_times = 3;  // a setting that held must hold once more, so many times longer. Guessed
  double first_frame_s = 10;   // that a camera may take to begin. Guessed
  // Packet sizes, bytes, tried in this order where frames are lost and the camera sends larger ones: they fit
  // jumbo frames, Ethernet, tunnels, and any network (RFC 791).
  std::vector<int> packet_sizes = {8000, 4000, 1500, 1400, 576};
  int most_rates = 8;               // lower ones that are tried, one after the other. Guessed
  std::function<bool()> stop = {};  // asked between frames
  std::function<void(const std::string&)> say = {};
};

// A trial: the camera streamed with these settings.
struct LinkTrial {
  std::string settings;  // beside those asked for, as in a URI: "packet_size=1400"; empty: as asked for
  double seconds = 0;
  double asked_fps = 0;  // by the URI; 0: by nobody
  double set_fps = 0;    // that the camera says it is set to; 0: it does not say
  double fps = 0;        // that came, whole or not
  std::uint64_t whole = 0, incomplete = 0, missing = 0;
  double resent_packets = 0;
  bool LostFrames() const { return incomplete + missing > 0 || whole == 0; }
  // Returns whether fewer frames came than requested: a sender that waits for its link loses none. Guessed.
  bool TooSlow() const { return fps < 0.9 * asked_fps; }
  bool Held() const { return !LostFrames() && !TooSlow(); }
  // Returns whether nothing was lost and the request was met, but the camera reports a higher rate.
  bool BelowWhatIsSet() const { return Held() && fps < 0.9 * set_fps; }
};

struct LinkReport {
  DeviceInfo camera;
  std::vector<LinkFact> facts;
  std::vector<LinkTrial> trials;
  double payload_bytes = 0;        // of a frame; 0: not known
  std::optional<double> most_fps;  // that the link's speed allows, by its own figures
  std::optional<std::string>
      remedy;  // settings with which no frame was lost; none: none is needed, or none helped
  std::string
      camera_limit;  // CameraLimitText(), where fewer frames than asked for or set came, and none was lost
  // Returns whether the link holds as requested or with the remedy.
  bool Holds() const { return remedy || (!trials.empty() && trials.front().Held()); }
};

// Throws as OpenDevice() does, and Refusal for a device that is no live camera.
LinkReport CheckLink(const std::string& uri, const LinkCheckOptions& options = {});

}  // namespace ulf::acquisition

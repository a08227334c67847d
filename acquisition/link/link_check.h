// Checks whether the link to a camera carries what its settings require, by streaming and by what the system
// knows of the link. If frames are lost, or come slower than requested, it streams with other settings, one
// after the other, until that is mended: a larger receive buffer, smaller packets, a higher throughput limit,
// pauses between packets, lower rates. It advises the setting that helped.
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
  double confirmed_times = 3;  // a setting that held must hold again, so many times as long. Guessed
  double first_frame_s = 10;   // within which the first frame must come. Guessed
  // Packet sizes, bytes, tried in this order if no frame comes whole and the camera sends larger packets:
  // they fit jumbo frames, Ethernet, tunnels, and any network (RFC 791).
  std::vector<int> packet_sizes = {8000, 4000, 1500, 1400, 576};
  int most_rates = 8;                                // how many lower rates are tried. Guessed
  std::function<bool()> stop = {};                   // asked between frames; true ends the check
  std::function<void(const std::string&)> say = {};  // gets a line for people before each trial
};

// A trial: the camera streamed with these settings.
struct LinkTrial {
  std::string settings;  // options in addition to those of the URI: "packet_size=1400"; empty: none
  double seconds = 0;
  double asked_fps = 0;  // by the URI; 0: the URI names no rate
  double set_fps = 0;    // the rate to which the camera is set; 0: unknown
  double fps = 0;        // of frames that were sent: whole, incomplete and missing
  std::uint64_t whole = 0, incomplete = 0, missing = 0;  // frames
  double resent_packets = 0;
  bool LostFrames() const { return incomplete + missing > 0 || whole == 0; }
  // Returns whether the rate is below the requested one, as of a camera that waits for its link. Guessed.
  bool TooSlow() const { return fps < 0.9 * asked_fps; }
  bool Held() const { return !LostFrames() && !TooSlow(); }
  // Returns whether the trial held, but at less than the rate to which the camera is set.
  bool BelowWhatIsSet() const { return Held() && fps < 0.9 * set_fps; }
};

struct LinkReport {
  DeviceInfo camera;
  std::vector<LinkFact> facts;
  std::vector<LinkTrial> trials;
  double payload_bytes = 0;        // of a frame; 0: not known
  std::optional<double> most_fps;  // that the link's nominal speed allows; none: unknown
  // The settings with which a trial held; none: none are needed, or none helped.
  std::optional<std::string> remedy;
  // CameraLimitText(), if no frame was lost but fewer came than requested or set; else empty.
  std::string camera_limit;
  // Returns whether the link carries the frames as requested, or with the remedy.
  bool Holds() const { return remedy || (!trials.empty() && trials.front().Held()); }
};

// Opens, streams and closes the camera for each trial, and returns early if `stop` says so. Throws as
// OpenDevice() does, and Refusal for a replay.
LinkReport CheckLink(const std::string& uri, const LinkCheckOptions& options = {});

}  // namespace ulf::acquisition

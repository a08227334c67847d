// Configures a camera's link: the size of its packets and the pause between them (GigE Vision), and its limit
// of bytes a second.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/feature_names.h"

namespace ulf::acquisition {

struct AravisLink {
  // GigE Vision; 0: another bus, or unknown.
  int packet_size = 0;
  bool packet_size_negotiated = false;  // found with test packets; else asked for, or the camera's own
  std::int64_t packet_delay_ns = 0;
  // The camera's own limit of bytes a second; none: it has none.
  std::optional<double> throughput_limit;
};

// Writes what the options ask for and returns what the camera took; `notes` receives the settings that it
// changed. `who` names the camera in errors. Throws Refusal for a setting that the camera does not have or
// take.
AravisLink WriteAravisLink(const AravisSession& session, const std::string& who, const AravisOptions& options,
                           const FeatureNames& names, std::vector<std::string>& notes);

}  // namespace ulf::acquisition

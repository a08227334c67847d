// Configures a camera's link: size of its packets, pause between them (GigE Vision), limit of bytes a second.
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
  // Bytes, with the headers of IP and UDP; 0: unknown, or not GigE Vision.
  int packet_size = 0;
  bool packet_size_negotiated = false;  // found with test packets; else requested, or the camera's own
  std::int64_t packet_delay_ns = 0;
  // The camera's own limit, bytes a second; none: the camera has none, or it is off.
  std::optional<double> throughput_limit;
};

// Writes what the options ask for and returns what the camera took; `notes` receives the settings that it
// changed. `who` names the camera in errors. Throws Refusal for a setting that it does not have or take.
AravisLink WriteAravisLink(const AravisSession& session, const std::string& who, const AravisOptions& options,
                           const FeatureNames& names, std::vector<std::string>& notes);

}  // namespace ulf::acquisition

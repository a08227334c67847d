// The report of a finished capture: text for people, JSON for programs.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "coverage/session/capture_session.h"

namespace ulf::commands {

// `tracked`: frames that got a pose. Complete lines.
std::string ToText(const coverage::CaptureSummary& summary, std::size_t tracked);
void AddTo(nlohmann::json& json, const coverage::CaptureSummary& summary, std::size_t tracked);

// Why nothing was recorded, and what to do: the commonest reason. For captures that recorded no view.
std::string NothingRecorded(const coverage::CaptureSummary& summary, std::size_t tracked);

// When most frames were refused and few of those that were not covered already were recorded: the commonest
// reason and what to do. Reasons that mean that the camera does not look at the subject count as one. Empty:
// no such reason. For captures that recorded something.
std::string FewRecordedReason(const coverage::CaptureSummary& summary);

}  // namespace ulf::commands

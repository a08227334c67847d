// What a capture came to: for the operator on standard output, for programs as one JSON object.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "coverage/session/capture_session.h"

namespace ulf::commands {

// `tracked`: frames that got a pose. Lines, each with its end.
std::string ToText(const coverage::CaptureSummary& summary, std::size_t tracked);
void AddTo(nlohmann::json& json, const coverage::CaptureSummary& summary, std::size_t tracked);

// Why nothing was recorded, and what to do: the commonest reason. For captures that recorded no view.
std::string NothingRecorded(const coverage::CaptureSummary& summary, std::size_t tracked);

// Where most frames were refused although their viewpoint may have been wanted, and few of those that were
// not covered already were recorded: the commonest reason and the way out; all that say that the camera looks
// past the subject are one. Empty: nothing stood in the way. For captures that recorded something.
std::string FewRecordedReason(const coverage::CaptureSummary& summary);

}  // namespace ulf::commands

// The lines of a recording's frames.jsonl (frame_recording.h).
#pragma once

#include "acquisition/device/frame_recording.h"
#include "core/base/json_fields.h"

namespace ulf::acquisition {

nlohmann::json RecordingHeaderToJson(const RecordingHeader& header);
// Throws Error for a recording of a newer version.
RecordingHeader RecordingHeaderFromJson(const JsonPlace& line);

// `file` and `raw_file` are relative to the recording; empty: there is none.
nlohmann::json FrameToJson(const Frame& frame, const std::string& file, const std::string& raw_file);
Frame FrameFromJson(const JsonPlace& line);  // without pixels

}  // namespace ulf::acquisition

// Runs `ulf evaluate --protocol`, which measures renderings as papers do: photographs that a protocol names
// are left out, rendered from the given views alone, and compared (render/quality/protocol.h).
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "commands/options/scene_options.h"
#include "commands/rendering/protocol_result.h"
#include "core/base/progress.h"
#include "core/light_field/light_field.h"
#include "render/fields/field_options.h"
#include "render/quality/protocol.h"

namespace ulf::commands {

struct ProtocolArgs {
  std::string protocol;  // "llff", "nerf-synthetic", "every:N", or a file; empty: not requested
  std::string against;   // folder of another light field (against.h); empty: none
  std::string out;       // new folder for pictures and results; empty: nothing is written
  // Longer side of photographs for geometry, largest number of depth maps; 0: as in `ulf proxy`.
  int geometry_px = 0, geometry_maps = 0;
  bool refine = false;  // refines lens and poses first (refined_split.h)
};

void AddProtocolOptions(CLI::App& sub, ProtocolArgs& args);

// Returns the photograph's name relative to images/ if it lies there; it never leaves an output folder.
std::string NameInSet(const View& view);
// Throws Error if two of these views (indices) differ by their ending alone: both would be written to one
// file.
void RequireDifferentNames(const LightField& light_field, const std::vector<int>& views);

// Sets pixels of a left-out view (its index in the light field) to 0 that are not to be compared; CV_8U.
using LeaveOutPixels = std::function<void(int view, cv::Mat& valid)>;

// Renders the split's test views of `all` from the given ones and compares them with their photographs. The
// best of `fields` is chosen by evidence; empty: of all. Pictures and mesh are written to `folder`, if it is
// not empty. Throws UsageError for a proxy that the given views cannot make.
ProtocolResult EvaluateSplit(LightField all, const render::ProtocolSplit& split, const ProtocolArgs& args,
                             const SceneArgs& scene_args, const std::vector<render::FieldOptions>& fields,
                             const std::filesystem::path& folder, Progress& progress,
                             const LeaveOutPixels& leave_out = {});

// Prints the result as a table, or as one JSON object if `json`, and returns kOk. Throws as EvaluateSplit()
// does.
int RunProtocol(const ProtocolArgs& args, const SceneArgs& scene_args,
                const std::vector<render::FieldOptions>& fields, bool json);

}  // namespace ulf::commands

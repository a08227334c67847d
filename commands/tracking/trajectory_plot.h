// Draws a tracked run: the path from above and from behind in equal axes, truth against live and final poses
// (aligned with it), with the stretches where the camera was lost; below, error, quality and points over
// time.
//
// Right, forward and up are those of the mean camera: a scanning hand holds its camera upright.
#pragma once

#include <string>

#include "commands/tracking/track_report.h"

namespace ulf::commands {

// `errors`: null without a truth; lengths are map units then. Throws as DrawChart() does.
void PlotRun(const std::string& path, const TrackRun& run, const TrackErrors* errors,
             const std::string& title);

}  // namespace ulf::commands

// The rolling shutter in `ulf export`: the poses of the first and the last row, or `--global-shutter`.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/light_field.h"
#include "tracking/refine/view_rows.h"

namespace ulf::commands {

struct ExportedShutter {
  std::map<int, tracking::ViewRows> rows;    // of views that moved meanwhile, by id
  std::optional<LightField> at_one_instant;  // what is exported in place of the light field
  std::string words;                         // a sentence for the report; empty: there is nothing to say
};

// Reads the rows from the light field's own points, before they are measured anew. With `is_global` throws
// UsageError if the light field knows no readout, or no view's velocity.
ExportedShutter ShutterOf(const LightField& light_field, bool is_global, ExportForm form);

// Sets the options of the export: edge poses, or with `is_global` the resampling, and then also
// `at_one_instant`. Both arguments must outlive the export.
void SetShutter(const LightField& light_field, bool is_global, ExportedShutter& shutter,
                ExportOptions& options);

}  // namespace ulf::commands

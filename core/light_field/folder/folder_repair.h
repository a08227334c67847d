// Repairs the folder of a light field: restores views that the journal has lost from transforms.json or
// sparse/0, makes photographs that differ from their masters again, and writes all derived files. Nothing is
// deleted: replaced files go to kept/, files of removed views to unposed/.
#pragma once

#include <filesystem>

#include "core/light_field/folder/repair_plan.h"

namespace ulf {

// Executes the plan of PlanRepair() under the lock of the journal and returns it. A process killed at any
// moment leaves the old journal or the new one. Throws DiskFullError, Error; files that were moved to kept/
// stay there.
RepairPlan Repair(const std::filesystem::path& dir);

}  // namespace ulf

// Putting a light field's folder in order from what its files still hold: views that the journal has lost
// come back from transforms.json or sparse/0, photographs that are not their masters' are made anew, what is
// derived is written anew. Nothing is deleted: what is replaced goes to kept/, what is taken out to unposed/.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

struct RepairPlan {
  std::vector<std::string> found;     // what is wrong
  std::vector<std::string> steps;     // what would be done about it; empty: nothing can or need be done
  std::vector<std::string> not_done;  // by Repair(), of what was planned
  std::size_t views_before = 0, views_after = 0, damaged_lines = 0;

  // What the steps consist of.
  std::optional<LightField> header;     // where the journal has none of its own,
  std::string header_from;              // and the file that tells it
  std::map<int, View> recovered;        // views for the journal, by id
  std::map<int, Rigid3> poses;          // of views that the journal has
  std::map<int, CameraModel> cameras;   // likewise, by index
  std::vector<int> taken_out;           // views whose photograph is gone
  std::vector<int> pictures_of_others;  // views whose photograph is not their master's
  std::optional<LightField> settings;   // subject, up, goal, capture time that the journal has lost
  std::uint64_t longest_stamp = 0;      // bytes of the journal that a derived file was made from
  bool new_journal = false, new_derived = false, missing_pictures = false;
  bool damaged_points = false, other_transforms = false, other_model = false;  // files that go to kept/
  bool any() const { return !steps.empty(); }
};

// What Repair() would do. Reads only. Throws Error where the folder holds nothing to make a light field from,
// or somebody is writing to it.
RepairPlan PlanRepair(const std::filesystem::path& dir);

// Does it; returns what was planned under the lock. A kill at any moment leaves the old journal or the new
// one. Throws DiskFullError, Error; what went to kept/ by then stays there.
RepairPlan Repair(const std::filesystem::path& dir);

}  // namespace ulf

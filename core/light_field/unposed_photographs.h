// The photographs in unposed/ that may become views once somebody has found where they were taken: those that a
// capture kept without a pose, and any other picture that a person has put there. Views that were taken back, whose
// files begin with their number, stay what they are.
#pragma once

#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

struct UnposedPhotograph {
  View view;  // id 0 and no pose; `camera` is the journal's, else the first one whose size the picture has
  std::string problem;  // why it cannot be used; empty: it can
};

// In the order of their names, without those whose bytes are a view's already (a writer was killed after it had
// made the photograph a view). Reads the folder, writes nothing.
std::vector<UnposedPhotograph> UnposedPhotographs(const LightField& light_field);

}  // namespace ulf

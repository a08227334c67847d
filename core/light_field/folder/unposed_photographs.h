// The photographs in unposed/ that may become views once somebody has found where they were taken: those that
// a capture kept without a pose, and any other picture that a person has put there. The files of views that
// were taken back begin with the view's number and stay what they are.
#pragma once

#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

// In the order of their names, without those whose bytes are a view's already (a writer was killed after it
// had made the photograph a view). A view's camera is the journal's, else the first one whose size the
// picture has. Reads the folder, writes nothing.
std::vector<UnposedPhotograph> UnposedPhotographs(const LightField& light_field);

// Of the views that were taken back, those whose files lie there: one whose photograph has become a view
// again does not count.
std::size_t CountTakenBack(const LightField& light_field);

}  // namespace ulf

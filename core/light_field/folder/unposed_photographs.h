// Finds the photographs in unposed/ that may become views once their pose is known: those that a capture kept
// without a pose, and any other picture that a person has put there. The names of files of views that were
// taken back begin with the view's number; they are ignored.
#pragma once

#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

// Returns them in order of names, without those whose bytes a view has already (a writer was killed after it
// had made the photograph a view). A view's camera is the journal's, or else the first one of the picture's
// size. It reads the folder and writes nothing.
std::vector<UnposedPhotograph> UnposedPhotographs(const LightField& light_field);

// Counts the views taken back whose files lie there, except photographs that have become views again.
std::size_t CountTakenBack(const LightField& light_field);

}  // namespace ulf

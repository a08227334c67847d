// Finds the photographs in unposed/ that may become views once their pose is known: those that a capture kept
// without a pose, and other JPEG, PNG, TIFF and EXR pictures that a person has put there. Files of views that
// were taken back, whose names begin with the view's number, are ignored.
#pragma once

#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

// Returns them in order of names, without those whose bytes a view has already (a writer was killed after it
// had made the photograph a view). The camera is the one that the journal notes, or else the first one of the
// picture's size; `problem` says if there is none, or if the picture is not 8-bit. Changes no file.
std::vector<UnposedPhotograph> UnposedPhotographs(const LightField& light_field);

// Counts the views taken back whose files lie there.
std::size_t CountTakenBack(const LightField& light_field);

}  // namespace ulf

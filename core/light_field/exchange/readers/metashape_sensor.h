// The lens of a sensor of Metashape's XML (its manual, appendix "Camera models").
#pragma once

#include <string>

#include "core/geometry/camera_model.h"
#include "core/light_field/formats/fitted_lens.h"
#include "core/light_field/formats/xml_file.h"

namespace ulf {

// Returns the element's label in quotes, for messages.
std::string LabelOf(const XmlElement& element);

// Takes the adjusted calibration, or the only other one. Terms that our lenses lack are fitted and noted in
// `fitted`. Throws Error that names file, line and sensor for one without a calibration, of another type than
// `frame` and `fisheye`, or with terms that no lens of ours fits.
CameraModel ModelOfSensor(const XmlElement& sensor, FittedLenses& fitted);

}  // namespace ulf

#include "tests/stability/curve.h"

namespace ulf::test {

std::vector<Curve> GeometryCurves() { return {}; }

}  // namespace ulf::test

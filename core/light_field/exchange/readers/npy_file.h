// Reads arrays of numpy.save() (versions 1 to 3): floating point of 4 or 8 bytes, one or two dimensions.
#pragma once

#include <Eigen/Core>
#include <filesystem>

namespace ulf {

// Returns a row for each entry of the first dimension. Throws an Error that names the file if it is of
// another kind, truncated, empty, or of an unsupported type or shape.
Eigen::MatrixXd ReadNpyMatrix(const std::filesystem::path& file);

}  // namespace ulf

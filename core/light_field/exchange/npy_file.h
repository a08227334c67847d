// Arrays that numpy.save() wrote (NumPy's format, versions 1 to 3): numbers of 4 or 8 bytes in one or two
// dimensions.
#pragma once

#include <Eigen/Core>
#include <filesystem>

namespace ulf {

// A row for each entry of the first dimension. Throws Error that names the file for another kind of file, one
// that is cut short or whose shape disagrees with its size, and for a type of number or a shape that is not
// supported.
Eigen::MatrixXd ReadNpyMatrix(const std::filesystem::path& file);

}  // namespace ulf

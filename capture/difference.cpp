#include "capture/difference.hpp"

#include <iterator>
#include <map>
#include <sstream>
#include <vector>

namespace ferrule {

Eigen::RowVectorXd largest_by_unit(const Eigen::Ref<const Eigen::MatrixXd>& values,
                                   const std::string& units) {
  std::istringstream words(units);
  std::vector<std::string> unit{std::istream_iterator<std::string>(words), {}};
  if (unit.size() != static_cast<std::size_t>(values.cols()))
    unit.assign(static_cast<std::size_t>(values.cols()), units);
  std::map<std::string, double> largest;
  for (Eigen::Index c = 0; c < values.cols() && values.rows() > 0; ++c) {
    double& most = largest[unit[static_cast<std::size_t>(c)]];
    most = std::max(most, values.col(c).cwiseAbs().maxCoeff());
  }
  Eigen::RowVectorXd scale(values.cols());
  for (Eigen::Index c = 0; c < values.cols(); ++c)
    scale[c] = largest[unit[static_cast<std::size_t>(c)]];
  return scale;
}

}  // namespace ferrule

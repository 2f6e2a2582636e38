// A number of a scene on the scale that a fit moves it on.
//
// The scale is logarithmic in the number's distance from what the scene does not allow (from zero
// for a work of adhesion, from the fibre's diameter for a bore's); with limits on both sides, in
// the ratio of both distances; linear without any. Coordinate 0 is where it starts, and log(10), a
// factor of 10 of that distance or ratio, is as far as it may go on either side.
#pragma once

#include <functional>
#include <string>

#include "sim/scene/scene.hpp"

namespace ferrule {

class SceneNumber {
 public:
  static constexpr double kRange = 2.302585092994046;  // log(10): bound of the coordinate

  // `key`: dotted name of a number of the scene. Throws BadInput if it is none, or cannot be
  // varied.
  SceneNumber(const Scene& scene, const std::string& key);

  const std::string& key() const { return key_; }
  double start() const { return start_; }
  // At a coordinate, in the unit of the scene file.
  double value(double coordinate) const;

 private:
  double edge(const std::function<bool(double)>& allowed, double sign) const;

  std::string key_;
  double start_, below_, above_;
};

}  // namespace ferrule

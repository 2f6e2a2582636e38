#include "controller/touch_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ferrule {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kFirstSides = 8, kFurtherSides = 4, kEdgeSides = 3;
constexpr int kEdgesInARow = 2;
constexpr double kFurthestApart = 4;                         // of the tilt
constexpr double kClearanceError = 0.7, kMouthError = 0.01;  // of its logarithm
constexpr double kUnexplained = 10;                          // of the error of a height
constexpr double kSteepest = 0.03;  // slope of an end, twice that of a bad cleave [rad]
constexpr double kBelow = 0.1;      // of the lift: by which it rests lower than on the face
constexpr double kDeep = 2;         // likewise: lower than a bore without a cone lets it

}  // namespace

double TouchSearch::play(double height) const noexcept {
  const double widened =
      n_.lead_in_length > 0 ? std::clamp(height / n_.lead_in_length, 0.0, 1.0) : 0;
  return clearance() + widened * (n_.mouth_radius - n_.bore_radius);
}

double TouchSearch::height_of(double play) const noexcept {
  const double widened = (play - clearance()) / (n_.mouth_radius - n_.bore_radius);
  return n_.lead_in_length > 0 ? widened * n_.lead_in_length : 0;
}

void TouchSearch::rested(const Touch& touch, double height) {
  const bool was_upright = upright();
  highest_ = begun_ ? std::max(highest_, touch.x) : touch.x;
  if (was_upright) recognise(touch.x, height);
  begun_ = true;
  rested_ = touch.x;
  touches_.push_back(touch);
  if (!located_) opening_.face = touches_.front().x;
  if (was_upright)
    first_sides();
  else if (side_ == sides_)
    further_sides();
  next_ = {here_, Vector2d::Zero()};
  if (upright()) return;
  const double angle =
      2 * std::numbers::pi * static_cast<double>(side_++) / static_cast<double>(sides_);
  next_.tilt = centre_ + apart_ * Vector2d(std::cos(angle), std::sin(angle));
}

// Whether it rests on an edge or on the face, and which of the earlier touches are still of use.
void TouchSearch::recognise(double x, double height) {
  height_ = height;
  const double face = n_.lead_in_length - n_.near;  // as low as one may be
  const bool deep = x < highest_ - reach() - kDeep * n_.lift;
  has_cone_ = has_cone_ || deep || (height > n_.near && height < face);
  const bool below = located_ && x < opening_.face - reach() - kBelow * n_.lift;
  edge_ = x;
  on_edge_ = has_cone_ ? height < face : (below || unexplained_) && edges_ < kEdgesInARow;
  edges_ = on_edge_ ? edges_ + 1 : 0;
  unexplained_ = false;
  if ((below && !on_edge_) || std::abs(x - rested_) > n_.lift) touches_.clear();
  first_ = touches_.size();
}

void TouchSearch::first_sides() {
  here_ = touches_.back().across;
  apart_ = n_.tilt;
  side_ = 0;
  if (on_edge_) {
    sides_ = kEdgeSides;
    centre_.setZero();
    return;
  }
  sides_ = touches_.size() > 1 ? kFurtherSides : kFirstSides;
  if (touches_.size() > 1) locate();
  centre_ = -opening_.slope;
}

void TouchSearch::further_sides() {
  side_ = sides_ = 0;
  if (on_edge_) return leave_edge();
  locate();
  if (opening_.misfit > kUnexplained * kHeightError * n_.fibre_radius ||
      opening_.slope.norm() > kSteepest) {
    unexplained_ = true;
    located_ = false;
    touches_.clear();
    opening_ = {};
    opening_.face = edge_;
  } else if ((opening_.slope + centre_).norm() > 0.5 * apart_) {
    centre_ = -opening_.slope;
    apart_ = std::min(2 * apart_, kFurthestApart * n_.tilt);
    sides_ = kFurtherSides;
  } else {
    here_ = opening_.axis;
  }
}

void TouchSearch::locate() {
  const double r = n_.fibre_radius;
  // Near the entrance it is the face of a bore without a cone.
  const bool mouth = has_cone_ || height_ > n_.near;
  const double off = mouth ? off_axis() : clearance();
  const double known = mouth ? kMouthError : kClearanceError;
  opening_ = locate_opening(touches_, {r, r + off},
                            {.height = kHeightError * r, .far = r, .clearance = known});
  located_ = true;
  // What rests is not within the opening.
  const Vector2d e = touches_.back().across - opening_.axis;
  if (e.norm() < opening_.clearance && e.norm() > 0)
    opening_.axis = touches_.back().across - opening_.clearance * e.normalized();
}

void TouchSearch::leave_edge() {
  Vector2d caught = Vector2d::Zero();
  for (std::size_t k = first_ + 1; k < touches_.size(); ++k)
    caught += (touches_[k].x - touches_[first_].x) * touches_[k].tilt;
  touches_.resize(first_);
  if (!(caught.norm() > 0)) return;
  caught.normalize();
  if (edges_ == 1 || !(step_ < off_axis())) step_ = off_axis();
  if (edges_ > 1 && caught.dot(caught_) < 0) step_ *= 0.5;
  caught_ = caught;
  here_ -= step_ * caught;
}

}  // namespace ferrule

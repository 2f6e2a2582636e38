#include "capture/felt_difference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

constexpr double kStretch = 1e-6;  // [m]

struct Stretch {
  Vector3d sum = Vector3d::Zero();  // of the felt force [N]
  double rows = 0, touching = 0;

  Vector3d felt() const { return sum / rows; }
  bool touches() const { return 2 * touching >= rows; }
};

// By the place of the holder.
std::map<long, Stretch> stretches(const Episode& episode, const Scene& scene) {
  const double to_hand = scene_scaling(scene).force;
  const RowVector rest = episode.rows.row(0);
  std::map<long, Stretch> places;
  for (Eigen::Index n = 0; n < episode.rows.rows(); ++n) {
    const RowVector row = episode.rows.row(n);
    Stretch& there = places[std::lround(row[state_column("hand_x")] / kStretch)];
    there.sum += to_hand * (row - rest).segment<3>(kHolder.begin).transpose();
    ++there.rows;
    there.touching += touches(row);
  }
  return places;
}

// Collects stretches.
class Apart {
 public:
  void add(double difference, bool told_apart) {
    sizes_.push_back(difference);
    noticed_ += told_apart;
  }
  FeltApart result() {
    if (sizes_.empty()) return {0, std::numeric_limits<double>::quiet_NaN(), 0, 0};
    std::sort(sizes_.begin(), sizes_.end());
    return {sizes_.size(), noticed_ / static_cast<double>(sizes_.size()), sizes_[sizes_.size() / 2],
            sizes_.back()};
  }

 private:
  std::vector<double> sizes_;
  double noticed_ = 0;
};

}  // namespace

FeltDifference felt_difference(const Episode& a, const Scene& scene_a, const Episode& b,
                               const Scene& scene_b) {
  const std::map<long, Stretch> in_a = stretches(a, scene_a), in_b = stretches(b, scene_b);
  Apart all, either, both;
  for (const auto& [place, of_a] : in_a) {
    const auto found = in_b.find(place);
    if (found == in_b.end()) continue;
    const Stretch& of_b = found->second;
    const double difference = (of_a.felt() - of_b.felt()).norm();
    const double larger = std::max(of_a.felt().norm(), of_b.felt().norm());
    const bool told_apart = difference >= std::max(kNoticedForce, kNoticedShare * larger);
    all.add(difference, told_apart);
    if (of_a.touches() || of_b.touches()) either.add(difference, told_apart);
    if (of_a.touches() && of_b.touches()) both.add(difference, told_apart);
  }
  return {all.result(), either.result(), both.result()};
}

}  // namespace ferrule

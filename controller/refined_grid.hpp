// Where a function over a rectangle crosses zero, found with few of its values: a grid of squares
// that is refined where the function changes sign (a quadtree), and the contour through the finest
// of them (marching squares, Lorensen and Cline 1987, in two dimensions).
//
// Positions are in cells of the finest grid: from 0 to `cells` in either direction.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace ferrule {

class RefinedGrid {
 public:
  using Node = std::array<int, 2>;
  using Line = std::vector<Eigen::Vector2d>;  // closed where its last point is its first

  static constexpr int kCoarsest = 4;  // squares in either direction to begin with

  // `cells`: a power of 2, at least kCoarsest. Throws std::invalid_argument.
  explicit RefinedGrid(int cells);

  // The nodes whose values are wanted next, all of which must be set before it is called again;
  // none: wherever the sign changes between neighbours of the squares so far, the squares are the
  // finest. What is smaller than the coarsest squares may be missed.
  std::vector<Node> next();
  void set(const Node& node, double value) { values_[node] = value; }

  // The grid of `cells`, a part of those of this one, with the values of this one; empty where it
  // would want more of them.
  std::optional<RefinedGrid> coarser(int cells) const;

  int cells() const noexcept { return cells_; }
  const std::map<Node, double>& values() const noexcept { return values_; }
  // The nodes at which edges of finest squares end, on which the sign changes.
  std::set<Node> beside_contour() const;
  // Through the finest squares, linear between their nodes, zero counted as positive. Each line
  // ends at the rectangle's edge, or where squares are not refined yet, or is closed.
  std::vector<Line> contour() const;

 private:
  struct Square {
    Node low;
    int size;
  };
  double value(const Node& node) const { return values_.at(node); }
  bool positive(const Node& node) const { return value(node) >= 0; }
  bool cut(const Square& square) const;
  // Of the finest squares whose nodes are all known: the nodes counterclockwise from the lowest.
  std::vector<std::array<Node, 4>> finest() const;

  int cells_;
  std::vector<Square> squares_;  // the leaves
  std::map<Node, double> values_;
};

}  // namespace ferrule

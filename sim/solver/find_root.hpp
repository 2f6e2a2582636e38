// Where a condition ends, between a point at which it holds and one at which it does not.
#pragma once

namespace ferrule {

template <class Point>
struct Bracket {
  Point holds, fails;
};

// Bisections of a step: an event on it is found to a 256th of it.
inline constexpr int kBisections = 8;

// The bracket after so many bisections. `holds(point)` is true at bracket.holds and false at
// bracket.fails; where it changes more than once between them, any of these places is found.
// `middle(holds, fails)` is the point between two that is tried.
template <class Point, class Holds, class Middle>
Bracket<Point> bisect(Bracket<Point> bracket, int times, const Holds& holds, const Middle& middle) {
  for (int n = 0; n < times; ++n) {
    const Point tried = middle(bracket.holds, bracket.fails);
    (holds(tried) ? bracket.holds : bracket.fails) = tried;
  }
  return bracket;
}

inline double midpoint(double a, double b) noexcept {
  return 0.5 * (a + b);
}

}  // namespace ferrule

// A gain of a parametric law: what it is called and what it is measured in.
#pragma once

namespace ferrule {

struct Gain {
  const char* name;
  const char* symbol;
  const char* unit;
  // A gain that the law divides by is positive; one that stands for a size is not negative.
  enum Range { any, not_negative, positive } range = any;
};

}  // namespace ferrule

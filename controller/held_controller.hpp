// A controller that was made for a lower rate: asked every so many periods, it holds its velocity
// in between.
#pragma once

#include "controller/controller.hpp"

namespace ferrule {

class HeldController : public ControllerWrapper {
 public:
  // `periods` >= 1.
  HeldController(std::unique_ptr<Controller> inner, std::uint64_t periods)
      : ControllerWrapper(std::move(inner)), periods_(periods) {}
  HandTwist command(const Observation& observation) noexcept override {
    if (tick_++ % periods_ == 0) velocity_ = inner_->command(observation);
    return velocity_;
  }

 private:
  std::uint64_t periods_, tick_ = 0;
  HandTwist velocity_ = HandTwist::Zero();
};

// Those of `make`, each asked every so many periods.
inline MakeController held(const MakeController& make, std::uint64_t periods) {
  if (periods == 1) return make;
  return [make, periods](std::uint64_t trial) {
    return std::make_unique<HeldController>(make(trial), periods);
  };
}

}  // namespace ferrule

#include "app/training_plot.hpp"

#include <fmt/format.h>

namespace ferrule {

Plot training_plot(const std::vector<std::vector<Epoch>>& curves) {
  Axes axes{"epoch", "negative log likelihood per row", false, false, {}};
  for (std::size_t m = 0; m < curves.size(); ++m) {
    const std::string member = curves.size() > 1 ? fmt::format(" {}", m + 1) : std::string();
    Series training{"training" + member, {}, {}}, held_out{"held out" + member, {}, {}};
    for (std::size_t i = 0; i < curves[m].size(); ++i)
      for (Series* s : {&training, &held_out}) {
        s->x.push_back(static_cast<double>(i + 1));
        s->y.push_back(s == &training ? curves[m][i].training_loss : curves[m][i].held_out_loss);
      }
    axes.series.push_back(training);
    axes.series.push_back(held_out);
  }
  return {"Training: loss with input noise, and of the held-out episodes", {axes}};
}

}  // namespace ferrule

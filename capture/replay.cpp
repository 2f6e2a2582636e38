#include "capture/replay.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "insertion/loop.hpp"

namespace ferrule {
namespace {

// The recorded hand as a device.
class RecordedHand : public Device {
 public:
  explicit RecordedHand(const EpisodeRows& episode) : rows_(episode) {
    const EpisodeInfo& info = episode.info();
    if (info.outcome == Outcome::gave_up) gave_up_ = info.why.c_str();
  }

  HandSample read(double) override {
    const Eigen::Index n = next_++;
    if (n < rows_.count()) return {rows_.row(n).segment<kPose>(kHandPose.begin).transpose(), false};
    // The pose after the last row is not recorded; its command says where it was.
    const RowVector last = rows_.row(rows_.count() - 1);
    return {(block(last, kHandPose) + rows_.info().period * block(last, kCommand)).transpose(),
            true, gave_up_};
  }
  void render(const HandWrench&) override {}

 private:
  const EpisodeRows& rows_;
  const char* gave_up_ = nullptr;  // the operator's decision, and not a result
  Eigen::Index next_ = 0;
};

std::string column_name(Eigen::Index column) {
  for (const Block& b : kBlocks)
    if (column < b.end()) return fmt::format("{}[{}]", b.name, column - b.begin);
  return "?";
}

// Of each column the largest number of its unit in its block.
Eigen::RowVectorXd row_scale(const EpisodeRows& rows) {
  Eigen::RowVectorXd scale = Eigen::RowVectorXd::Zero(kRowSize);
  for (Eigen::Index n = 0; n < rows.count(); n += EpisodeRows::kBlock)
    for (const Block& b : kBlocks) {
      const Eigen::RowVectorXd largest =
          largest_by_unit(rows.part_of(n).rows.middleCols(b.begin, b.width), units(b));
      scale.segment(b.begin, b.width) = scale.segment(b.begin, b.width).cwiseMax(largest);
    }
  return scale;
}

// The recorded insertion again, tick by tick.
InsertionEnd insert_again(const Scene& scene, const EpisodeRows& episode, const OnTick& on_tick) {
  const EpisodeInfo& info = episode.info();
  RecordedHand hand(episode);
  return run_insertion(recorded_setup(info, scene), hand,
                       {.period = info.period, .past_success = true, .recorded = true}, on_tick);
}

}  // namespace

void verify(const EpisodeRows& episode, Verification& comparison) {
  const EpisodeInfo& info = episode.info();
  const Scene scene = recorded_scene(info, "the episode's scene");
  std::optional<Eigen::RowVectorXd> scales;  // once something differs
  const auto scale = [&](Eigen::Index column) {
    if (!scales) scales = row_scale(episode);
    return (*scales)[column];
  };
  Eigen::Index n = 0;
  const InsertionEnd end = insert_again(scene, episode, [&](const Tick& tick) {
    RowVector recomputed = make_row(tick);
    // The last command is what the recorded hand was built from, not a result.
    const RowVector recorded = episode.row(n);
    if (n == episode.count() - 1)
      recomputed.segment<kPose>(kCommand.begin) = block(recorded, kCommand);
    compare_numbers(recorded, recomputed, scale, static_cast<std::size_t>(n), column_name,
                    comparison);
    ++n;
    return !comparison.over();
  });
  if (comparison.over()) return;
  // Recordings of before called a failure past the success depth their outcome.
  const bool same = end.outcome == info.outcome || info.outcome == Outcome::interrupted ||
                    end.afterwards == info.outcome;
  if (n != episode.count() || !same)
    comparison.add({static_cast<std::size_t>(std::max<Eigen::Index>(0, n - 1)), "outcome",
                    name(info.outcome), name(end.outcome)});
}

std::optional<Difference> verify(const EpisodeRows& episode) {
  Verification comparison;
  verify(episode, comparison);
  return comparison.first;
}

TracedStep trace_step(const EpisodeRows& episode, std::optional<Eigen::Index> at) {
  const EpisodeInfo& info = episode.info();
  const Scene scene = recorded_scene(info, "the episode's scene");
  StepResult last(recorded_setup(info, scene).start), before;
  Pose command;
  TracedStep traced;
  Eigen::Index row = 0;
  int most = -1;
  insert_again(scene, episode, [&](const Tick& tick) {
    if (at ? row == *at : tick.result.evaluations > most) {
      most = tick.result.evaluations;
      before = last;
      command = tick.result.state.command;
      traced.dt = row == 0 ? 0 : info.period;
    }
    last = tick.result;
    return row++ != at;
  });
  traced.before = before.state;
  traced.result = before;
  step_on(scene.world, command, traced.dt, traced.result, &traced.trace);
  return traced;
}

}  // namespace ferrule

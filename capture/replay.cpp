#include "capture/replay.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "insertion/loop.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

// The recorded hand as a device.
class RecordedHand : public Device {
 public:
  explicit RecordedHand(const Episode& episode)
      : rows_(episode.rows), period_(episode.info.period) {
    if (episode.info.outcome == Outcome::gave_up) gave_up_ = episode.info.why.c_str();
  }

  HandSample read(double) override {
    const Eigen::Index n = next_++;
    if (n < rows_.rows()) return {rows_.row(n).segment<kPose>(kHandPose.begin).transpose(), false};
    // The pose after the last row is not recorded; its command says where it was.
    const Eigen::Index last = rows_.rows() - 1;
    return {(rows_.row(last).segment<kPose>(kHandPose.begin) +
             period_ * rows_.row(last).segment<kPose>(kCommand.begin))
                .transpose(),
            true, gave_up_};
  }
  void render(const HandWrench&) override {}

 private:
  const Rows& rows_;
  double period_;
  const char* gave_up_ = nullptr;  // the operator's decision, and not a result
  Eigen::Index next_ = 0;
};

std::string column_name(Eigen::Index column) {
  for (const Block& b : kBlocks)
    if (column < b.begin + b.width) return fmt::format("{}[{}]", b.name, column - b.begin);
  return "?";
}

// Of each column the largest number of its unit in its block.
Eigen::RowVectorXd row_scale(const Rows& rows) {
  const std::string contact = " 1 m m m m 1", pose = " m m m rad rad";
  const std::string rates = " m/s m/s m/s rad/s rad/s";
  Eigen::RowVectorXd scale(kRowSize);
  for (const Block& b : kBlocks)
    scale.segment(b.begin, b.width) = largest_by_unit(
        rows.middleCols(b.begin, b.width),
        b.begin == kStates.begin
            ? pose + pose + " s 1 1" + contact + contact + rates + pose + rates + " s J"
            : b.unit);
  return scale;
}

// The recorded insertion again, tick by tick.
InsertionEnd insert_again(const Scene& scene, const Episode& episode, const OnTick& on_tick) {
  const EpisodeInfo& info = episode.info;
  RecordedHand hand(episode);
  return run_insertion(scene, draw_start(scene, info.seed, info.trial), hand,
                       ForceSensor(scene.sensor, info.seed, info.trial),
                       {.scaling = scene_scaling(scene),
                        .period = info.period,
                        .past_success = true,
                        .recorded = true},
                       on_tick);
}

}  // namespace

void verify(const Episode& episode, Verification& comparison) {
  const Scene scene = recorded_scene(episode, "the episode's scene");
  const Rows& rows = episode.rows;
  const EpisodeInfo& info = episode.info;
  const Eigen::RowVectorXd scale = row_scale(rows);
  Eigen::Index n = 0;
  const InsertionEnd end = insert_again(scene, episode, [&](const Tick& tick) {
    RowVector recomputed = make_row(tick);
    // The last command is what the recorded hand was built from, not a result.
    if (n == rows.rows() - 1)
      recomputed.segment<kPose>(kCommand.begin) = rows.row(n).segment<kPose>(kCommand.begin);
    compare_numbers(rows.row(n), recomputed, scale, static_cast<std::size_t>(n), column_name,
                    comparison);
    ++n;
    return !comparison.over();
  });
  if (comparison.over()) return;
  // Recordings of before called a failure past the success depth their outcome.
  const bool same = end.outcome == info.outcome || info.outcome == Outcome::interrupted ||
                    end.afterwards == info.outcome;
  if (n != rows.rows() || !same)
    comparison.add({static_cast<std::size_t>(std::max<Eigen::Index>(0, n - 1)), "outcome",
                    name(info.outcome), name(end.outcome)});
}

std::optional<Difference> verify(const Episode& episode) {
  Verification comparison;
  verify(episode, comparison);
  return comparison.first;
}

TracedStep trace_step(const Episode& episode, std::optional<Eigen::Index> at) {
  const Scene scene = recorded_scene(episode, "the episode's scene");
  StepResult last(draw_start(scene, episode.info.seed, episode.info.trial)), before;
  Pose command;
  TracedStep traced;
  Eigen::Index row = 0;
  int most = -1;
  insert_again(scene, episode, [&](const Tick& tick) {
    if (at ? row == *at : tick.result.evaluations > most) {
      most = tick.result.evaluations;
      before = last;
      command = tick.result.state.command;
      traced.dt = row == 0 ? 0 : episode.info.period;
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

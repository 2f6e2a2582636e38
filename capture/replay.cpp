#include "capture/replay.hpp"

#include <fmt/format.h>

#include <cstring>

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

std::string column_name(int column) {
  for (const Block& b : kBlocks)
    if (column < b.begin + b.width) return fmt::format("{}[{}]", b.name, column - b.begin);
  return "?";
}

}  // namespace

std::optional<Difference> verify(const Episode& episode) {
  const Scene scene =
      parse_scene(parse_json(episode.info.scene, "the episode's scene"), "the episode's scene");
  const Rows& rows = episode.rows;
  if (rows.rows() == 0) return std::nullopt;
  RecordedHand hand(episode);
  const EpisodeInfo& info = episode.info;
  std::optional<Difference> first;
  Eigen::Index n = 0;
  const InsertionEnd end = run_insertion(
      scene, draw_start(scene, info.seed, info.trial), hand,
      ForceSensor(scene.sensor, info.seed, info.trial),
      {.scaling = scene_scaling(scene), .period = info.period, .past_success = true},
      [&](const Tick& tick) {
        RowVector recorded = rows.row(n), recomputed = make_row(tick);
        // The last command is what the recorded hand was built from, not a result.
        if (n == rows.rows() - 1)
          recomputed.segment<kPose>(kCommand.begin) = recorded.segment<kPose>(kCommand.begin);
        for (int c = 0; c < kRowSize && !first; ++c)
          if (std::memcmp(&recorded[c], &recomputed[c], sizeof(double)) != 0)
            first =
                Difference{static_cast<std::size_t>(n), column_name(c), recorded[c], recomputed[c]};
        ++n;
        return !first;
      });
  if (first) return first;
  if (n != rows.rows())
    return Difference{static_cast<std::size_t>(n), "outcome", static_cast<double>(info.outcome),
                      static_cast<double>(end.outcome)};
  // Recordings of before called a failure past the success depth their outcome.
  if (end.outcome != info.outcome && info.outcome != Outcome::interrupted &&
      end.afterwards != info.outcome)
    return Difference{static_cast<std::size_t>(n - 1), "outcome", static_cast<double>(info.outcome),
                      static_cast<double>(end.outcome)};
  return std::nullopt;
}

}  // namespace ferrule

#include "capture/stored_episode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/child.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/watch.hpp"

namespace ferrule {
namespace {

using hdf5::Matrix;
using hdf5::Reader;
using hdf5::StoredTable;

EpisodeInfo read_info(const Reader& in, const std::string& file) {
  if (!in.has("format") || in.text("format") != kFormat)
    throw FileTrouble(file + ": not a ferrule episode");
  EpisodeInfo info;
  info.format = in.whole("format_version");
  if (info.format < 1 || info.format > kEpisodeFormat)
    throw FileTrouble(file + ": episode format " + std::to_string(info.format) +
                      "; this program reads format 1 to " + std::to_string(kEpisodeFormat));
  info.version = in.text("ferrule_version");
  info.build = in.text("build");
  info.scene = in.text("scene");
  info.operator_ = in.text("operator");
  info.seed = in.whole("seed");
  info.trial = in.whole("trial");
  info.period = in.number("period_s");
  try {
    info.outcome = outcome_from_name(in.text("outcome"));
    parse_scene(parse_json(info.scene, "scene"), "scene");
  } catch (const BadInput& error) {
    throw FileTrouble(file + ": damaged: " + error.what());
  }
  for (const auto& [key, value] : optional_texts(info))
    if (in.has(key)) *value = in.text(key);
  if (in.has(kInputsHash)) info.inputs_sha1 = in.text(kInputsHash);
  if (in.has("rating"))
    info.rating = static_cast<int>(std::min<std::uint64_t>(in.whole("rating"), 6));
  if (info.rating > 5) throw FileTrouble(file + ": damaged: rating must be from 1 to 5");
  if (!period_rule().allows(info.period))
    throw FileTrouble(
        fmt::format("{}: damaged: period_s = {:g}: {}", file, info.period, period_rule().text));
  return info;
}

// How many rows there are: as many as have the time of their number.
Eigen::Index count_rows(const Reader& in, double period, const std::string& file) {
  const StoredTable stored = in.table(rows_path(kTime), 1, -1);
  for (Eigen::Index first = 0; first < stored.rows(); first += hdf5::kChunk) {
    const Matrix times = stored.read(first, std::min(hdf5::kChunk, stored.rows() - first));
    for (Eigen::Index i = 0; i < times.rows(); ++i)
      if (!(std::abs(times(i, 0) - static_cast<double>(first + i) * period) <= 0.5 * period))
        throw FileTrouble(fmt::format("{}: damaged: {} at row {} is {:g}, with a period of {:g} s",
                                      file, rows_path(kTime), first + i, times(i, 0), period));
  }
  if (stored.rows() == 0) throw FileTrouble(file + ": damaged: it holds no rows");
  return stored.rows();
}

// What a child may take: at first, for a file that is returned, and with so many rows, each of
// which is there.
const MappedFile& allow_file(const MappedFile& file) {
  constexpr std::size_t kMost = 512 << 20;
  Child::Parent::allow(std::min(kMost, 16 * file.size()), file.size() >> 26);
  return file;
}
void allow_rows(Eigen::Index rows) {
  const auto count = static_cast<std::size_t>(rows);
  Child::Parent::allow(std::size_t{512} << 20, count / 4000);
}

}  // namespace

StoredEpisode::StoredEpisode(const MappedFile& file)
    : file_(file.name()),
      in_(allow_file(file), "a ferrule episode"),
      info_(read_info(in_, file_)),
      count_(count_rows(in_, info_.period, file_)) {
  allow_rows(count_);
  const auto open = [&](const std::string& path, Eigen::Index width) {
    tables_.emplace(path, in_.table(path, width, count_));
  };
  for (const Block& block : kBlocks) open(rows_path(block), block_of(block, info_.format).width);
  if (!info_.mapping.empty()) open(kCountsPath, kRawAxes);
  if (info_.outcome == Outcome::inserted) expect_inserted();
}

void StoredEpisode::expect_inserted() const {
  const Scene scene = recorded_scene(info_, file_);
  const double motion = scene_scaling(scene).motion;
  std::optional<InsertionWatch> watch;
  double next = 0;  // depth, at the end of the period that a row begins [m]
  for (Eigen::Index first = 0; first < count_; first += hdf5::kChunk) {
    const Eigen::Index count = std::min(hdf5::kChunk, count_ - first);
    Rows rows = Rows::Zero(count, kRowSize);
    for (const Block& block : {kStates, kHolder, kStatus, kCommand}) {
      const Matrix values = numbers(rows_path(block), first, count);
      rows.middleCols(block.begin, values.cols()) = values;
    }
    for (Eigen::Index n = 0; n < count; ++n) {
      const StepResult result = step_of(rows.row(n)).result;
      if (!watch) watch.emplace(scene, result.state);
      const std::optional<Outcome> seen = watch->after(result, nullptr);
      const double depth = watch->summary().depth;
      if (seen == Outcome::inserted) return;
      if (info_.format < kEpisodeFormat) {
        if (depth >= scene.success.depth) return;
      } else if (seen) {
        throw FileTrouble(
            fmt::format("{}: damaged: the outcome is inserted, but the rows end as {} at "
                        "{:g} s",
                        file_, name(*seen), result.state.time));
      }
      next = depth + info_.period * std::max(0.0, -rows(n, kCommand.begin)) / motion;
    }
  }
  // The row that ended it is missing where the hand's pose after it was not a number.
  if (!(next >= scene.success.depth))
    throw FileTrouble(fmt::format(
        "{}: damaged: the outcome is inserted, but the last row is {:.4g} um deep, not {:g} um",
        file_, 1e6 * watch->summary().depth, 1e6 * scene.success.depth));
}

Matrix StoredEpisode::numbers(const std::string& path, Eigen::Index first,
                              Eigen::Index count) const {
  Matrix values = tables_.at(path).read(first, count);
  for (Eigen::Index n = 0; n < count; ++n)
    if (!values.row(n).allFinite())
      throw FileTrouble(
          fmt::format("{}: damaged: {} at row {} is not a finite number", file_, path, first + n));
  return values;
}

EpisodeRows::Part StoredEpisode::read(Eigen::Index first, Eigen::Index count) const {
  EpisodeRows::Part part;
  part.rows.setZero(count, kRowSize);
  for (const Block& block : kBlocks) {
    const Matrix values = numbers(rows_path(block), first, count);
    part.rows.middleCols(block.begin, values.cols()) = values;
  }
  if (info_.mapping.empty()) return part;
  const Matrix counts = numbers(kCountsPath, first, count);
  if (!(counts.cwiseAbs().maxCoeff() <= INT32_MAX))
    throw FileTrouble(file_ + ": damaged: " + kCountsPath + " is beyond what a device counts");
  part.counts = counts.cast<std::int32_t>();
  return part;
}

}  // namespace ferrule
